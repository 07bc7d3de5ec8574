#include <cmath>

#include "core/units.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

double structural_vibration_gauge(const Effect& effect, double time, int /*row*/,
                                  const Conditions& conditions) {
  if (!conditions.series_known) return 0.0;
  return effect.values[1] * std::sin(kTurn * effect.values[0] * (conditions.series_time + time));
}

}  // namespace

/// The instrument reads amplitude x sin(2 pi f t) too much, t since the series began: along the bar, or in
/// the direction of a line's deviation, for which way a cell shakes is not known. The same frequency at all
/// speeds (unlike transmission_error). Simplified: one line, of steady size and phase. Where it is not known
/// when the series began the phase is not, and nothing is predicted. Source: physics-gap.md 3, row 14.
EffectKind structural_vibration() {
  return {.name = "structural_vibration",
          .parameters = {{.name = "frequency_hz",
                          .typical = 15.0,
                          .least = 1e-6,
                          .most = 10'000.0,
                          .meaning = "fixed in time"},
                         {.name = "amplitude_um",
                          .si = kMetresPerUm,
                          .typical = 5.0,
                          .least = -1e5,
                          .most = 1e5,
                          .meaning = "of the reading, half of peak to peak"}},
          .meaning = "arm or cell vibrates at one frequency",
          .source = "one line in the spectrum over time, the same at every feed",
          .gauge = structural_vibration_gauge};
}

}  // namespace ballbar
