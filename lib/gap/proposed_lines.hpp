#pragma once
/// Inside gap/ only: lines of straightness optics that could be driven next.

#include <functional>
#include <string>
#include <vector>

#include "gap/proposed_parts.hpp"

namespace ballbar {

/// A line about which others are planned.
struct LinePlace {
  TestSpec test;      ///< itself; its name begins those of the others
  std::string words;  ///< for its middle: "the middle of Y"
};

/// The first lines of the configuration at different places.
/// @param anywhere  where none is configured, across the centres of the first circles
std::vector<LinePlace> line_places_of(const RobotSpec& robot, bool anywhere);

/// Ways in which a line is changed; for each `step` is called once.
inline constexpr std::size_t kLineChanges = 14;

/// Along other axes, higher and lower, further out and nearer, with the tool tilted; each shorter where it is
/// too long.
/// @param on_the_way  read while they are driven: then faster, too
/// @param heavy       [kg]
void propose_lines(const GapModel& model, const LinePlace& place, bool on_the_way, double heavy,
                   TestNames& names, const std::function<void()>& step, std::vector<ProposedTest>& all);

/// As as_observed() of a line: what observe_line() makes of a recording of it without deviations.
std::vector<Observation> line_as_observed(const GapModel& model, const TestSpec& test, int set_up,
                                          const LapNoise& noise);

}  // namespace ballbar
