#include <algorithm>
#include <cmath>

#include "core/units.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

/// Curvature of the command between samples k - 1 and k: the mean of those at its ends, but at most twice the
/// smaller one and none where they differ in sign, so that a corner of a straight command stays one (the
/// monotonised central limiter of B. van Leer, J. Comput. Phys. 23 (1977) 276-299).
double curvature(const Motion& motion, Eigen::Index row, Eigen::Index k) {
  const auto slope = [&](Eigen::Index i) {
    return (motion.q(row, i + 1) - motion.q(row, i)) / (motion.time(i + 1) - motion.time(i));
  };
  const auto at = [&](Eigen::Index i) {  // of the sample between two intervals
    return (slope(i) - slope(i - 1)) / ((motion.time(i + 1) - motion.time(i - 1)) / 2.0);
  };
  if (k < 2 || k + 1 >= motion.time.size()) return 0.0;
  const double before = at(k - 1), behind = at(k);
  if (before * behind <= 0.0) return 0.0;
  const double mean = (before + behind) / 2.0;
  const double most = 2.0 * std::min(std::abs(before), std::abs(behind));
  return std::copysign(std::min(std::abs(mean), most), mean);
}

/// Exact where the command is a parabola from sample to sample.
void servo_lag_command(const Effect& effect, Motion& motion) {
  const double lag = effect.values[0];
  if (lag == 0.0) return;
  const auto row = effect.joint - 1;
  const Motion asked = motion;
  double behind = 0.0;  // commanded minus followed
  for (Eigen::Index k = 1; k < motion.q.cols(); ++k) {
    const double h = asked.time(k) - asked.time(k - 1);
    const double fade = std::exp(-h / lag);
    const double bend = curvature(asked, row, k);
    const double speed = (asked.q(row, k) - asked.q(row, k - 1)) / h;  // in the middle
    behind = fade * (behind - lag * (speed - bend * h / 2.0 - lag * bend)) +
             lag * (speed + bend * h / 2.0 - lag * bend);
    motion.q(row, k) = asked.q(row, k) - behind;
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
          .command = servo_lag_command};
}

}  // namespace ballbar
