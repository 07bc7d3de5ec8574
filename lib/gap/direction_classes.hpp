#pragma once
/// Inside gap/ only: joints that turn back at the same places of every circle.

#include "gap/diagnosis.hpp"
#include "gap/gap_fit.hpp"

namespace ballbar {

/// What hangs on a joint's direction or speed is told from the same of another joint only where these turn
/// back elsewhere. On two flat circles J2, J3 and J5 do not (physics-gap.md 4): then each such effect that is
/// named is given the other joints as twins, however well the numbers favour one, for no formula of lost
/// motion is as good as what differs.
void add_direction_classes(const GapFitter& fitter, Diagnosis& diagnosis);

}  // namespace ballbar
