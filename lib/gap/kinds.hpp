#pragma once
/// Inside gap/ only: of what was found, which kind it is and when it came.

#include <vector>

#include "gap/gap_fit.hpp"

namespace ballbar {

/// Each joint's lost motion as one, of the kind that explains best at its own size; with the shape that a fit
/// may adjust.
GapFit with_kinds_weighed(const GapFitter& fitter, GapFit fit, const GapPriors& priors);

/// Moments of slips and jumps, where one within a neighbouring recording explains better than one between
/// recordings.
GapFit with_moments_weighed(const GapFitter& fitter, GapFit fit, const GapPriors& priors);

}  // namespace ballbar
