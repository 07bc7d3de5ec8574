#include "gap/ball_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kMostSteps = 50;
constexpr double kConverged = 1e-13;         // [m]: rounding
constexpr double kCostIsBlind = 1e-9;        // [m]: what so short a step gains is lost in the cost's rounding
constexpr double kShiftConverged = 1e-8;     // [s]: a hundredth of the wire's microsecond
constexpr double kShiftedConverged = 1e-11;  // [m]: where the path is joined by straight lines
constexpr double kShiftStep = 1e-3;          // [s] of the numerical derivative
constexpr double kShiftSd = 15e-3;           // [s] prior, physics-gap.md 5
constexpr double kBarSd = 1e-6;              // [m] that it is weighed against

Eigen::Matrix3d axes_of(const CirclePlane& plane) {
  Eigen::Matrix3d axes;
  axes << plane.e1, plane.e2, plane.normal;
  return axes;
}

VectorXd distances(const Eigen::Matrix3Xd& points, const Vector3d& ball) {
  return (points.colwise() - ball).colwise().norm();
}

/// Derivative of the distances by the shift of the clocks, by central differences within its bounds.
VectorXd by_shift(const PointsAt& points, const BallFit& fit) {
  const double room = kLargestTimeShift - kShiftStep;
  const double at = std::clamp(fit.shift, -room, room);
  return (distances(points(at + kShiftStep), fit.ball) - distances(points(at - kShiftStep), fit.ball)) /
         (2.0 * kShiftStep);
}

/// What is made least: squares of the residuals in units of kBarSd, and the prior of the shift.
double cost(const BallFit& fit, const VectorXd& length) {
  const double prior = fit.shift / kShiftSd;
  return (length.array() - fit.distance.array() - fit.mean).matrix().squaredNorm() / (kBarSd * kBarSd) +
         prior * prior;
}

/// One step of Gauss-Newton: ball x, y, mean, and the shift where it is free.
VectorXd step_of(const PointsAt& points, const VectorXd& length, const Eigen::Matrix3Xd& bar, bool free,
                 BallFit& fit) {
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

/// The fit after a share of a step. What wants to be shifted further than clocks are apart is no shift: it
/// stays at the bound.
BallFit moved(const BallFit& from, const VectorXd& step, double share, const PointsAt& points) {
  BallFit to = from;
  to.ball.head<2>() += share * step.head<2>();
  to.mean += share * step[2];
  if (step.size() > 3)
    to.shift = std::clamp(from.shift + share * step[3], -kLargestTimeShift, kLargestTimeShift);
  to.distance = distances(points(to.shift), to.ball);
  return to;
}

}  // namespace

Eigen::Matrix3Xd in_plane(const CirclePlane& plane, const Eigen::Matrix3Xd& points) {
  return axes_of(plane).transpose() * (points.colwise() - plane.centre);
}

Vector3d from_plane(const CirclePlane& plane, const Vector3d& point) {
  return plane.centre + axes_of(plane) * point;
}

// Each step is halved until it helps; a model that is far off may ask for too long ones.
std::optional<BallFit> fit_ball(const PointsAt& points, const VectorXd& length, const Vector3d& start,
                                bool fit_shift) {
  constexpr double kLeastShare = 1e-3;
  BallFit fit;
  fit.ball = start;
  fit.distance = distances(points(0.0), fit.ball);
  fit.mean = (length - fit.distance).mean();
  double least = cost(fit, length);
  bool near = false;
  for (int count = 0; count < kMostSteps; ++count) {
    if (!(fit.distance.minCoeff() > 0.0) || !std::isfinite(least)) return std::nullopt;
    const bool free = fit_shift && std::abs(fit.shift) < kLargestTimeShift;
    const Eigen::Matrix3Xd bar = points(fit.shift).colwise() - fit.ball;
    const VectorXd step = step_of(points, length, bar, free, fit);
    if (!step.allFinite()) return std::nullopt;
    const bool last = step.head<3>().norm() <= (fit_shift ? kShiftedConverged : kConverged) &&
                      (!free || std::abs(step[3]) <= kShiftConverged);
    near = !fit_shift && step.norm() <= kCostIsBlind;
    double share = 1.0;
    BallFit next = moved(fit, step, share, points);
    double reached = cost(next, length);
    for (; !near && !(reached < least) && share > kLeastShare; reached = cost(next, length))
      next = moved(fit, step, share /= 2.0, points);
    if (near || reached < least) {
      fit = next;
      least = reached;
    } else {
      return fit;  // rounding, or the kinks of a path that is joined by straight lines
    }
    if (last) return fit;
  }
  return fit_shift || near ? std::optional(fit) : std::nullopt;
}

}  // namespace ballbar
