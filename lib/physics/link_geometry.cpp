#include "core/units.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

void link_geometry_geometry(const Effect& effect, const Chain& /*nominal*/, ChainDeviation& deviation) {
  LinkDeviation& link = deviation.links[static_cast<std::size_t>(effect.joint - 1)];
  link.a += effect.values[0];
  link.d += effect.values[1];
  link.alpha += effect.values[2];
  link.beta += effect.values[3];
}

}  // namespace

/// Row `joint` of the modified DH table differs from the nominal one (DhRow, chain.hpp). Even. With uniform
/// strain of all lengths and an uncalibrated bar one direction is not observable.
/// Source: physics-gap.md 2 and 3, row 11.
EffectKind link_geometry() {
  return {.name = "link_geometry",
          .joint = JointUse::kOne,
          .parameters = {{.name = "a_mm",
                          .si = kMetresPerMm,
                          .typical = 0.3,
                          .need = Need::kSomeOf,
                          .least = -1000.0,
                          .most = 1000.0,
                          .meaning = "distance to the axis before, too long"},
                         {.name = "d_mm",
                          .si = kMetresPerMm,
                          .typical = 0.3,
                          .need = Need::kSomeOf,
                          .least = -1000.0,
                          .most = 1000.0,
                          .meaning = "offset along the joint's axis, too long"},
                         {.name = "alpha_deg",
                          .si = kRadPerDeg,
                          .typical = 0.05,
                          .need = Need::kSomeOf,
                          .least = -90.0,
                          .most = 90.0,
                          .meaning = "twist against the axis before, too large"},
                         {.name = "beta_deg",
                          .si = kRadPerDeg,
                          .typical = 0.05,
                          .need = Need::kSomeOf,
                          .least = -90.0,
                          .most = 90.0,
                          .meaning = "second tilt, of axes that are nominally parallel"}},
          .meaning = "a length or twist of a link differs: row `joint` of the modified DH table",
          .source = "Craig, Introduction to Robotics; Hayati, CDC 1983",
          .geometry = link_geometry_geometry};
}

}  // namespace ballbar
