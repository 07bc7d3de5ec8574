#pragma once
/// Least squares over poses: set-ups freely, everything else with a prior of physical size.

#include <Eigen/Core>
#include <vector>

#include "gap/pose_model.hpp"

namespace ballbar {

inline constexpr double kPosePrior = 2.0;  ///< standard deviation of a value, in PoseTerm::typical

struct PoseFit {
  PoseState state;
  Eigen::VectorXd residual;    ///< [m] per_row() values a row
  Eigen::MatrixXd covariance;  ///< of state.values
  /// [m] that one reading counts with: what the fit leaves, per degree of freedom, at least least_sd, times
  /// crowding().
  double sd = 0.0;
};

/// First guess of the set-ups, nothing else: frames by a rigid body fit, fixed points by trilateration.
/// Source: S. Umeyama, IEEE Trans. PAMI 13 (1991) 376-380.
PoseState start_poses(const PoseModel& model, const PoseRows& rows);

/// Gauss-Newton with the standard deviation of the readings taken from what is left, at least `least_sd`.
/// Set-ups of which there is no row stay as they are.
PoseFit fit_poses(const PoseModel& model, const std::vector<PoseRow>& rows, const PoseState& start,
                  double least_sd);

/// Only the set-ups of these rows are fitted; the terms stay.
PoseState fit_set_ups(const PoseModel& model, const std::vector<PoseRow>& rows, const PoseState& state);

/// By how much a reading counts less than an independent one, as a factor >= 1 on its standard deviation.
/// Several points on one tool share what the arm does at that place; samples of a motion share what they
/// share with their neighbours: (1 + r) / (1 - r) of them are worth one, r their correlation. Source: G.
/// Bayley, J. Hammersley, Suppl. J. R. Stat. Soc. 8 (1946) 184.
double crowding(const std::vector<PoseRow>& rows, const Eigen::VectorXd& residual);

/// How many different joint poses there are.
int places_of(const std::vector<PoseRow>& rows);

/// [m] root mean square of the error of a point (3-D) or a length. 0 for none.
double pose_rms(const Eigen::VectorXd& residual, int per_row);
/// [m] its median. 0 for none.
double pose_median(const Eigen::VectorXd& residual, int per_row);

/// 1 / prior variance per column, in the order of PoseModel's columns: next to nothing for set-ups.
Eigen::VectorXd prior_weights(const PoseState& state, bool lengths);

/// All columns of a state side by side: readings x (nuisance + values).
Eigen::MatrixXd pose_columns(const PoseModel& model, const std::vector<PoseRow>& rows, const PoseState& state,
                             const std::vector<PoseGeometry>& geometry);

}  // namespace ballbar
