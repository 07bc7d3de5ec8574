#include "physics/clock.hpp"
#include "physics/displacement.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

Eigen::Vector3d ball(const Effect& effect, double time, const Conditions& conditions) {
  if (!has_come(effect.values[3], time, conditions)) return Eigen::Vector3d::Zero();
  return displacement(effect);
}

}  // namespace

/// The set-up's ball lies elsewhere from that moment on: centre + (x, y, z) for clock >= time_us.
/// Source: physics-gap.md 3, row 16.
EffectKind ball_slip() {
  return {
      .name = "ball_slip",
      .parameters =
          {displacement_along("x_um", "along x of the base"),
           displacement_along("y_um", "along y of the base"),
           displacement_along("z_um", "along z of the base"),
           {.name = "time_us", .typical = 0.0, .least = 0.0, .most = 1e17, .meaning = "producer's clock"}},
      .meaning = "the centre ball moved in its set-up",
      .source = "the centre fitted before and after differs",
      .ball = ball};
}

}  // namespace ballbar
