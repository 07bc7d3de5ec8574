#pragma once
/// Circles that could be driven next: about the places of those that are configured, with plane, tool,
/// payload, feed, height and radius changed; and what they would be as observations.

#include <functional>
#include <string>
#include <vector>

#include "gap/gap_model.hpp"

namespace ballbar {

/// How far a piece of work is.
using Progress = std::function<void(std::size_t done, std::size_t of)>;

struct ProposedTest {
  TestSpec test;
  std::string differs;  ///< from the configured circle: "its plane and the tool tilted by 30 deg about Y"
};

/// Those that the robot can drive both ways: within reach, limits and joint speeds, clear of singularities on
/// the whole path, overshoots included. A tilt that is out of reach is tried smaller.
/// @param payload  [kg] of those with payload; nothing: the heaviest that is configured, or 2 kg more than
/// the
///                 lightest
std::vector<ProposedTest> proposed_tests(const GapModel& model, std::optional<double> payload = {},
                                         const Progress& progress = {});

/// Noise of one lap.
struct LapNoise {
  Eigen::VectorXd frequency;   ///< [cycles per turn], rising
  Eigen::VectorXd variance;    ///< [m^2] of a coefficient at each
  double time_per_turn = 0.0;  ///< [s] of the circle that it was seen on: a faster one has fewer readings
};

/// What repeats showed, or, without observations, 0.7 um of white noise and as much of slow noise as is
/// usual.
LapNoise lap_noise_of(const std::vector<Observation>& observations);

/// Both directions of a circle as they would be observed, two laps each; nothing is measured yet.
/// @param set_up  number of the ball's place
/// @throws Error(kInput) as commanded_circle()
std::vector<Observation> as_observed(const GapModel& model, const TestSpec& test, int set_up,
                                     const LapNoise& noise);

}  // namespace ballbar
