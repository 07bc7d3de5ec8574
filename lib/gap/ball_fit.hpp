#pragma once
/// Where the ball of a bar stands, by the lengths of the bar.

#include <Eigen/Core>
#include <functional>
#include <optional>

#include "metrology/arc.hpp"

namespace ballbar {

/// The clocks of bar and joints may differ by so much; what differs by more is no shift of clocks.
inline constexpr double kLargestTimeShift = 0.05;  ///< [s]

/// Predicted tool points at the samples of an arc, and at moments so much later [s]: 3 x n [m].
using PointsAt = std::function<Eigen::Matrix3Xd(double time_shift)>;

/// Points of the base frame in the frame of a circle's plane: along e1, e2 and the normal, from the
/// programmed centre [m].
Eigen::Matrix3Xd in_plane(const CirclePlane& plane, const Eigen::Matrix3Xd& points);

/// The way back, of one point.
Eigen::Vector3d from_plane(const CirclePlane& plane, const Eigen::Vector3d& point);

/// length = |point - ball| + mean + residual.
struct BallFit {
  Eigen::Vector3d ball = Eigen::Vector3d::Zero();  ///< [m] in the plane's frame
  double mean = 0.0;                               ///< [m]
  double shift = 0.0;                              ///< [s] of the bar's clock
  double shift_sd = 0.0;                           ///< [s] for residuals of 1 um; 0 where it is not fitted
  Eigen::VectorXd distance;                        ///< [m] of each point from the ball
};

/// The ball's place in the plane, the mean and, on request, the shift of the clocks: least squares by
/// Gauss-Newton on the exact distances. The ball's height, to which a bar is blind in the first order, stays
/// that of `start`. The shift has a prior of 15 ms against 1 um of the bar (physics-gap.md 5).
/// @param points  in the plane's frame; finite for all shifts up to kLargestTimeShift either way, where
///                `fit_shift`, else for 0
/// @param length  n values [m]
/// @param start   [m] in the plane's frame
/// @return nothing where the points carry no ball
std::optional<BallFit> fit_ball(const PointsAt& points, const Eigen::VectorXd& length,
                                const Eigen::Vector3d& start, bool fit_shift);

}  // namespace ballbar
