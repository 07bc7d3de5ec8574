#pragma once
/// Inside physics/ only: moments on the producer's clock.

#include "core/units.hpp"
#include "physics/motion.hpp"

namespace ballbar {

/// Whether a moment has come at a time of a run. Where the run's start is not known, it has not.
/// @param moment_us  producer's clock
/// @param time       [s] of the run
inline bool has_come(double moment_us, double time, const Conditions& conditions) {
  // Both near each other: their difference is exact enough where their sum would not be.
  return conditions.start_us != 0 &&
         time >= (moment_us - static_cast<double>(conditions.start_us)) * kSecondsPerUs;
}

}  // namespace ballbar
