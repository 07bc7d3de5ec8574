#include "metrology/repeats.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <span>
#include <stdexcept>

#include "numerics/harmonics.hpp"
#include "numerics/statistics.hpp"

namespace ballbar {
namespace {

using Eigen::Vector2d;

struct Sample {
  double angle = 0.0;
  double deviation = 0.0;
};

/// By rising angle, without samples whose angle is not known.
std::vector<Sample> ordered(const RadialTrace& run) {
  if (run.angle.size() != run.deviation.size())
    throw std::invalid_argument("repeats: angles and deviations differ in number");
  std::vector<Sample> samples;
  for (std::size_t i = 0; i < run.angle.size(); ++i) {
    if (!std::isfinite(run.deviation[i])) throw std::invalid_argument("repeats: a deviation is not finite");
    if (std::isfinite(run.angle[i])) samples.push_back({run.angle[i], run.deviation[i]});
  }
  std::stable_sort(samples.begin(), samples.end(),
                   [](const Sample& a, const Sample& b) { return a.angle < b.angle; });
  return samples;
}

/// Linear between the neighbours; nothing outside of the samples or in a hole.
std::optional<double> at(double angle, const std::vector<Sample>& samples) {
  const auto after = std::lower_bound(samples.begin(), samples.end(), angle,
                                      [](const Sample& s, double a) { return s.angle < a; });
  if (after == samples.end()) return std::nullopt;
  if (after->angle == angle) return after->deviation;
  if (after == samples.begin()) return std::nullopt;
  const Sample& before = *(after - 1);
  const double width = after->angle - before.angle;
  if (width > kWidestHole) return std::nullopt;
  return before.deviation + (angle - before.angle) / width * (after->deviation - before.deviation);
}

/// Largest |mean| without the first harmonic.
double centred_accuracy(const RadialPath& path) {
  constexpr int kOrders = 10;  // so that ovality does not leak into order 1 where the arc is no full turn
  const auto n = static_cast<Eigen::Index>(path.angle.size());
  const Eigen::VectorXd angle = Eigen::Map<const Eigen::VectorXd>(path.angle.data(), n);
  const Eigen::VectorXd mean = Eigen::Map<const Eigen::VectorXd>(path.mean.data(), n);
  const HarmonicBasis basis(angle, kOrders);
  if (basis.order() < 1) return path.accuracy;  // so short an arc cannot tell a centre from a radius
  const Eigen::VectorXd first = basis.coefficients(mean);
  return (mean.array() - first[1] * angle.array().cos() - first[2] * angle.array().sin()).abs().maxCoeff();
}

void find_extremes(RadialPath& path) {
  for (std::size_t i = 0; i < path.angle.size(); ++i) {
    if (std::abs(path.mean[i]) >= path.accuracy) {
      path.accuracy = std::abs(path.mean[i]);
      path.accuracy_angle = path.angle[i];
    }
    if (!path.sd.empty() && 3.0 * path.sd[i] >= path.repeatability.value_or(0.0)) {
      path.repeatability = 3.0 * path.sd[i];
      path.repeatability_angle = path.angle[i];
    }
  }
}

}  // namespace

std::vector<RepeatedHarmonic> repeat_harmonics(const std::vector<std::vector<Harmonic>>& runs) {
  if (runs.empty()) return {};
  std::size_t common = runs.front().size();
  for (const std::vector<Harmonic>& run : runs) common = std::min(common, run.size());
  std::vector<RepeatedHarmonic> repeated(common);
  for (std::size_t i = 0; i < common; ++i) {
    repeated[i].order = static_cast<int>(i) + 1;
    for (const std::vector<Harmonic>& run : runs) {
      if (run[i].order != repeated[i].order)
        throw std::invalid_argument("repeats: the orders of a run are not 1, 2, 3, ...");
      repeated[i].values.emplace_back(run[i].cos, run[i].sin);
    }
    repeated[i].sample = sample_of(repeated[i].values);
  }
  return repeated;
}

std::optional<T2Test> drift_of(const RepeatedHarmonic& series, const RepeatedHarmonic& baseline) {
  if (series.order != baseline.order) throw std::invalid_argument("repeats: two different orders");
  return hotelling_two_sample(series.values, baseline.values);
}

std::optional<RadialPath> radial_path(const std::vector<RadialTrace>& runs, int points) {
  if (points <= 0) throw std::invalid_argument("repeats: points is not positive");
  double first = -std::numeric_limits<double>::infinity();
  double last = -first;
  std::vector<std::vector<Sample>> all;
  for (const RadialTrace& run : runs) {
    const std::vector<Sample>& samples = all.emplace_back(ordered(run));
    if (samples.empty()) return std::nullopt;
    first = std::max(first, samples.front().angle);
    last = std::min(last, samples.back().angle);
  }
  if (all.empty() || !(first < last)) return std::nullopt;
  RadialPath path;
  path.runs = static_cast<int>(all.size());
  for (int i = 0; i < points; ++i) {
    const double angle = first + (last - first) * (i + 0.5) / points;
    std::vector<double> found;
    for (const std::vector<Sample>& samples : all)
      if (const std::optional<double> deviation = at(angle, samples)) found.push_back(*deviation);
    if (found.size() < all.size()) continue;
    path.angle.push_back(angle);
    path.mean.push_back(mean(found));
    if (const std::optional<double> sd = sample_sd(found)) path.sd.push_back(*sd);
  }
  if (path.angle.empty()) return std::nullopt;
  find_extremes(path);
  path.accuracy_centred = centred_accuracy(path);
  return path;
}

}  // namespace ballbar
