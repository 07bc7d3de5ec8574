#include <limits>

#include "core/units.hpp"
#include "physics/clock.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

constexpr double kNever = std::numeric_limits<double>::infinity();

double gauge(const Effect& effect, double time, int row, const Conditions& conditions) {
  return has_come(effect.values[1], time, conditions) || row >= effect.values[2] ? effect.values[0] : 0.0;
}

}  // namespace

/// The instrument reads too much by the jump from that moment on: reading + jump for clock >= time_us, or
/// from that row of a file of poses on.
/// Source: physics-gap.md "Names".
EffectKind gauge_jump() {
  return {.name = "gauge_jump",
          .parameters = {{.name = "jump_um",
                          .si = kMetresPerUm,
                          .typical = 10.0,
                          .least = -1e6,
                          .most = 1e6,
                          .meaning = "+ = reads more afterwards"},
                         {.name = "time_us",
                          .typical = 0.0,
                          .need = Need::kOneOf,
                          .least = 0.0,
                          .most = 1e17,
                          .absent = kNever,
                          .meaning = "producer's clock"},
                         {.name = "row",
                          .typical = 0.0,
                          .need = Need::kOneOf,
                          .least = 1.0,
                          .most = 1e9,
                          .absent = kNever,
                          .meaning = "first reading after it, counted from 1"}},
          .meaning = "the instrument's zero jumped",
          .source = "a step in the reading that no motion of the robot makes",
          .gauge = gauge};
}

}  // namespace ballbar
