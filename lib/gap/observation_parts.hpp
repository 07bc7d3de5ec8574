#pragma once
/// Inside gap/ only: what circles and lines have in common on their way to an observation.

#include <string>
#include <vector>

#include "gap/observation.hpp"

namespace ballbar {

/// [s] by which the clocks may differ, and a little more.
inline constexpr double kShiftRoom = 0.06;

/// [s] of samples behind the way, for derivatives and for filters that look ahead.
inline constexpr double kBehindWay = 0.3;

/// A number of places that a fast transform likes: no prime factor above 5, 16 at least.
Eigen::Index smooth_number(double wanted);

/// No wider hole than kLongestJointGap.
bool without_holes(const Motion& said);

/// A lap on its way: share of the way, time and reading, rising.
struct Lap {
  Eigen::VectorXd x, time, deviation;
};

/// Times of the model from `said` and the lap, evenly before the way as on it, the places on it, kBehindWay
/// behind.
/// @return whether the joints cover them
bool set_times(const Lap& lap, Observation& seen);

/// Labels, conditions and times, from the laps that are used.
void describe(const std::vector<const Run*>& used, Observation& seen);

}  // namespace ballbar
