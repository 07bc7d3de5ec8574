#pragma once
/// Inside gap/ only: ripple in the angle of a joint whose gear nobody has told of.

#include <vector>

#include "gap/gap_fit.hpp"

namespace ballbar {

/// Adds a transmission error at the rate that stands out of what a fit leaves: for each joint without a gear
/// ratio the highest peak of the periodogram in its phase, where it is none of noise. It is a proposal, to be
/// weighed with all others; where the fit names it already, its rate is looked for again beside the others'.
/// Source: N. R. Lomb, Astrophys. Space Sci. 39 (1976) 447-462, with the joint's columns as weights;
/// physics-gap.md 5, step 3.
/// @param candidates  those added have Candidate::rate_sd
/// @return whether anything was added or moved by more than its standard deviation
bool add_ripples_of_unknown_rate(const GapFitter& fitter, const GapFit& fit,
                                 std::vector<Candidate>& candidates);

}  // namespace ballbar
