#pragma once
/// Numbers, units and times as they stand in files of instruments.

#include <cstdint>
#include <optional>
#include <string>
#include <string_view>

namespace ballbar {

/// Without blanks at both ends.
std::string_view trimmed(std::string_view text);

/// The whole text as a finite number; nothing else.
/// @param decimal  '.' or ','
std::optional<double> number_from(std::string_view text, char decimal = '.');

/// Metres per unit: "m", "mm", "um", "nm" or "in". Nothing for another word.
std::optional<double> metres_per(std::string_view unit);
inline constexpr const char* kLengthUnits = "m, mm, um, nm or in";

/// Seconds per unit: "s", "ms" or "us".
std::optional<double> seconds_per(std::string_view unit);
inline constexpr const char* kTimeUnits = "s, ms or us";

/// "2026-03-11T09:00:00.5+01:00" in microseconds since the epoch (ISO 8601). A blank may stand for the T;
/// seconds, their fraction (microseconds at most) and the zone may be absent. Without zone it is UTC. Nothing
/// for any other text.
std::optional<std::int64_t> time_us_from(std::string_view text);

}  // namespace ballbar
