#pragma once
/// A series over its repetitions as JSON: `ballbar summary`.

#include <string>
#include <vector>

#include "daemon/json_out.hpp"
#include "store/store.hpp"

namespace ballbar {

/// Per robot, series, test and direction.
/// @param runs      the runs, circles and lines mixed; their recordings are read from `store`
/// @param baseline  a series that each other one is held against; empty: none
/// @return a list; drift is there where a baseline is given
Json circles_summary(const Store& store, const std::vector<StoredRun>& runs, const std::string& baseline);

/// Per robot, series, test and axis.
Json lines_summary(const std::vector<StoredRun>& runs);

}  // namespace ballbar
