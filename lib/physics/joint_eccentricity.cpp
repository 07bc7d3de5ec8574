#include "physics/effects.hpp"
#include "physics/sine_error.hpp"

namespace ballbar {
namespace {

Eigen::VectorXd joint_eccentricity_deflection(const Effect& effect, Drive& drive) {
  return sine_of_joint(effect, drive, 1.0, effect.values[0], effect.values[1]);
}

}  // namespace

/// Link's angle - motor's angle = A sin(q + phase): the output wheel runs out of centre. Even. Nearly the
/// same as zero offset and lengths unless the joint turns far.
/// Source: physics-gap.md 3, row 10.
EffectKind joint_eccentricity() {
  return {.name = "joint_eccentricity",
          .joint = JointUse::kOne,
          .parameters = {sine_amplitude(0.02), sine_phase()},
          .meaning = "an error once per turn of the joint: its output wheel or encoder is off centre",
          .source = "Whitney, Lozinski, Rourke 1986",
          .deflection = joint_eccentricity_deflection};
}

}  // namespace ballbar
