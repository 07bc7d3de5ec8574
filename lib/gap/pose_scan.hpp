#pragma once
/// Where in rate or time something may be: proposals for the evidence search, cheap and without elimination.

#include <Eigen/Core>
#include <vector>

#include "gap/pose_model.hpp"

namespace ballbar {

/// A place that a scan proposes.
struct PosePeak {
  int joint = 0;         ///< from 1; 0: a jump
  double setting = 0.0;  ///< cycles per turn, or row
  double power = 0.0;    ///< half the drop of chi-squared
  double places = 1.0;   ///< independent places that were looked at
  double stroke = 0.0;   ///< [rad] of the joint
};

/// Periodogram of each joint's angle error in the joint's phase. Source: N. R. Lomb, Astrophys. Space Sci. 39
/// (1976) 447-462, with the joint's columns as weights.
/// @param residual  readings; @param sd [m] of one of them
/// @return peaks, the highest first, at most `most` a joint
std::vector<PosePeak> scan_ripples(const std::vector<PoseRow>& rows,
                                   const std::vector<PoseGeometry>& geometry, const Eigen::VectorXd& residual,
                                   int per_row, double sd, double most_cycles, int most);

/// Steps in the readings of one series from a row on. @return the highest ones, one per series at most
std::vector<PosePeak> scan_jumps(const std::vector<PoseRow>& rows, const Eigen::VectorXd& residual,
                                 int per_row, double sd);

}  // namespace ballbar
