#pragma once
/// Parts of the report's page.

#include <string>
#include <vector>

#include "store/store.hpp"

namespace ballbar {

/// The error signatures of the latest repetition that was driven both ways, in the plane's frame and with X
/// along the radius from the base's axis. @param runs  of one robot, test, series and source
std::string shapes_html(const std::vector<StoredRun>& runs);

/// Over the repetitions, by direction: ISO 9283 path accuracy and repeatability as a bar sees them, and the
/// ovality vector with its covariance; for lines pose accuracy and repeatability of the stops.
/// @param runs  of one robot, test, series and source
std::string repeats_html(const Store& store, const std::vector<StoredRun>& runs);

}  // namespace ballbar
