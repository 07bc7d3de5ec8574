#pragma once
/// Nominal kinematics of one robot: URDF text to a chain, joint conventions, forward kinematics.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <map>
#include <span>
#include <string>
#include <vector>

#include "core/spec.hpp"
#include "kinematics/chain.hpp"
#include "kinematics/dynamics.hpp"

namespace ballbar {

struct UrdfChain;  // inside kinematics/

struct JointLimit {
  std::string name;
  double lower = 0.0;     ///< [rad] of the chain angle
  double upper = 0.0;     ///< [rad] of the chain angle
  double velocity = 0.0;  ///< [rad/s]
};

/// Immutable; any number of users at once. KDL and urdfdom stay behind this door.
/// Angles here are those of the robot's joint convention, as on the wire; chain() works in angles of the URDF
/// chain.
class RobotModel {
 public:
  /// @param urdf_text  the URDF itself, not a path
  /// @param base,tip   names of two links; tip must be a descendant of base, or both of one root
  /// @throws Error(kInput) naming the link or joint, where the text is no URDF, holds no such chain, or one
  /// that the joint
  ///         convention cannot be meant for
  RobotModel(const std::string& urdf_text, const std::string& base, const std::string& tip,
             JointConvention convention);

  int joints() const { return chain_.joints(); }
  const std::vector<JointLimit>& limits() const { return limits_; }  ///< of the chain's joints, from the base
  JointConvention convention() const { return convention_; }

  /// Angles on the wire to angles of the URDF chain, in place. Source: metrology.md 3 (J2/J3 coupling of
  /// FANUC controllers).
  /// @param q  joints() values [rad]
  void to_chain(std::span<double> q) const;

  /// And back.
  void from_chain(std::span<double> q) const;

  /// The nominal chain as a modified DH table; chain().with(deviation) is the robot as built.
  const Chain& chain() const { return chain_; }

  /// Pose X_BT of the tip in the base frame.
  /// @param q  joints() values [rad], in the robot's joint convention
  /// @throws std::invalid_argument for another count or a value that is not finite
  Eigen::Isometry3d forward(std::span<const double> q) const;

  /// The same of the robot as built. For many poses keep chain().with(deviation) instead.
  Eigen::Isometry3d forward(std::span<const double> q, const ChainDeviation& deviation) const;

  /// As Chain::jacobian, but by the angles of the robot's joint convention.
  Jacobian jacobian(std::span<const double> q) const;

  /// The URDF's masses that move with a joint; those of moving side branches are left out.
  const std::vector<Body>& bodies() const { return bodies_; }

  /// A point mass in front of the flange, to be put beside bodies().
  /// @param mass  [kg]
  /// @param com   [m] in the frame of `link`
  /// @param link  must not move against the tip, e.g. "tool0"
  /// @throws Error(kInput) where there is no such link
  Body payload(double mass, const Eigen::Vector3d& com, const std::string& link) const;

 private:
  RobotModel(UrdfChain urdf, JointConvention convention);
  JointVector chain_angles(std::span<const double> q) const;

  JointConvention convention_;
  Chain chain_;
  std::vector<JointLimit> limits_;
  std::vector<Body> bodies_;
  std::map<std::string, Eigen::Isometry3d>
      hand_;  ///< links that stand still against the tip: pose in the last joint's frame
};

}  // namespace ballbar
