#pragma once
/// Inside gap/ only: lines as straightness optics see them, made ready for a diagnosis.

#include <optional>
#include <string>
#include <vector>

#include "gap/observation.hpp"

namespace ballbar {

/// Directions of deviation that a run was read in, "XZ".
std::string axes_of(const Run& run);

/// One observation of laps of a line that belong together, in one direction of deviation. Where the robot
/// stands at most of its readings, its places are the stops: one value each, of all readings there. Else
/// they lie evenly on the line, as on a circle. The first stop is only used where the recording shows how the
/// robot came to it: what its joints have lost there hangs on that.
/// @param left_aside  a sentence for each lap that cannot be used: why, and what to do
std::optional<Observation> observe_line(const std::vector<const MeasuredRun*>& laps, char axis,
                                        const TestSpec& test, const RobotModel& model,
                                        std::vector<std::string>& left_aside);

}  // namespace ballbar
