#include "metrology/line.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "numerics/line_fit.hpp"
#include "numerics/minimum_zone.hpp"
#include "numerics/vector3.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// One point per position, by rising position: the mean of what was read there.
std::vector<LinePoint> means_by_position(std::vector<LinePoint> points) {
  std::stable_sort(points.begin(), points.end(),
                   [](const LinePoint& a, const LinePoint& b) { return a.position < b.position; });
  std::vector<LinePoint> means;
  for (std::size_t begin = 0; begin < points.size();) {
    std::size_t end = begin;
    LinePoint sum;
    for (; end < points.size() && points[end].position - points[begin].position <= kSamePosition; ++end) {
      sum.position += points[end].position;
      sum.deviation += points[end].deviation;
    }
    const auto count = static_cast<double>(end - begin);
    means.push_back({sum.position / count, sum.deviation / count, std::nullopt});
    begin = end;
  }
  return means;
}

/// Forward - backward at the positions of `points`, both by rising position.
void pair_up(std::vector<LinePoint>& points, double sign, const std::vector<LinePoint>& others) {
  auto other = others.begin();
  for (LinePoint& point : points) {
    point.reversal.reset();
    while (other != others.end() && other->position < point.position - kSamePosition) ++other;
    if (other != others.end() && std::abs(other->position - point.position) <= kSamePosition)
      point.reversal = sign * (point.deviation - other->deviation);
  }
}

void summarise(const std::vector<LinePoint>& points, std::optional<double>& largest,
               std::optional<double>& mean) {
  largest.reset();
  mean.reset();
  constexpr double kMore = 1.0 + 1e-9;  // of two that are equal but for rounding, the first
  double sum = 0.0;
  int count = 0;
  for (const LinePoint& point : points) {
    if (!point.reversal) continue;
    if (!largest || std::abs(*point.reversal) > kMore * std::abs(*largest)) largest = point.reversal;
    sum += *point.reversal;
    ++count;
  }
  if (count > 0) mean = sum / count;
}

std::vector<LinePoint> joined(const std::vector<std::vector<LinePoint>>& runs) {
  std::vector<LinePoint> all;
  for (const std::vector<LinePoint>& run : runs) all.insert(all.end(), run.begin(), run.end());
  return all;
}

}  // namespace

LineFrame frame_of(const LineSpec& line) {
  const Vector3d start = vector_of(line.start);
  return {start, (vector_of(line.end) - start).normalized()};
}

Vector3d LineFrame::across(char axis) const {
  constexpr double kAlong = 1e-9;
  const Index k = axis - 'X';
  const Vector3d off = Vector3d::Unit(k) - along[k] * along;
  if (!(off.norm() > kAlong)) return Vector3d::Constant(std::numeric_limits<double>::quiet_NaN());
  return off.normalized();
}

std::string LineFrame::axes_across() const {
  Eigen::Index main = 0;
  along.cwiseAbs().maxCoeff(&main);
  std::string axes = "XYZ";
  axes.erase(static_cast<std::size_t>(main), 1);
  return axes;
}

VectorXd LineFrame::deviations(const Eigen::Matrix3Xd& points, char axis) const {
  return (points.colwise() - start).transpose() * across(axis);
}

std::optional<Straightness> straightness_of(const std::vector<LinePoint>& points) {
  if (means_by_position(points).size() < 3) return std::nullopt;
  VectorXd x(static_cast<Index>(points.size()));
  VectorXd y(x.size());
  for (Index i = 0; i < x.size(); ++i) {
    x[i] = points[static_cast<std::size_t>(i)].position;
    y[i] = points[static_cast<std::size_t>(i)].deviation;
  }
  Straightness found;
  found.mz = minimum_zone_line(x, y).width;
  found.slope_ls = fit_line(x, y).slope;
  found.ls = range_about(found.slope_ls, x, y);
  found.ep = range_about(end_point_line(x, y, kSamePosition).slope, x, y);
  return found;
}

std::optional<LineResult> analyse_line(const std::vector<InterferometerReading>& readings) {
  std::vector<LinePoint> points;
  for (const InterferometerReading& reading : readings) {
    if (reading.axis != readings.front().axis)
      throw std::invalid_argument("line: readings of different axes");
    if (!std::isfinite(reading.position) || !std::isfinite(reading.deviation))
      throw std::invalid_argument("line: a reading is not finite");
    points.push_back({reading.position, reading.deviation, std::nullopt});
  }
  LineResult line;
  line.points = means_by_position(std::move(points));
  const std::optional<Straightness> straightness = straightness_of(line.points);
  if (!straightness) return std::nullopt;
  line.axis = readings.front().axis;
  line.straightness_mz = straightness->mz;
  line.straightness_ls = straightness->ls;
  line.straightness_ep = straightness->ep;
  line.slope_ls = straightness->slope_ls;
  return line;
}

void add_reversal(LineResult& line, int direction, const std::vector<LinePoint>& other_way) {
  if (direction == 0) return;
  pair_up(line.points, direction > 0 ? 1.0 : -1.0, means_by_position(other_way));
  summarise(line.points, line.reversal_max, line.reversal_mean);
}

LineBundle analyse_line_bundle(const std::vector<std::vector<LinePoint>>& forward,
                               const std::vector<std::vector<LinePoint>>& backward) {
  const std::vector<LinePoint> there = joined(forward);
  const std::vector<LinePoint> back = joined(backward);
  LineBundle bundle;
  bundle.forward_mean = means_by_position(there);
  bundle.backward_mean = means_by_position(back);
  bundle.all_runs = straightness_of(joined({there, back}));
  bundle.forward = straightness_of(there);
  bundle.backward = straightness_of(back);
  bundle.forward_mean_of_runs = straightness_of(bundle.forward_mean);
  bundle.backward_mean_of_runs = straightness_of(bundle.backward_mean);
  pair_up(bundle.forward_mean, 1.0, bundle.backward_mean);
  pair_up(bundle.backward_mean, -1.0, bundle.forward_mean);
  summarise(bundle.forward_mean, bundle.reversal_max, bundle.reversal_mean);
  return bundle;
}

}  // namespace ballbar
