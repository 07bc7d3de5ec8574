#pragma once
/// An error of one joint's angle that no entry of the catalogue explains: a curve over one driver
/// (physics-gap.md 5, step 8).

#include <Eigen/Core>

#include "gap/gap_model.hpp"

namespace ballbar {

enum class Driver { kAngle, kVelocity, kDirection, kTorque };

/// "angle", "velocity", "direction", "torque"
const char* to_string(Driver driver);

/// A cubic spline over equal intervals of the driver; `direction`: one over the angle, with the sign of the
/// joint's speed.
struct Curve {
  int joint = 0;  ///< from 1
  Driver driver = Driver::kAngle;
  double from = 0.0, to = 0.0;  ///< SI: what the observations cover
  int intervals = 12;

  Eigen::Index width() const { return intervals + 3; }
};

inline constexpr double kCurveSize = 2e-4;  ///< [rad] standard deviation of each coefficient

/// Values of the driver on the places of the arc, n.
Eigen::VectorXd driver_of(const Curve& curve, const Tangent& at, Drive& drive);

/// n x width [m] of the reading per kCurveSize of each coefficient; zero beyond the curve's range.
Eigen::MatrixXd curve_columns(const Curve& curve, const Tangent& at, Drive& drive);

}  // namespace ballbar
