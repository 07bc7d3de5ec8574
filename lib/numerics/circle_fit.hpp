#pragma once
/// Least-squares circle by orthogonal distances.

#include <Eigen/Core>

#include "numerics/fit_status.hpp"

namespace ballbar {

struct CircleFit {
  FitStatus status = FitStatus::kTooFewPoints;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< [unit of the points]
  double radius = 0.0;                               ///< [unit of the points]
  Eigen::Matrix3d covariance =
      Eigen::Matrix3d::Zero();  ///< centre x, centre y, radius; zero for three points
  double residual_sd = 0.0;     ///< sqrt(RSS / (n - 3)); 0 for three points
  Eigen::VectorXd residual;     ///< distance from the centre - radius, one per point
};

/// The circle with the least sum of squares of (distance from the centre - radius): metrology.md 2, "LSC".
/// Gauss-Newton with Levenberg's damping from the algebraic circle, on centred and scaled points.
/// kTooFewPoints below three, kIllConditioned where the points are alike or on a line, or no circle was
/// reached.
/// @param points  2 x n
/// @throws std::invalid_argument where a coordinate is not finite
CircleFit fit_circle(const Eigen::Matrix2Xd& points);

}  // namespace ballbar
