#pragma once
/// Circles and lines that could be driven next: about the places of those that are configured, with plane or
/// direction, tool, payload, feed, height and size changed; and what they would be as observations.

#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "gap/gap_model.hpp"

namespace ballbar {

/// How far a piece of work is.
using Progress = std::function<void(std::size_t done, std::size_t of)>;

struct ProposedTest {
  TestSpec test;
  std::string differs;  ///< from the configured one: "its plane and the tool tilted by 30 deg about Y"; of a
                        ///< line also what it is: "line along X, 470 mm long, through the middle of Y"
};

/// What may be proposed.
struct PlanScope {
  std::optional<double> payload{};  ///< [kg] of tests with payload; nothing: the heaviest that is configured,
                                    ///< or 2 kg more than the lightest
  bool lines = false;               ///< lines even where none is configured
  bool on_the_way = false;          ///< lines are read while they are driven, not at stops
};

/// Lines are read as those that were recorded.
PlanScope scope_of(const std::vector<Observation>& driven);

/// Those that the robot can drive both ways: within reach, limits and joint speeds, clear of singularities on
/// the whole path, overshoots included. A tilt that is out of reach is tried smaller, a line shorter.
/// Lines are proposed where a line is configured: then there are optics.
std::vector<ProposedTest> proposed_tests(const GapModel& model, const PlanScope& scope = {},
                                         const Progress& progress = {});

/// Noise of one lap, and how it was read.
struct LapNoise {
  Eigen::VectorXd frequency;   ///< [cycles per turn], rising
  Eigen::VectorXd variance;    ///< [m^2] of a coefficient at each
  double time_per_turn = 0.0;  ///< [s] of the test that it was seen on: a faster one has fewer readings
  bool at_stops = true;        ///< of lines: as many readings at each point, however fast
};

/// What repeats of this kind of test showed, or, without observations, 0.7 um of white noise and as much of
/// slow noise as is usual.
LapNoise lap_noise_of(const std::vector<Observation>& observations, TestKind kind = TestKind::kCircle);

/// Set-ups of a test's observations: of a line, one for each direction in which it is read.
inline int set_ups_of(const TestSpec& test) { return test.kind == TestKind::kLine ? 2 : 1; }

/// Both directions of a test as they would be observed, two laps each; of a line, read along both of the
/// world's axes that are not its main one. Nothing is measured yet.
/// @param set_up  number of the first of its set-ups
/// @param noise   of this kind of test
/// @throws Error(kInput) as commanded_circle(), commanded_line()
std::vector<Observation> as_observed(const GapModel& model, const TestSpec& test, int set_up,
                                     const LapNoise& noise);

/// Noise of a robot's bar and optics.
struct PlannedNoise {
  LapNoise bar, optics;

  explicit PlannedNoise(const std::vector<Observation>& driven)
      : bar(lap_noise_of(driven)), optics(lap_noise_of(driven, TestKind::kLine)) {}
  const LapNoise& of(const TestSpec& test) const { return test.kind == TestKind::kLine ? optics : bar; }
};

}  // namespace ballbar
