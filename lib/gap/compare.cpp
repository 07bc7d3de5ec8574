#include "gap/compare.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <functional>
#include <limits>
#include <stdexcept>

#include "core/units.hpp"
#include "metrology/arc.hpp"
#include "numerics/harmonics.hpp"
#include "numerics/line_fit.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kMostSteps = 50;
constexpr double kConverged = 1e-13;         // [m]: rounding
constexpr double kShiftConverged = 1e-8;     // [s]: a hundredth of the wire's microsecond
constexpr double kShiftedConverged = 1e-11;  // [m]: where the path is joined by straight lines
constexpr double kShiftStep = 1e-3;          // [s] of the numerical derivative
constexpr double kShiftSd = 15e-3;           // [s] prior, physics-gap.md 5
constexpr double kBarSd = 1e-6;              // [m] that it is weighed against
constexpr double kBin =
    kRadPerDeg;  // of the largest place: a mean over a degree, so that noise is not what it shows

/// The set-up: ball, mean of the gap, shift of the clocks.
struct SetUp {
  Vector3d ball = Vector3d::Zero();  ///< [m] in the plane's frame, from the programmed centre
  double mean = 0.0;                 ///< [m]
  double shift = 0.0;                ///< [s]
  double shift_sd = 0.0;             ///< [s] for residuals of kBarSd
  VectorXd distance;                 ///< [m] of each point from the ball
};

using LocalPoints = std::function<Eigen::Matrix3Xd(double)>;  // in the plane's frame

VectorXd distances(const Eigen::Matrix3Xd& points, const Vector3d& ball) {
  return (points.colwise() - ball).colwise().norm();
}

/// Derivative of the distances by the shift of the clocks, by central differences within its bounds.
VectorXd by_shift(const LocalPoints& points, const SetUp& fit) {
  const double room = kLargestTimeShift - kShiftStep;
  const double at = std::clamp(fit.shift, -room, room);
  return (distances(points(at + kShiftStep), fit.ball) - distances(points(at - kShiftStep), fit.ball)) /
         (2.0 * kShiftStep);
}

/// What is made least: squares of the residuals in units of kBarSd, and the prior of the shift.
double cost(const SetUp& fit, const VectorXd& length) {
  const double prior = fit.shift / kShiftSd;
  return (length.array() - fit.distance.array() - fit.mean).matrix().squaredNorm() / (kBarSd * kBarSd) +
         prior * prior;
}

/// One step of Gauss-Newton: ball x, y, mean, and the shift where it is free.
VectorXd step_of(const LocalPoints& points, const VectorXd& length, const Eigen::Matrix3Xd& bar, bool free,
                 SetUp& fit) {
  const Index n = length.size();
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(n + 1, free ? 4 : 3);  // the prior of the shift is a row
  VectorXd left = VectorXd::Zero(n + 1);
  columns.topLeftCorner(n, 2) =
      -(bar.topRows<2>().array().rowwise() / fit.distance.transpose().array()).transpose();
  columns.col(2).head(n).setOnes();
  left.head(n) = length.array() - fit.distance.array() - fit.mean;
  if (free) {
    columns.col(3).head(n) = by_shift(points, fit);
    columns(n, 3) = kBarSd / kShiftSd;
    left[n] = -fit.shift * kBarSd / kShiftSd;
    const Eigen::MatrixXd information = columns.transpose() * columns;
    fit.shift_sd = kBarSd * std::sqrt(information.ldlt().solve(VectorXd::Unit(4, 3))[3]);
  }
  return columns.colPivHouseholderQr().solve(left);
}

/// The set-up after a share of a step. What wants to be shifted further than clocks are apart is no shift: it
/// stays at the bound.
SetUp moved(const SetUp& from, const VectorXd& step, double share, const LocalPoints& points) {
  SetUp to = from;
  to.ball.head<2>() += share * step.head<2>();
  to.mean += share * step[2];
  if (step.size() > 3)
    to.shift = std::clamp(from.shift + share * step[3], -kLargestTimeShift, kLargestTimeShift);
  to.distance = distances(points(to.shift), to.ball);
  return to;
}

/// Gauss-Newton, each step halved until it helps; a model that is far off may ask for too long ones.
std::optional<SetUp> fit_set_up(const LocalPoints& points, const VectorXd& length, const Vector3d& start,
                                bool fit_shift) {
  constexpr double kLeastShare = 1e-3;
  SetUp fit;
  fit.ball = start;
  fit.distance = distances(points(0.0), fit.ball);
  fit.mean = (length - fit.distance).mean();
  double least = cost(fit, length);
  for (int count = 0; count < kMostSteps; ++count) {
    if (!(fit.distance.minCoeff() > 0.0) || !std::isfinite(least)) return std::nullopt;
    const bool free = fit_shift && std::abs(fit.shift) < kLargestTimeShift;
    const Eigen::Matrix3Xd bar = points(fit.shift).colwise() - fit.ball;
    const VectorXd step = step_of(points, length, bar, free, fit);
    if (!step.allFinite()) return std::nullopt;
    const bool last = step.head<3>().norm() <= (fit_shift ? kShiftedConverged : kConverged) &&
                      (!free || std::abs(step[3]) <= kShiftConverged);
    double share = 1.0;
    SetUp next = moved(fit, step, share, points);
    double reached = cost(next, length);
    for (; !(reached < least) && share > kLeastShare; reached = cost(next, length))
      next = moved(fit, step, share /= 2.0, points);
    if (reached < least) {
      fit = next;
      least = reached;
    } else {
      return fit;  // rounding, or the kinks of a path that is joined by straight lines
    }
    if (last) return fit;
  }
  return fit_shift ? std::optional(fit) : std::nullopt;
}

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
  Eigen::Matrix3d to_plane;
  to_plane << plane.e1, plane.e2, plane.normal;
  to_plane.transposeInPlace();
  const LocalPoints local = [&](double shift) -> Eigen::Matrix3Xd {
    return to_plane * (points(shift).colwise() - plane.centre);
  };
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
  const std::optional<SetUp> fit = fit_set_up(local, length, set_up, fit_shift);
  if (!fit) return std::nullopt;

  CircleComparison found;
  found.ball = plane.centre + to_plane.transpose() * fit->ball;
  found.predicted = fit->distance.array() - circle.radius;
  const VectorXd gap = deviation - found.predicted;
  const HarmonicFit harmonics = basis.fit(gap);
  if (fit_shift) found.gap.time_shift = {fit->shift, fit->shift_sd};
  found.gap.mean = {harmonics.mean(), std::sqrt(harmonics.covariance(0, 0))};
  for (int k = 1; k <= harmonics.order; ++k) {
    const Index c = Index{2} * k - 1;
    const Index s = c + 1;
    found.gap.harmonics.push_back({k, harmonics.cos(k), harmonics.sin(k), harmonics.covariance(c, c),
                                   harmonics.covariance(s, s), harmonics.covariance(c, s)});
  }
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
