#pragma once
/// The volumetric analysis of a series: `ballbar summary` and the report's page.

#include <string>
#include <vector>

#include "daemon/json_out.hpp"
#include "store/store.hpp"

namespace ballbar {

/// Per robot, series and source, where circles in XY, YZ and ZX of the base frame were driven both ways:
/// squareness and scaling with standard deviations (metrology/volumetric.hpp). Where a series has circles in
/// several places, they are those of all places together.
/// @param runs  that are ok, circles and lines mixed; their recordings are read from `store`
/// @return a list
Json volumetric_summary(const Store& store, const std::vector<StoredRun>& runs);

/// As a table in the terminal; empty for an empty list.
std::string volumetric_text(const Json& summary);

/// As a section of the report, in plain words; empty for an empty list.
std::string volumetric_html(const Json& summary);

}  // namespace ballbar
