#pragma once
/// The only place that knows factors between SI (inside) and the units at the borders (in the name).

#include <numbers>

namespace ballbar {

inline constexpr double kPi = std::numbers::pi;
inline constexpr double kTurn = 2.0 * kPi;  ///< [rad]
inline constexpr double kMetresPerUm = 1e-6;
inline constexpr double kMetresPerMm = 1e-3;
inline constexpr double kRadPerDeg = kPi / 180.0;
inline constexpr double kSecondsPerUs = 1e-6;
inline constexpr double kSecondsPerMs = 1e-3;
inline constexpr double kPerPpm = 1e-6;

/// Borders out: divide once, so that 12 um given is 12 um shown.
inline constexpr double to_um(double metres) { return metres / kMetresPerUm; }
inline constexpr double to_mm(double metres) { return metres / kMetresPerMm; }
inline constexpr double to_ms(double seconds) { return seconds / kSecondsPerMs; }
inline constexpr double to_ppm(double ratio) { return ratio / kPerPpm; }
inline constexpr double to_deg(double radians) { return radians / kRadPerDeg; }

}  // namespace ballbar
