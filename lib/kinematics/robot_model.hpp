#pragma once
/// Nominal kinematics of one robot: URDF text to a chain, joint conventions, forward kinematics.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/spec.hpp"

namespace ballbar {

struct JointLimit {
  std::string name;
  double lower = 0.0;     ///< [rad]
  double upper = 0.0;     ///< [rad]
  double velocity = 0.0;  ///< [rad/s]
};

/// Immutable; any number of users at once. KDL stays behind this door.
class RobotModel {
 public:
  /// @param urdf_text  the URDF itself, not a path
  /// @param base,tip   names of two links; tip must be a descendant of base, or both of one root
  /// @throws Error(kInput) naming the link or joint, where the text is no URDF or holds no such chain
  RobotModel(const std::string& urdf_text, const std::string& base, const std::string& tip,
             JointConvention convention);
  ~RobotModel();
  RobotModel(RobotModel&&) noexcept;
  RobotModel& operator=(RobotModel&&) noexcept;

  int joints() const;
  const std::vector<JointLimit>& limits() const;  ///< of the chain's joints, from the base

  /// Angles on the wire to angles of the URDF chain, in place. Source: metrology.md 3 (J2/J3 coupling of
  /// FANUC controllers).
  /// @param q  joints() values [rad]
  void to_chain(std::span<double> q) const;

  /// Pose X_BT of the tip in the base frame.
  /// @param q  joints() values [rad], in the robot's joint convention
  /// @throws std::invalid_argument for another count or a value that is not finite
  Eigen::Isometry3d forward(std::span<const double> q) const;

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ballbar
