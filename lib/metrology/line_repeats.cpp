#include "metrology/line_repeats.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "metrology/line.hpp"
#include "numerics/line_fit.hpp"
#include "numerics/statistics.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kInfinity = std::numeric_limits<double>::infinity();
constexpr double kNotMeasured = std::numeric_limits<double>::quiet_NaN();

enum Way : std::size_t { kForward, kBackward };

/// What was read at one position: one value per run and way, NaN where the run has none.
struct Row {
  double position = 0.0;
  std::array<std::vector<double>, 2> read;

  std::vector<double> values(Way way) const {
    std::vector<double> all;
    for (const double v : read[way])
      if (!std::isnan(v)) all.push_back(v);
    return all;
  }
  std::size_t count(Way way) const { return values(way).size(); }
};

/// By rising position; positions within kSamePosition are one.
std::vector<Row> table_of(const LineRuns& forward, const LineRuns& backward) {
  struct Reading {
    double position, deviation;
    Way way;
    std::size_t run;
  };
  std::vector<Reading> all;
  for (const Way way : {kForward, kBackward}) {
    const LineRuns& runs = way == kForward ? forward : backward;
    for (std::size_t j = 0; j < runs.size(); ++j)
      for (const LinePoint& p : runs[j]) {
        if (!std::isfinite(p.position) || !std::isfinite(p.deviation))
          throw std::invalid_argument("line: a reading is not finite");
        all.push_back({p.position, p.deviation, way, j});
      }
  }
  std::stable_sort(all.begin(), all.end(),
                   [](const Reading& a, const Reading& b) { return a.position < b.position; });
  std::vector<Row> rows;
  for (const Reading& r : all) {
    if (rows.empty() || r.position - rows.back().position > kSamePosition)
      rows.push_back({r.position,
                      {std::vector<double>(forward.size(), kNotMeasured),
                       std::vector<double>(backward.size(), kNotMeasured)}});
    rows.back().read[r.way][r.run] = r.deviation;
  }
  return rows;
}

template <typename Wanted>
std::vector<Row> only(std::vector<Row> rows, const Wanted& wanted) {
  std::erase_if(rows, [&](const Row& row) { return !wanted(row); });
  return rows;
}

VectorXd positions_of(const std::vector<Row>& rows) {
  VectorXd x(static_cast<Index>(rows.size()));
  for (Index i = 0; i < x.size(); ++i) x[i] = rows[static_cast<std::size_t>(i)].position;
  return x;
}

VectorXd means_of(const std::vector<Row>& rows, Way way) {
  VectorXd y(static_cast<Index>(rows.size()));
  for (Index i = 0; i < y.size(); ++i) y[i] = mean(rows[static_cast<std::size_t>(i)].values(way));
  return y;
}

/// Smallest and largest of what it was shown.
struct Range {
  double low = kInfinity;
  double high = -kInfinity;
  void show(double value) {
    low = std::min(low, value);
    high = std::max(high, value);
  }
  double width() const { return high - low; }
};

void fill_figures(BidirectionalFigures& found) {
  Range means_f, means_b, both, middle, limits_f, limits_b, limits;
  for (const BidirectionalPoint& p : found.points) {
    means_f.show(p.forward);
    means_b.show(p.backward);
    middle.show((p.forward + p.backward) / 2.0);
    for (const double side : {-2.0, 2.0}) {
      limits_f.show(p.forward + side * p.forward_sd);
      limits_b.show(p.backward + side * p.backward_sd);
    }
    found.reversal = std::max(found.reversal, std::abs(p.reversal));
    found.reversal_mean += p.reversal / static_cast<double>(found.points.size());
    found.forward_repeatability = std::max(found.forward_repeatability, 4.0 * p.forward_sd);
    found.backward_repeatability = std::max(found.backward_repeatability, 4.0 * p.backward_sd);
    found.repeatability = std::max(found.repeatability, p.repeatability);
  }
  for (const Range& r : {means_f, means_b}) both.show(r.low), both.show(r.high);
  for (const Range& r : {limits_f, limits_b}) limits.show(r.low), limits.show(r.high);
  found.forward_systematic_deviation = means_f.width();
  found.backward_systematic_deviation = means_b.width();
  found.systematic_deviation = both.width();
  found.mean_bidirectional_deviation = middle.width();
  found.forward_accuracy = limits_f.width();
  found.backward_accuracy = limits_b.width();
  found.accuracy = limits.width();
}

/// Constant (in the middle of the points) and slope of each run of one way; empty where a run lacks a point.
struct RunLines {
  std::vector<double> constant, slope;
};
RunLines lines_of(const std::vector<Row>& rows, Way way) {
  const VectorXd x = positions_of(rows);
  RunLines lines;
  for (std::size_t j = 0; j < rows.front().read[way].size(); ++j) {
    VectorXd y(x.size());
    for (Index i = 0; i < y.size(); ++i) y[i] = rows[static_cast<std::size_t>(i)].read[way][j];
    if (!y.allFinite()) return {};
    lines.constant.push_back(y.mean());
    lines.slope.push_back(fit_line(x, y).slope);
  }
  return lines;
}

/// Of the difference of two means.
std::optional<double> sd_of_difference(const std::vector<double>& a, const std::vector<double>& b) {
  const std::optional<double> sd_a = sample_sd(a);
  const std::optional<double> sd_b = sample_sd(b);
  if (!sd_a || !sd_b) return std::nullopt;
  return std::sqrt(*sd_a * *sd_a / static_cast<double>(a.size()) +
                   *sd_b * *sd_b / static_cast<double>(b.size()));
}

/// Rms over the points of the sd that the difference of the means has there, each run about its own line.
double scatter_about_own_lines(const std::vector<Row>& rows, Way way, const RunLines& lines) {
  const std::size_t runs = lines.constant.size();
  const double middle = positions_of(rows).mean();
  double sum = 0.0;
  for (const Row& row : rows) {
    std::vector<double> left;
    left.reserve(runs);
    for (std::size_t j = 0; j < runs; ++j)
      left.push_back(row.read[way][j] - lines.constant[j] - lines.slope[j] * (row.position - middle));
    const double sd = sample_sd(left).value_or(0.0);
    sum += sd * sd / static_cast<double>(runs);
  }
  return sum / static_cast<double>(rows.size());
}

/// The least-squares line of everything that was read.
LineFit line_of_all(const std::vector<Row>& rows) {
  std::vector<double> x, y;
  for (const Row& row : rows)
    for (const std::vector<double>& way : row.read)
      for (const double v : way)
        if (!std::isnan(v)) x.push_back(row.position), y.push_back(v);
  const auto n = static_cast<Index>(x.size());
  return fit_line(Eigen::Map<const VectorXd>(x.data(), n), Eigen::Map<const VectorXd>(y.data(), n));
}

/// One direction of deviation about its line, by position.
struct Sheet {
  std::vector<Row> rows;
  LineFit line;
  explicit Sheet(const LineRuns& forward, const LineRuns& backward) : rows(table_of(forward, backward)) {
    if (rows.size() >= 3) line = line_of_all(rows);
  }
  /// NaN where it was not measured.
  double off(std::size_t row, Way way, std::size_t run) const {
    return rows[row].read[way][run] - line.intercept - line.slope * rows[row].position;
  }
};

/// AP and RP of points in one direction of deviation or two.
StopPose pose_of(const std::vector<Eigen::Vector2d>& points) {
  StopPose pose;
  pose.runs = static_cast<int>(points.size());
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& p : points) centre += p / static_cast<double>(points.size());
  pose.accuracy = centre.norm();
  std::vector<double> distance;
  distance.reserve(points.size());
  for (const Eigen::Vector2d& p : points) distance.push_back((p - centre).norm());
  if (const std::optional<double> sd = sample_sd(distance)) pose.repeatability = mean(distance) + 3.0 * *sd;
  return pose;
}

}  // namespace

std::optional<BidirectionalFigures> bidirectional_figures(const LineRuns& forward, const LineRuns& backward) {
  const std::vector<Row> rows = only(table_of(forward, backward), [](const Row& row) {
    return row.count(kForward) >= 2 && row.count(kBackward) >= 2;
  });
  if (rows.size() < 3) return std::nullopt;
  const VectorXd x = positions_of(rows);
  const VectorXd there = means_of(rows, kForward);
  const VectorXd back = means_of(rows, kBackward);
  const LineFit line = fit_line(x, (there + back) / 2.0);
  const VectorXd reference = line.intercept + line.slope * x.array();
  BidirectionalFigures found;
  found.reference_slope = line.slope;
  for (Index i = 0; i < x.size(); ++i) {
    const Row& row = rows[static_cast<std::size_t>(i)];
    BidirectionalPoint p;
    p.position = row.position;
    p.forward = there[i] - reference[i];
    p.backward = back[i] - reference[i];
    p.forward_sd = *sample_sd(row.values(kForward));
    p.backward_sd = *sample_sd(row.values(kBackward));
    p.reversal = there[i] - back[i];
    p.repeatability = std::max({2.0 * p.forward_sd + 2.0 * p.backward_sd + std::abs(p.reversal),
                                4.0 * p.forward_sd, 4.0 * p.backward_sd});
    found.points.push_back(p);
  }
  fill_figures(found);
  return found;
}

std::optional<BundleDifference> difference_of(const LineRuns& forward, const LineRuns& backward) {
  const std::vector<Row> rows = only(table_of(forward, backward), [](const Row& row) {
    return row.count(kForward) >= 1 && row.count(kBackward) >= 1;
  });
  if (rows.size() < 3) return std::nullopt;
  const VectorXd x = positions_of(rows);
  const VectorXd difference = means_of(rows, kForward) - means_of(rows, kBackward);
  const VectorXd along = x.array() - x.mean();
  BundleDifference found;
  found.points = static_cast<int>(rows.size());
  found.constant.value = difference.mean();
  found.slope.value = fit_line(x, difference).slope;
  const VectorXd turned = found.slope.value * along;
  const VectorXd shape = difference.array() - found.constant.value - turned.array();
  const auto n = static_cast<double>(rows.size());
  found.shape = std::sqrt(shape.squaredNorm() / n);
  const double whole =
      n * found.constant.value * found.constant.value + turned.squaredNorm() + shape.squaredNorm();
  if (whole > 0.0) {
    found.constant_share = n * found.constant.value * found.constant.value / whole;
    found.slope_share = turned.squaredNorm() / whole;
    found.shape_share = shape.squaredNorm() / whole;
  }
  const RunLines there = lines_of(rows, kForward);
  const RunLines back = lines_of(rows, kBackward);
  found.constant.sd = sd_of_difference(there.constant, back.constant);
  found.slope.sd = sd_of_difference(there.slope, back.slope);
  if (std::min(there.constant.size(), back.constant.size()) >= 2)
    found.shape_by_chance = std::sqrt(scatter_about_own_lines(rows, kForward, there) +
                                      scatter_about_own_lines(rows, kBackward, back));
  return found;
}

std::vector<StopPose> stop_poses(const LineRuns& forward, const LineRuns& backward,
                                 const LineRuns& forward_across, const LineRuns& backward_across) {
  const bool plane = !forward_across.empty() || !backward_across.empty();
  if (plane && (forward_across.size() != forward.size() || backward_across.size() != backward.size()))
    throw std::invalid_argument("line: the second direction of deviation is of other runs");
  const Sheet first(forward, backward);
  const Sheet second(forward_across, backward_across);
  if (first.rows.size() < 3 || (plane && second.rows.size() < 3)) return {};
  std::vector<StopPose> poses;
  for (const Way way : {kForward, kBackward}) {
    std::size_t other = 0;  // the row of `second` at the same position
    for (std::size_t i = 0; i < first.rows.size(); ++i) {
      const double position = first.rows[i].position;
      while (plane && other < second.rows.size() && second.rows[other].position < position - kSamePosition)
        ++other;
      if (plane && (other == second.rows.size() || second.rows[other].position > position + kSamePosition))
        continue;
      std::vector<Eigen::Vector2d> points;
      for (std::size_t j = 0; j < first.rows[i].read[way].size(); ++j) {
        const Eigen::Vector2d p(first.off(i, way, j), plane ? second.off(other, way, j) : 0.0);
        if (p.allFinite()) points.push_back(p);
      }
      if (points.empty()) continue;
      StopPose& pose = poses.emplace_back(pose_of(points));
      pose.position = position;
      pose.direction = way == kForward ? 1 : -1;
    }
  }
  return poses;
}

}  // namespace ballbar
