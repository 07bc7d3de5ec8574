#pragma once
/// Two series of the same tests side by side: what changed.

#include <string>
#include <vector>

#include "daemon/json_out.hpp"
#include "store/store.hpp"

namespace ballbar {

/// Per robot, test, direction and source of circles, per robot, test and axis of lines, as far as both series
/// have them: means and standard deviations over the repetitions, harmonics as vectors with Hotelling's T^2
/// of their difference. change = after - before.
/// @param before,after  runs that are ok; each of one series
Json compare_json(const std::vector<StoredRun>& before, const std::vector<StoredRun>& after);

/// The straightness figures of one entry of lines_summary(): quantity, value (null where there is none),
/// meaning.
Json line_figures(const Json& line);

/// compare_json() as tables for a terminal.
std::string compare_text(const Json& comparison);

/// compare_json() as part of a page.
std::string compare_html(const Json& comparison);

/// "0.013", "< 0.001"; "-" for null.
std::string p_text(const Json& p_value);

}  // namespace ballbar
