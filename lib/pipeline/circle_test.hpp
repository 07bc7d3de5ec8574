#pragma once
/// The figures of ISO 230-4 in the result of a run, and those of both directions in the run that completes
/// them.

#include <cstddef>
#include <optional>
#include <vector>

#include "core/result.hpp"
#include "metrology/circle_iso.hpp"

namespace ballbar {

/// The samples [begin, end) whose angle is known; direction and conditions are the caller's to fill in.
CircleTrace measured_arc(const std::vector<double>& angle, const std::vector<double>& deviation,
                         std::size_t begin, std::size_t end);

/// Fills circle_figures; where the status is "ok" also circle_test, if there was a run the other way, and the
/// message with what this arc does not define
/// and where it was driven at a feed more than 5 % off the programmed one.
/// @throws std::invalid_argument as circle_figures
void add_circle_figures(const CircleTrace& trace, const TestSpec& test,
                        const std::optional<CircleTrace>& other_way, RunResult& result);

}  // namespace ballbar
