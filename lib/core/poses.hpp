#pragma once
/// Static poses: where the joints stood, and what an instrument outside read there.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/spec.hpp"

namespace ballbar {

/// One row of a file of poses.
struct Pose {
  int row = 0;                        ///< in the file, from 1, heading not counted
  std::vector<double> joints;         ///< [rad] read back, in the robot's convention
  std::vector<double> command;        ///< [rad] commanded; empty: not known
  Vec3 point{};                       ///< [m] in the instrument's frame; where PoseSet::lengths is false
  double length = 0.0;                ///< [m] from the tool point to a fixed one; where it is true
  std::string series;                 ///< one placement of the instrument
  std::string tool;                   ///< column `point`: which of the points on the tool
  std::optional<double> time;         ///< [s]
  std::optional<double> payload;      ///< [kg] on the flange
  std::optional<double> temperature;  ///< [degC]
  int direction = 0;                  ///< +1 or -1: from which side the pose was driven to; 0 = not known
  bool held_out = false;              ///< not to be fitted
};

struct PoseSet {
  bool lengths = false;          ///< every pose has a length, else every pose has a point
  bool held_out_column = false;  ///< the file says which poses are not to be fitted
  std::vector<Pose> poses;       ///< in the order of measurement
};

}  // namespace ballbar
