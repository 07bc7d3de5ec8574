#include "physics/displacement.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

constexpr double kUmPerHour = kMetresPerUm / 3600.0;

Eigen::Vector3d base(const Effect& effect, double series_time) { return series_time * displacement(effect); }

}  // namespace

/// The robot's base moves against ball and instrument at constant speed: tool point + (x, y, z) t, t in hours
/// since the series began. A tracker that drifts looks the same with the opposite sign.
/// Source: physics-gap.md "Names".
EffectKind base_drift() {
  return {.name = "base_drift",
          .parameters = {displacement_along("x_um", "per hour, along x of the base", kUmPerHour),
                         displacement_along("y_um", "per hour, along y of the base", kUmPerHour),
                         displacement_along("z_um", "per hour, along z of the base", kUmPerHour)},
          .meaning = "the robot's base, or the instrument, drifts",
          .source = "ISO 230-3: drift of position; to first order",
          .base = base};
}

}  // namespace ballbar
