#include <cmath>

#include "physics/effects.hpp"

namespace ballbar {
namespace {

/// The link that joint j moves ends at joint j + 1: row j + 1 of the table holds its lengths.
void thermal_growth_geometry(const Effect& effect, const Chain& nominal, ChainDeviation& deviation) {
  for (std::size_t row = 1; row < nominal.rows().size(); ++row) {
    if (effect.joint != 0 && row != static_cast<std::size_t>(effect.joint)) continue;
    deviation.links[row].a += effect.values[0] * nominal.rows()[row].a;
    deviation.links[row].d += effect.values[0] * nominal.rows()[row].d;
  }
}

double thermal_growth_growth(const Effect& effect, double series_time) {
  return -std::expm1(-series_time / effect.values[1]);
}

}  // namespace

/// Lengths of the link times (1 + strain (1 - exp(-t / T))), t since the series began
/// (Conditions::series_time
/// + Motion::time). The link of joint j is that between joints j and j + 1: 2 = upper arm, 3 = forearm of a
/// six-axis arm; 0 = all of them. The tool does not grow. Even. Simplified: a link warms evenly and does not
/// bend.
/// Source: physics-gap.md 3, row 12.
EffectKind thermal_growth() {
  return {.name = "thermal_growth",
          .joint = JointUse::kLinkOrAll,
          .parameters = {{.name = "strain_ppm",
                          .si = 1e-6,
                          .typical = 200.0,
                          .least = -1e5,
                          .most = 1e5,
                          .meaning = "when warm"},
                         {.name = "time_constant_min",
                          .si = 60.0,
                          .typical = 35.0,
                          .least = 0.01,
                          .most = 1e5,
                          .meaning = "to 63 % of it"}},
          .meaning = "links grow as the robot warms; joint 2 = upper arm, 3 = forearm, 0 = all",
          .source = "ISO 230-3; first-order warming, aluminium 23 ppm/K",
          .geometry = thermal_growth_geometry,
          .growth = thermal_growth_growth};
}

}  // namespace ballbar
