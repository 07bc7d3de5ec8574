#include "gap/curve.hpp"

#include <algorithm>
#include <cmath>

namespace ballbar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

const char* to_string(Driver driver) {
  switch (driver) {
    case Driver::kAngle:
      return "angle";
    case Driver::kVelocity:
      return "velocity";
    case Driver::kDirection:
      return "direction";
    case Driver::kTorque:
      break;
  }
  return "torque";
}

VectorXd driver_of(const Curve& curve, const Tangent& at, Drive& drive) {
  const Index row = curve.joint - 1;
  switch (curve.driver) {
    case Driver::kVelocity:
      return at.speed.col(row);
    case Driver::kTorque:
      return drive.torque().row(row)(at.sample);
    case Driver::kAngle:
    case Driver::kDirection:
      break;
  }
  return at.motor.q.row(row)(at.sample);
}

MatrixXd curve_columns(const Curve& curve, const Tangent& at, Drive& drive) {
  const Index n = at.time.size(), row = curve.joint - 1;
  const VectorXd driver = driver_of(curve, at, drive);
  MatrixXd columns = MatrixXd::Zero(n, curve.width());
  for (Index k = 0; k < n; ++k) {
    const double place = (driver[k] - curve.from) / (curve.to - curve.from) * curve.intervals;
    if (!(place >= -1e-6) || place > curve.intervals + 1e-6) continue;
    const double inside = std::clamp(place, 0.0, curve.intervals - 1e-9);
    const auto first = static_cast<Index>(inside);
    const double u = inside - static_cast<double>(first), v = 1.0 - u;
    double size = kCurveSize * at.joint(k, row);
    if (curve.driver == Driver::kDirection && at.speed(k, row) < 0.0) size = -size;
    columns(k, first) = size * v * v * v / 6.0;
    columns(k, first + 1) = size * (3.0 * u * u * u - 6.0 * u * u + 4.0) / 6.0;
    columns(k, first + 2) = size * (3.0 * v * v * v - 6.0 * v * v + 4.0) / 6.0;
    columns(k, first + 3) = size * u * u * u / 6.0;
  }
  return columns;
}

}  // namespace ballbar
