#include <cmath>

#include "core/units.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

/// Exact where the command runs straight from sample to sample.
void command(const Effect& effect, Motion& motion) {
  const double lag = effect.values[0];
  if (lag == 0.0) return;
  const auto row = effect.joint - 1;
  double behind = 0.0;  // commanded minus followed
  double asked = motion.q.cols() > 0 ? motion.q(row, 0) : 0.0;
  for (Eigen::Index k = 1; k < motion.q.cols(); ++k) {
    const double h = motion.time(k) - motion.time(k - 1);
    const double fade = std::exp(-h / lag);
    const double moved = motion.q(row, k) - asked;
    behind = fade * behind + moved / h * lag * (1.0 - fade);
    asked = motion.q(row, k);
    motion.q(row, k) = asked - behind;
  }
}

}  // namespace

/// T y' + y = command: a first-order filter, for slow motions y = command - T q' + T^2 q''. Begins at rest.
/// Odd, grows with speed. A lag that all joints share is a shift in time, and a viscous wind-up behind the
/// encoder looks the same but for the joint readings.
/// Source: physics-gap.md 3, row 6.
EffectKind servo_lag() {
  return {.name = "servo_lag",
          .joint = JointUse::kOne,
          .parameters = {{.name = "lag_ms",
                          .si = 1e-3,
                          .typical = 3.0,
                          .least = 0.0,
                          .most = 10'000.0,
                          .meaning = "time constant of the joint's servo"}},
          .meaning = "the joint follows its command later than the others",
          .source = "Slamani, Nubiola, Bonev, Ind. Robot 39 (2012) 57; first-order servo",
          .command = command};
}

}  // namespace ballbar
