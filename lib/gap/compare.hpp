#pragma once
/// Measured against predicted, on one circle and on one line.

#include <Eigen/Core>
#include <optional>

#include "core/result.hpp"
#include "core/spec.hpp"
#include "gap/ball_fit.hpp"

namespace ballbar {

/// Orders of a gap's harmonics, where the arc carries them.
inline constexpr int kGapOrders = 10;

struct CircleComparison {
  CircleGap gap;
  Eigen::VectorXd predicted;                       ///< [m] n bar deviations: |point - ball| - radius
  Eigen::Vector3d ball = Eigen::Vector3d::Zero();  ///< [m] in the base frame: the place with which prediction
                                                   ///< and measurement fit best
};

/// Bar deviation |point - ball| - radius against the measured one. The ball's place in the plane is fitted
/// together with the mean of the gap and, on request, the shift of the bar's clock (least squares,
/// Gauss-Newton on the exact distances). The ball's height, to which a bar is blind in the first order, is
/// that of a person's set-up: as far from the programmed centre as the robot as built is, on the mean, from
/// its programmed path. The shift has a prior of 15 ms against 1 um of the bar (physics-gap.md 5): where the
/// prediction has no shape it stays 0, and its standard deviation is the prior's.
///
/// Order 1 of the gap: the bar reads |rho(t) u(t) + e|, and e is taken against such a set-up, so that it is 0
/// where the ball stands where the model expects it.
///
/// @param angle       n commanded angles [rad] of the measured arc, in sequence of time
/// @param deviation   n measured [m]
/// @param points      in the base frame; finite for all shifts up to kLargestTimeShift either way, where
/// `fit_shift`; else for 0
/// @return nothing where the arc does not carry a centre
/// @throws std::invalid_argument for other sizes or a value that is not finite
std::optional<CircleComparison> compare_circle(const CircleSpec& circle, const Eigen::VectorXd& angle,
                                               const Eigen::VectorXd& deviation, const PointsAt& points,
                                               bool fit_shift);

/// Deviation of a line in one direction. Offset and slope of measured - predicted are the alignment of the
/// optics: they are added to the prediction.
/// @param line       its points; `predicted` of each, and `gap`, are filled in
/// @param predicted  [m] one per point; NaN where not known
void compare_line(LineResult& line, const Eigen::VectorXd& predicted);

}  // namespace ballbar
