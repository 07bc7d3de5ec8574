#include "gap/compare.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/units.hpp"
#include "metrology/arc.hpp"
#include "metrology/circle.hpp"
#include "numerics/harmonics.hpp"
#include "numerics/line_fit.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kBin =
    kRadPerDeg;  // of the largest place: a mean over a degree, so that noise is not what it shows

/// Mean over each degree, and the largest of these by size.
void find_largest(const VectorXd& angle, const VectorXd& shape, CircleGap& gap) {
  const double first = angle.minCoeff();
  const auto bins = static_cast<std::size_t>(std::floor((angle.maxCoeff() - first) / kBin)) + 1;
  std::vector<double> sum(bins, 0.0);
  std::vector<double> place(bins, 0.0);
  std::vector<int> count(bins, 0);
  for (Index i = 0; i < angle.size(); ++i) {
    const auto bin = static_cast<std::size_t>((angle[i] - first) / kBin);
    sum[bin] += shape[i];
    place[bin] += angle[i];
    ++count[bin];
  }
  for (std::size_t bin = 0; bin < bins; ++bin) {
    if (count[bin] == 0 || std::abs(sum[bin] / count[bin]) <= std::abs(gap.largest)) continue;
    gap.largest = sum[bin] / count[bin];
    gap.largest_angle = place[bin] / count[bin];
  }
}

double rms(const VectorXd& values) {
  return std::sqrt(values.squaredNorm() / static_cast<double>(values.size()));
}

}  // namespace

std::optional<CircleComparison> compare_circle(const CircleSpec& circle, const VectorXd& angle,
                                               const VectorXd& deviation, const PointsAt& points,
                                               bool fit_shift) {
  const CirclePlane plane = plane_of(circle);
  const PointsAt local = [&](double shift) { return in_plane(plane, points(shift)); };
  const Eigen::Matrix3Xd unshifted = local(0.0);
  if (angle.size() != deviation.size() || angle.size() != unshifted.cols())
    throw std::invalid_argument("compare: angles, deviations and points differ in number");
  if (!angle.allFinite() || !deviation.allFinite() || !unshifted.allFinite())
    throw std::invalid_argument("compare: a value is not finite");
  if (angle.size() < 4) return std::nullopt;
  const HarmonicBasis basis(angle, kGapOrders);
  if (basis.order() < 1) return std::nullopt;

  Eigen::Matrix3Xd programmed = Eigen::Matrix3Xd::Zero(3, angle.size());
  programmed.row(0) = circle.radius * angle.array().cos();
  programmed.row(1) = circle.radius * angle.array().sin();
  const Vector3d set_up = (unshifted - programmed).rowwise().mean();
  const VectorXd length = deviation.array() + circle.radius;
  const std::optional<BallFit> fit = fit_ball(local, length, set_up, fit_shift);
  if (!fit) return std::nullopt;

  CircleComparison found;
  found.ball = from_plane(plane, fit->ball);
  found.predicted = fit->distance.array() - circle.radius;
  const VectorXd gap = deviation - found.predicted;
  const HarmonicFit harmonics = basis.fit(gap);
  if (fit_shift) found.gap.time_shift = {fit->shift, fit->shift_sd};
  found.gap.mean = {harmonics.mean(), std::sqrt(harmonics.covariance(0, 0))};
  found.gap.harmonics = harmonics_of(harmonics);
  found.gap.harmonics.front().cos = set_up.x() - fit->ball.x();
  found.gap.harmonics.front().sin = set_up.y() - fit->ball.y();
  const VectorXd shape = gap.array() - fit->mean;
  found.gap.rms = rms(shape);
  find_largest(angle, shape, found.gap);
  return found;
}

void compare_line(LineResult& line, const VectorXd& predicted) {
  const auto n = static_cast<Index>(line.points.size());
  if (predicted.size() != n) throw std::invalid_argument("compare: one prediction per point of the line");
  std::vector<double> position;
  std::vector<double> difference;
  for (Index i = 0; i < n; ++i) {
    const LinePoint& point = line.points[static_cast<std::size_t>(i)];
    if (!std::isfinite(predicted[i])) continue;
    position.push_back(point.position);
    difference.push_back(point.deviation - predicted[i]);
  }
  const auto known = static_cast<Index>(position.size());
  if (known < 3) return;
  const Eigen::Map<const VectorXd> x(position.data(), known);
  const Eigen::Map<const VectorXd> y(difference.data(), known);
  const LineFit alignment = fit_line(x, y);
  if (alignment.status != FitStatus::kOk) return;
  LineGap gap;
  double sum = 0.0;
  for (Index i = 0; i < n; ++i) {
    LinePoint& point = line.points[static_cast<std::size_t>(i)];
    if (!std::isfinite(predicted[i])) continue;
    point.predicted = predicted[i] + alignment.intercept + alignment.slope * point.position;
    const double left = point.deviation - *point.predicted;
    sum += left * left;
    if (std::abs(left) <= std::abs(gap.largest)) continue;
    gap.largest = left;
    gap.largest_position = point.position;
  }
  gap.rms = std::sqrt(sum / static_cast<double>(known));
  line.gap = gap;
}

}  // namespace ballbar
