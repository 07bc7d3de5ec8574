#pragma once
/// Inside gap/ only: what speaks against the recordings themselves, before any physics is believed.

#include <string>
#include <vector>

#include "gap/gap_fit.hpp"

namespace ballbar {

/// Sentences on circles that look as if driven the other way than their labels say, and on payloads that look
/// entered wrongly. Readings are held against a rough model, linear: zeros, set-up, and of every joint
/// compliance, lag and lost motion. Only what makes most of the misfit go away with one change is said;
/// empty: no doubt.
/// @param fitter  with noise assigned
std::vector<std::string> doubts_of(const GapFitter& fitter);

}  // namespace ballbar
