#pragma once
/// What a named effect may be beside its formula: wrong masses, a spring that hardens, an overtone, another
/// time constant. Nuisance with priors, so that model-form error is not named as physics (physics-gap.md 5,
/// step 7).

#include <Eigen/Core>
#include <vector>

#include "gap/candidates.hpp"

namespace ballbar {

struct GapFit;
struct NamedEffect;

/// Columns that shape_columns() gives, of all and of one.
Eigen::Index shape_width(const GapFit& fit);
Eigen::Index shape_width(const NamedEffect& named);

/// Those of the effects that are named, then of the curve, where there is one.
/// @return places x width [m], per standard deviation of the prior
Eigen::MatrixXd shape_columns(const Tangent& at, const GapFit& fit);

}  // namespace ballbar
