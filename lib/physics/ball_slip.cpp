#include "core/units.hpp"
#include "physics/clock.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

Eigen::Vector3d ball(const Effect& effect, double time, const Conditions& conditions) {
  if (!has_come(effect.values[3], time, conditions)) return Eigen::Vector3d::Zero();
  return {effect.values[0], effect.values[1], effect.values[2]};
}

ParameterKind along(std::string_view name, std::string_view meaning) {
  return {.name = name,
          .si = kMetresPerUm,
          .typical = 10.0,
          .need = Need::kSomeOf,
          .least = -1e6,
          .most = 1e6,
          .meaning = meaning};
}

}  // namespace

/// The set-up's ball lies elsewhere from that moment on: centre + (x, y, z) for clock >= time_us.
/// Source: physics-gap.md 3, row 16.
EffectKind ball_slip() {
  return {
      .name = "ball_slip",
      .parameters =
          {along("x_um", "along x of the base"),
           along("y_um", "along y of the base"),
           along("z_um", "along z of the base"),
           {.name = "time_us", .typical = 0.0, .least = 0.0, .most = 1e17, .meaning = "producer's clock"}},
      .meaning = "the centre ball moved in its set-up",
      .source = "the centre fitted before and after differs",
      .ball = ball};
}

}  // namespace ballbar
