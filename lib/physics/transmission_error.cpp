#include <cmath>

#include "core/units.hpp"
#include "physics/drive.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

Eigen::VectorXd deflection(const Effect& effect, Drive& drive) {
  const double cycles = effect.values[0], amplitude = effect.values[1], phase = effect.values[2];
  return amplitude *
         (cycles * drive.motor().q.row(effect.joint - 1).transpose().array() + phase).sin().matrix();
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
                         {.name = "amplitude_deg",
                          .si = kRadPerDeg,
                          .typical = 0.003,
                          .least = -10.0,
                          .most = 10.0,
                          .meaning = "half of peak to peak"},
                         {.name = "phase_deg",
                          .si = kRadPerDeg,
                          .typical = 0.0,
                          .need = Need::kOptional,
                          .least = -1e5,
                          .most = 1e5,
                          .meaning = "of the sine, at joint angle 0"}},
          .meaning = "ripple of a gear, a harmonic drive or an encoder",
          .source = "Tuttle, Seering, IEEE Trans. Robot. Autom. 12 (1996) 368 (harmonic drives)",
          .deflection = deflection};
}

}  // namespace ballbar
