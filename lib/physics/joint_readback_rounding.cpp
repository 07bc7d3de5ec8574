#include <cmath>

#include "core/units.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

void joint_readback_rounding_readback(const Effect& effect, const RobotModel& model, Motion& reading) {
  const double step = effect.values[0];
  if (step == 0.0) return;
  for (Eigen::Index k = 0; k < reading.q.cols(); ++k) {
    const std::span<double> q(reading.q.col(k).data(), static_cast<std::size_t>(reading.q.rows()));
    model.from_chain(q);
    for (double& angle : q) angle = step * std::round(angle / step);
    model.to_chain(q);
  }
}

}  // namespace

/// Readings are the nearest multiples of the step, in the robot's joint convention: what is rounded is what
/// the controller shows. Simplified: all joints share one step, and 0 is one of its multiples.
/// Source: physics-gap.md 3, row 15.
EffectKind joint_readback_rounding() {
  return {.name = "joint_readback_rounding",
          .parameters = {{.name = "step_deg",
                          .si = kRadPerDeg,
                          .typical = 0.001,
                          .least = 0.0,
                          .most = 10.0,
                          .meaning = "smallest step of a reading"}},
          .meaning = "the joint reading is rounded",
          .source = "pendant position registers: 0.001 deg",
          .readback = joint_readback_rounding_readback};
}

}  // namespace ballbar
