#pragma once
/// Readings of a file as a Run, as the assembler would have made it of a stream.

#include "core/run.hpp"
#include "core/spec.hpp"
#include "files/csv.hpp"

namespace ballbar {

/// What a file does not say.
struct RecordingFacts {
  std::string robot;
  std::string series;
  int direction = 0;  ///< +1 or -1
  int repetition = 1;
  std::int64_t started_us = 0;
  double feed = 0.0;                  ///< [m/s] 0: as configured
  double payload = 0.0;               ///< [kg]
  std::optional<double> temperature;  ///< [degC]
  bool with_overshoot = false;        ///< the readings hold the overshoots too, not only the measured arc
};

/// A circle of the bar alone: its angles will come from time at constant feed. Without times the readings are
/// taken as evenly spread over the arc (and the overshoots), one in the middle of each equal part.
/// @throws Error(kInput) where the speed is not known, times do not rise or do not fit the circle's duration
/// by
///         a tenth, or the deviations can hardly be in the unit that was stated
Run circle_from(const CsvReadings& readings, const TestSpec& test, const RecordingFacts& facts);

/// A line of the interferometer.
/// @param axis  of all readings where they have no axis of their own; '\0': not stated
/// @throws Error(kInput) where positions or axis are not known, positions cannot be of this line, or they run
///         the other way
Run line_from(const CsvReadings& readings, const TestSpec& test, const RecordingFacts& facts, char axis);

/// +1 where counter-clockwise in that plane, seen from its third axis, is counter-clockwise about the
/// circle's normal; else -1.
/// @param plane  "XY", "YZ" or "ZX"
/// @throws Error(kInput) where the circle lies in another plane
int sense_of(const std::string& plane, const CircleSpec& circle);

}  // namespace ballbar
