#pragma once
/// Inside gap/ only: the proof on observations that were not fitted (physics-gap.md 5, step 10).

#include <vector>

#include "gap/diagnosis.hpp"
#include "gap/gap_fit.hpp"

namespace ballbar {

/// Names of the laps; those of a line that was read along two axes once.
std::vector<std::string> runs_of(const std::vector<Observation>& observations);

/// Everything frozen but what the set-up leaves open and the shift of the clocks.
/// @param held   with noise assigned; not empty
/// @param fit    of other observations
/// @param outside  set where a curve would have to be read beyond the range that it was fitted on
/// @param traces   where to add what it looks like; null: nowhere
FitFigures held_out_figures(const GapModel& model, const std::vector<Observation>& held, const GapFit& fit,
                            bool& outside, std::vector<FitTrace>* traces = nullptr);

/// The model as configured, with only ball, bar and shift of the clocks fitted.
GapFit as_configured(const GapModel& model, const std::vector<Observation>& observations);

/// @param before,after  fits of these observations
std::vector<FitTrace> traces_of(const std::vector<Observation>& observations, const GapFit& before,
                                const GapFit& after, bool held_out);

}  // namespace ballbar
