#pragma once
/// Static poses made ready for a diagnosis: angles of the chain, repeats averaged, what each row offers.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "core/poses.hpp"
#include "kinematics/chain.hpp"
#include "physics/as_built.hpp"

namespace ballbar {

/// One pose as measured once, or several times without moving between.
struct PoseRow {
  JointVector q;         ///< [rad] chain angles, read back
  JointVector known;     ///< [rad] link minus reading, by the effects already configured
  JointVector torque;    ///< [Nm] that gravity asks of the drives
  JointVector move;      ///< [rad] from the pose before it in its series; 0 at the first
  JointVector approach;  ///< sign of move; 0 below a thousandth of a degree
  JointVector command;   ///< [rad] commanded minus read back; 0 where not known
  JointVector speed;     ///< [rad/s] where the rows are samples of a motion; else 0
  int frame = 0;         ///< of PoseRows::frames
  int tool = 0;          ///< of PoseRows::tools
  Eigen::Vector3d point = Eigen::Vector3d::Zero();  ///< [m] where PoseRows::lengths is false
  double length = 0.0;                              ///< [m] where it is true
  double direction = 0.0;                           ///< +1, -1, 0
  double time = 0.0;                                ///< [s] since the first row; 0 where not known
  double order = 0.0;                               ///< place in the file, 0 to 1
  int row = 0;                                      ///< in the file, from 1: the first of its repeats
  int repeats = 1;
  int place = 0;  ///< rows with the same joint angles have the same number
  bool held_out = false;
};

struct PoseRows {
  bool lengths = false;
  std::vector<PoseRow> rows;             ///< in the order of measurement
  std::vector<std::string> frames;       ///< names of the series
  std::vector<bool> frame_held_out;      ///< a series that is held out as a whole
  std::vector<std::string> tools;        ///< "SERIES" or "SERIES:POINT"
  std::vector<std::string> not_applied;  ///< configured effects that static poses cannot show or take
  bool timed = false;                    ///< all rows have a time
  bool moving = false;                   ///< rows are samples of a motion: speed is set
  bool commanded = false;
  bool directed = false;  ///< some rows come from +, others from -
  int places = 0;
  double repeat_sd = 0.0;  ///< [m] of one reading of one coordinate (or length), from repeats
  int repeat_dof = 0;

  int per_row() const { return lengths ? 1 : 3; }  ///< readings of one row
};

/// @param series_held_out  names of series not to be fitted, besides those that end in "-held-out"
/// @throws Error(kInput) where the poses cannot be those of this robot, or too few are left
PoseRows prepare_poses(const PoseSet& set, const AsBuilt& robot, const RobotSpec& spec,
                       const std::vector<std::string>& series_held_out = {});

/// How a part of the rows is chosen to be predicted and not fitted.
/// @return true per row that is held out
std::vector<bool> hold_out_blocks(const PoseRows& rows, int part, int parts);  ///< contiguous in each series
std::vector<bool> hold_out_random(const PoseRows& rows, int part, int parts, unsigned seed);

/// Rows that leave the joint range of the fitted ones. A map of what each joint does is worth nothing there.
struct PoseCoverage {
  int outside = 0;  ///< of the held-out rows
  struct Joint {
    int joint = 0;  ///< from 1
    int outside = 0;
    double fitted_least = 0.0, fitted_most = 0.0;  ///< [rad]
    double least = 0.0, most = 0.0;                ///< [rad] of the held-out rows
  };
  std::vector<Joint> joints;  ///< only those that are left
};
/// @param slack  [rad] that a held-out row may lie beyond
PoseCoverage pose_coverage(const std::vector<PoseRow>& fitted, const std::vector<PoseRow>& held_out,
                           double slack = 0.035);

}  // namespace ballbar
