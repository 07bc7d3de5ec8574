#include "core/units.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

constexpr double kSecondsPerHour = 3600.0;

Eigen::Vector3d base(const Effect& effect, double series_time) {
  return series_time * Eigen::Vector3d(effect.values[0], effect.values[1], effect.values[2]);
}

ParameterKind along(std::string_view name, std::string_view meaning) {
  return {.name = name,
          .si = kMetresPerUm / kSecondsPerHour,
          .typical = 10.0,
          .need = Need::kSomeOf,
          .least = -1e6,
          .most = 1e6,
          .meaning = meaning};
}

}  // namespace

/// The robot's base moves against ball and instrument at constant speed: tool point + (x, y, z) t, t in hours
/// since the series began. A tracker that drifts looks the same with the opposite sign.
/// Source: physics-gap.md "Names".
EffectKind base_drift() {
  return {.name = "base_drift",
          .parameters = {along("x_um", "per hour, along x of the base"),
                         along("y_um", "per hour, along y of the base"),
                         along("z_um", "per hour, along z of the base")},
          .meaning = "the robot's base, or the instrument, drifts",
          .source = "ISO 230-3: drift of position; to first order",
          .base = base};
}

}  // namespace ballbar
