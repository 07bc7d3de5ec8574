#pragma once
/// Inside gap/ only: a fit in words and figures.

#include <vector>

#include "gap/diagnosis.hpp"
#include "gap/search.hpp"
#include "gap/vibration.hpp"
#include "gap/weigh.hpp"

namespace ballbar {

/// Writes `left_out`, `nuisance` and `located`.
/// @param least  [m] size below which a zero offset is not material
void explain(const GapFitter& fitter, const GapFit& fit, const Weights& weights,
             const std::vector<Candidate>& candidates, const std::optional<Vibration>& vibration,
             double least, Diagnosis& diagnosis);

/// Zero offsets of the chain's joints as corrections in the controller's joint convention [deg]: in FANUC's,
/// J3 takes part in the uncertainty of J2, and their covariance counts.
/// @param zero        [rad] one per joint
/// @param covariance  [rad^2] joints x joints
std::vector<NamedParameter> mastering_of(const RobotModel& model, const Eigen::VectorXd& zero,
                                         const Eigen::MatrixXd& covariance);

}  // namespace ballbar
