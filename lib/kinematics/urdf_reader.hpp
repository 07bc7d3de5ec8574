#pragma once
/// Inside kinematics/ only: what RobotModel takes from a URDF. urdfdom and KDL stay in the .cpp.

#include <Eigen/Geometry>
#include <map>
#include <string>
#include <vector>

#include "kinematics/chain.hpp"
#include "kinematics/dynamics.hpp"
#include "kinematics/robot_model.hpp"

namespace ballbar {

/// Where KDL puts the tip, to hold the table against.
struct Checkpoint {
  std::vector<double> q;  ///< [rad] chain angles
  Eigen::Isometry3d tip;  ///< in the base frame
};

/// The chain from base to tip with all joints at zero, everything in the base frame.
struct UrdfChain {
  std::vector<JointAxis> axes;
  std::vector<JointLimit> limits;
  Eigen::Isometry3d tip;
  std::vector<Body> bodies;                       ///< com and inertia in the base frame
  std::map<std::string, Eigen::Isometry3d> hand;  ///< links that do not move against the tip: their poses
  std::vector<Checkpoint> checkpoints;
};

/// @throws Error(kInput) naming the link or joint
UrdfChain read_urdf(const std::string& urdf_text, const std::string& base, const std::string& tip);

}  // namespace ballbar
