#pragma once
/// Reference lines y = intercept + slope x: least squares, and through the end points.

#include <Eigen/Core>

#include "numerics/fit_status.hpp"

namespace ballbar {

struct LineFit {
  FitStatus status = FitStatus::kTooFewPoints;
  double slope = 0.0;                                    ///< [unit of y per unit of x]
  double intercept = 0.0;                                ///< [unit of y] at x = 0
  Eigen::Matrix2d covariance = Eigen::Matrix2d::Zero();  ///< intercept, slope; zero where not estimated
  double residual_sd = 0.0;                              ///< sqrt(RSS / (n - 2)); 0 for two points
};

/// Least-squares line. kTooFewPoints below two points, kIllConditioned where all x are alike.
/// @param x,y  n values each
/// @throws std::invalid_argument where the sizes differ or a value is not finite
LineFit fit_line(const Eigen::VectorXd& x, const Eigen::VectorXd& y);

/// The line through the mean of the points at the smallest x and the mean of those at the largest x. No
/// covariance.
/// @param same_x  points within this distance of the smallest (largest) x belong to it, [unit of x]
LineFit end_point_line(const Eigen::VectorXd& x, const Eigen::VectorXd& y, double same_x = 0.0);

/// Largest minus smallest deviation y - slope x: the straightness about a line of that slope. 0 for no
/// points.
double range_about(double slope, const Eigen::VectorXd& x, const Eigen::VectorXd& y);

}  // namespace ballbar
