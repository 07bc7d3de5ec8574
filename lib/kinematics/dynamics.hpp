#pragma once
/// Torques that gravity and motion ask of the joints, from masses on a chain.

#include <Eigen/Core>
#include <span>
#include <string>

#include "kinematics/chain.hpp"

namespace ballbar {

inline constexpr double kGravity = 9.80665;  ///< [m/s^2] standard gravity

/// A mass that moves with one joint: a link of the URDF, or what is on the flange.
struct Body {
  std::string name;                                   ///< of the link, or "payload"
  int joint = 0;                                      ///< from 1
  double mass = 0.0;                                  ///< [kg]
  Eigen::Vector3d com = Eigen::Vector3d::Zero();      ///< [m] in the joint's frame (ChainFrames)
  Eigen::Matrix3d inertia = Eigen::Matrix3d::Zero();  ///< [kg m^2] about com, along the axes of that frame
};

/// Torque that each joint must give, positive in the sense in which its chain angle grows. Gravity points
/// along -z of the base. A drive that holds an arm up against gravity gives a torque; the gear behind it
/// bends under the opposite one. Source: recursive Newton-Euler, J. Y. S. Luh, M. W. Walker, R. P. C. Paul,
/// J. Dyn. Sys. Meas. Control 102 (1980) 69-76.
/// @param q,qd,qdd  joints() chain angles [rad], [rad/s], [rad/s^2]
/// @return [Nm]
/// @throws std::invalid_argument for another count, an angle that is not finite, or a body of a joint that is
/// not there
JointVector joint_torques(const Chain& chain, std::span<const Body> bodies, std::span<const double> q,
                          std::span<const double> qd, std::span<const double> qdd);

/// The same at rest.
JointVector gravity_torques(const Chain& chain, std::span<const Body> bodies, std::span<const double> q);

}  // namespace ballbar
