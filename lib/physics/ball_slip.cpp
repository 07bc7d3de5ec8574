#include <cmath>
#include <limits>

#include "physics/clock.hpp"
#include "physics/displacement.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

constexpr double kAnywhere = std::numeric_limits<double>::infinity();
constexpr double kSamePlace = 1e-5;  // [m]

/// Balls that stand elsewhere stay where they are.
bool is_that_ball(const Effect& effect, const Conditions& conditions) {
  for (Eigen::Index i = 0; i < 3; ++i) {
    const double wanted = effect.values[4 + static_cast<std::size_t>(i)];
    if (wanted == kAnywhere) continue;
    if (!conditions.ball || !(std::abs((*conditions.ball)[i] - wanted) < kSamePlace)) return false;
  }
  return true;
}

Eigen::Vector3d ball(const Effect& effect, double time, const Conditions& conditions) {
  if (!has_come(effect.values[3], time, conditions) || !is_that_ball(effect, conditions))
    return Eigen::Vector3d::Zero();
  return displacement(effect);
}

ParameterKind centre_along(std::string_view name) {
  return {.name = name,
          .si = kMetresPerMm,
          .need = Need::kOptional,
          .least = -1e5,
          .most = 1e5,
          .absent = kAnywhere,
          .meaning = "only of balls with this centre_mm of their test; not given: of any"};
}

}  // namespace

/// The set-up's ball lies elsewhere from that moment on: centre + (x, y, z) for clock >= time_us. A ball that
/// stands at another place is not touched. Source: physics-gap.md 3, row 16.
EffectKind ball_slip() {
  return {.name = "ball_slip",
          .parameters =
              {displacement_along("x_um", "along x of the base"),
               displacement_along("y_um", "along y of the base"),
               displacement_along("z_um", "along z of the base"),
               {.name = "time_us", .typical = 0.0, .least = 0.0, .most = 1e17, .meaning = "producer's clock"},
               centre_along("centre_x_mm"),
               centre_along("centre_y_mm"),
               centre_along("centre_z_mm")},
          .meaning = "the centre ball moved in its set-up",
          .source = "the centre fitted before and after differs",
          .ball = ball};
}

}  // namespace ballbar
