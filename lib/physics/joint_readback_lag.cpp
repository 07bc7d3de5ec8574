#include <algorithm>

#include "physics/effects.hpp"

namespace ballbar {
namespace {

/// The row's reading at a time, straight between samples; before the first one the first.
double at(const Motion& motion, Eigen::Index row, double time, Eigen::Index& from) {
  if (time <= motion.time[0]) return motion.q(row, 0);
  while (from + 2 < motion.time.size() && motion.time(from + 1) < time) ++from;
  const double part = (time - motion.time(from)) / (motion.time(from + 1) - motion.time(from));
  return motion.q(row, from) + part * (motion.q(row, from + 1) - motion.q(row, from));
}

void joint_readback_lag_readback(const Effect& effect, const RobotModel& /*model*/, Motion& reading) {
  const double lag = effect.values[0], fraction = effect.values[1];
  const Motion true_motion = reading;
  for (Eigen::Index row = 0; row < reading.q.rows(); ++row) {
    if (effect.joint != 0 && row != effect.joint - 1) continue;
    Eigen::Index from = 0;
    for (Eigen::Index k = 1; k < reading.q.cols(); ++k) {
      if (lag > 0.0) reading.q(row, k) = at(true_motion, row, reading.time(k) - lag, from);
      reading.q(row, k) -= fraction * (true_motion.q(row, k) - true_motion.q(row, k - 1));
    }
  }
}

}  // namespace

/// What the controller reports of a joint (0 = of all) is older than the measurement. lag_ms: reading(t) =
/// angle(t - lag), a delay. fraction_of_move, for static poses, which are the columns of the motion: reading
/// = angle - fraction x (angle - angle of the pose before).
/// Source: physics-gap.md "Names" and 12.
EffectKind joint_readback_lag() {
  return {
      .name = "joint_readback_lag",
      .joint = JointUse::kOneOrAll,
      .parameters = {{.name = "lag_ms",
                      .si = 1e-3,
                      .typical = 5.0,
                      .need = Need::kOneOf,
                      .least = 0.0,
                      .most = 10'000.0,
                      .meaning = "age of the reading, in motion"},
                     {.name = "fraction_of_move",
                      .typical = 0.001,
                      .need = Need::kOneOf,
                      .least = -1.0,
                      .most = 1.0,
                      .meaning = "part of the way from the pose before that the reading lacks, at poses"}},
      .meaning = "the joint reading is older than the measurement",
      .source = "physics of the read-out; seen in KUKA KR 300 recordings (3 ms)",
      .readback = joint_readback_lag_readback};
}

}  // namespace ballbar
