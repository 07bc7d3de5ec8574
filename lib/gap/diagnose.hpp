#pragma once
/// The gap: which physics is left out. The recipe of physics-gap.md 5.

#include <vector>

#include "gap/diagnosis.hpp"
#include "gap/gap_fit.hpp"

namespace ballbar {

/// @param model     nominal, and what is known beyond it
/// @param noise     of `fitted`, from assign_noise()
/// @param fitted    with noise assigned; not empty
/// @param held_out  likewise; may be empty: then each test of `fitted` is left out in turn
Diagnosis diagnose(const GapModel& model, const std::vector<Observation>& fitted,
                   const std::vector<Observation>& held_out, const NoiseLevel& noise);

}  // namespace ballbar
