#include "physics/effects.hpp"
#include "physics/sine_error.hpp"

namespace ballbar {
namespace {

Eigen::VectorXd transmission_error_deflection(const Effect& effect, Drive& drive) {
  return sine_of_joint(effect, drive, effect.values[0], effect.values[1], effect.values[2]);
}

}  // namespace

/// Link's angle - motor's angle = A sin(cycles q + phase), q = the motor's angle at the joint (chain angle),
/// so servo_lag is in it. Once or twice per turn of the motor: cycles = gear ratio or twice that. Fixed in
/// the joint's angle, so the same in both directions; its frequency follows the joint's speed. No overtones.
/// Source: physics-gap.md 3, rows 8 and 9.
EffectKind transmission_error() {
  return {.name = "transmission_error",
          .joint = JointUse::kOne,
          .parameters = {{.name = "cycles_per_turn",
                          .typical = 200.0,
                          .least = 0.0,
                          .most = 1e5,
                          .meaning = "cycles in one turn of the joint"},
                         sine_amplitude(0.003),
                         sine_phase()},
          .meaning = "ripple of a gear, a harmonic drive or an encoder",
          .source = "Tuttle, Seering, IEEE Trans. Robot. Autom. 12 (1996) 368 (harmonic drives)",
          .deflection = transmission_error_deflection};
}

}  // namespace ballbar
