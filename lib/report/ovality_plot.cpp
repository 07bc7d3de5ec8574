#include "report/ovality_plot.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "numerics/hotelling.hpp"
#include "report/canvas.hpp"
#include "report/gnuplot_text.hpp"

namespace ballbar {
namespace {

constexpr int kOvalityDrawing = 560;  // [px] of the square
constexpr int kEllipsePoints = 72;    // corners
constexpr double kSeen = 0.025;       // of the picture's half width: the smallest radius that is seen
constexpr double kLevel = 0.05;       // that the ellipse misses the true mean
constexpr int kMostDecades = 4;       // of enlargement

struct Set {
  const OvalityVectors* of;
  VectorSample sample;
  Eigen::Matrix2d shape = Eigen::Matrix2d::Zero();  // of the ellipse: its points are shape * unit circle
  bool has_ellipse = false;
  double radius = 0.0;  // [um] the longer half axis
  double spread = 0.0;  // [um] the repetition that is furthest from the mean
};

Set set_of(const OvalityVectors& set) {
  std::vector<Eigen::Vector2d> finite;
  std::copy_if(set.vectors_um.begin(), set.vectors_um.end(), std::back_inserter(finite),
               [](const Eigen::Vector2d& v) { return v.allFinite(); });
  Set found{&set, {}};
  if (finite.empty()) return found;
  found.sample = sample_of(finite);
  for (const Eigen::Vector2d& v : finite)
    found.spread = std::max(found.spread, (v - found.sample.mean).norm());
  const int dof = static_cast<int>(finite.size()) - 1;
  if (dof < 2) return found;
  const Eigen::Matrix2d region = t2_limit(kLevel, dof) * *found.sample.covariance_of_mean();
  const Eigen::LLT<Eigen::Matrix2d> root(region);
  if (root.info() != Eigen::Success) return found;
  found.shape = root.matrixL();
  found.has_ellipse = true;
  found.radius = std::sqrt(Eigen::SelfAdjointEigenSolver<Eigen::Matrix2d>(region).eigenvalues().maxCoeff());
  return found;
}

/// The smallest of 1, 2, 5 x 10^n that makes the largest scatter seen.
double magnification(const std::vector<Set>& sets, double half_width) {
  double largest = 0.0;
  for (const Set& set : sets) largest = std::max({largest, set.radius, set.spread});
  if (largest <= 0) return 1.0;
  for (int decade = 0; decade < kMostDecades; ++decade)
    for (const double step : {1.0, 2.0, 5.0})
      if (const double times = step * std::pow(10.0, decade); largest * times >= kSeen * half_width)
        return times;
  return std::pow(10.0, kMostDecades);
}

std::string row(const Eigen::Vector2d& v) {
  return plain_number(v.x(), 5) + " " + plain_number(v.y(), 5) + "\n";
}

}  // namespace

PlotScript ovality_script(const OvalityPlot& plot) {
  std::vector<Set> sets;
  Groups groups;
  Eigen::Vector2d low = Eigen::Vector2d::Zero();  // the origin is in the picture
  Eigen::Vector2d high = low;
  for (const OvalityVectors& vectors : plot.sets) {
    const Set set = set_of(vectors);
    if (set.sample.count == 0) continue;
    sets.push_back(set);
    groups.of(vectors.group);
    const double reach = std::max(set.radius, set.spread);
    low = low.cwiseMin(set.sample.mean - Eigen::Vector2d::Constant(reach));
    high = high.cwiseMax(set.sample.mean + Eigen::Vector2d::Constant(reach));
  }
  if (sets.empty()) throw Error(Cause::kInput, "plot: no circle has an ovality, so there are no vectors");
  const Eigen::Vector2d centre = (low + high) / 2;
  const double widest = (high - low).maxCoeff();
  const double half_width = widest > 0 ? 0.58 * widest : 1.0;
  const double times = magnification(sets, half_width);

  std::string blocks;
  std::string command;
  std::vector<std::string> notes = plot.notes;
  bool ellipses = false;
  for (std::size_t i = 0; i < sets.size(); ++i) {
    const Set& set = sets[i];
    const Eigen::Vector2d& mean = set.sample.mean;
    std::string points;
    for (const Eigen::Vector2d& v : set.of->vectors_um)
      if (v.allFinite()) points += row(mean + times * (v - mean));
    std::string ellipse;
    for (int k = 0; set.has_ellipse && k <= kEllipsePoints; ++k) {
      const double t = 2 * std::numbers::pi * k / kEllipsePoints;
      ellipse += row(mean + times * (set.shape * Eigen::Vector2d(std::cos(t), std::sin(t))));
    }
    const std::string number = std::to_string(i);
    blocks += join(
        {"$mean", number, " << EOD\n0 0\n", row(mean), "EOD\n$points", number, " << EOD\n", points, "EOD\n"});
    const Stroke stroke = stroke_of(groups.size(), groups.of(set.of->group), set.of->direction);
    std::string label = set.of->label + "   " + shown(mean.norm()) + " µm";
    if (set.has_ellipse) label += " ± " + shown(set.radius, 2);
    command += join({command.empty() ? "plot " : ", \\\n     ", "$mean", number,
                     " using 1:2 with lines linecolor rgb '", stroke.colour, "' linewidth 2 dashtype ",
                     stroke.dash, " title ", gnuplot_quoted(label), ", \\\n     $points", number,
                     " using 1:2 with points pointtype ", std::to_string(stroke.point),
                     " pointsize 0.5 linecolor rgb '", stroke.colour, "' notitle"});
    if (ellipse.empty()) continue;
    ellipses = true;
    blocks += join({"$ellipse", number, " << EOD\n", ellipse, "EOD\n"});
    command += join({", \\\n     $ellipse", number, " using 1:2 with lines linecolor rgb '", stroke.colour,
                     "' linewidth 1.6 notitle"});
  }
  if (ellipses)
    notes.push_back("Ellipses hold the true mean in 95 % of all cases; ± is their longer half axis.");
  if (times > 1)
    notes.push_back("Repetitions and ellipses are drawn " + plain_number(times, 0) +
                    " times as far from their mean as they are.");

  PlotScript script = canvas(plot.title, plot.subtitle, notes, sets.size(), kOvalityDrawing, kAxis);
  const auto range = [&](const char* axis, double middle) {
    return join({"set ", axis, "range [", plain_number(middle - half_width, 4), ":",
                 plain_number(middle + half_width, 4), "]\n"});
  };
  script.text += axes("ovality vector, cosine part [µm]", "ovality vector, sine part [µm]");
  script.text +=
      join({"set size ratio -1\nset yzeroaxis linecolor rgb '", kInk, "' linewidth 1.2 dashtype solid\n"}) +
      range("x", centre.x()) + range("y", centre.y());
  script.text += blocks + command + "\n";
  return script;
}

}  // namespace ballbar
