#pragma once
/// Inside gap/ only: a fit in words and figures.

#include <vector>

#include "gap/diagnosis.hpp"
#include "gap/search.hpp"
#include "gap/vibration.hpp"

namespace ballbar {

/// Writes `left_out`, `nuisance` and `located`.
/// @param least  [m] size below which a zero offset is not material
void explain(const GapFitter& fitter, const GapFit& fit, const Weights& weights,
             const std::vector<Candidate>& candidates, const std::optional<Vibration>& vibration,
             double least, Diagnosis& diagnosis);

}  // namespace ballbar
