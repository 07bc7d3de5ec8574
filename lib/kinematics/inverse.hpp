#pragma once
/// Inverse kinematics to nanometres, for any chain, along paths, with limits; and why where there is none.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <span>
#include <vector>

#include "core/spec.hpp"
#include "kinematics/robot_model.hpp"

namespace ballbar {

enum class IkStatus {
  kOk,
  kUnreachable,  ///< no joint angles bring the tip there
  kLimit,        ///< the tip gets there, but a joint would have to pass its limit
  kSingular,     ///< the tip gets there, but the joints cannot move it on in every direction, or have to jump
};

struct IkOptions {
  double position = 1e-9;  ///< [m] how near is there
  double rotation = 1e-9;  ///< [rad]
  double singular = 2e-3;  ///< smallest singular value of the Jacobian (metres and radians as they are) below
                           ///< which is singular
  double step = 0.35;      ///< [rad] largest move of a joint from one pose of a path to the next
  int starts = 128;        ///< postures that the search over all configurations starts from
};

struct IkResult {
  IkStatus status = IkStatus::kUnreachable;
  std::vector<double> q;  ///< [rad] in the robot's joint convention; the nearest found where unreachable
  int joint = 0;          ///< from 1, at its limit; 0 unless kLimit
  double smallest_singular_value = 0.0;  ///< of the Jacobian at q
  double position_error = 0.0;           ///< [m] at q
  double rotation_error = 0.0;           ///< [rad] at q
};

/// Pose of the tip from what is programmed.
/// @param position  [m] in the base frame
/// @param rpy       [rad] turn about the base's X, then Y, then Z (FANUC W, P, R)
Eigen::Isometry3d tool_pose(const Vec3& position, const Vec3& rpy);

/// The turn from `from` to `to` as axis times angle in the base frame; exact for the smallest angles.
Eigen::Vector3d rotation_between(const Eigen::Matrix3d& from, const Eigen::Matrix3d& to);

/// The solution that Newton's method finds from a seed; a joint is never turned by whole turns.
/// @param X_BT  pose of the tip in the base frame
/// @param seed  joints() angles [rad] in the robot's joint convention
/// @throws std::invalid_argument for another count, or a value that is not finite
IkResult inverse_near(const RobotModel& model, const Eigen::Isometry3d& X_BT, std::span<const double> seed,
                      const IkOptions& options = {});

/// Of all configurations, within limits, the one nearest to a reference posture: least sum of squares of the
/// chain angles' differences. Without a reference that is the posture of all zeros; so an LR Mate with its
/// tool down stands elbow up, wrist not flipped. The search starts from fixed postures: same question, same
/// answer.
/// @param reference  joints() angles [rad] in the robot's joint convention, or none
IkResult inverse(const RobotModel& model, const Eigen::Isometry3d& X_BT,
                 std::span<const double> reference = {}, const IkOptions& options = {});

struct PathResult {
  IkStatus status = IkStatus::kOk;
  int index = -1;                        ///< of the pose that failed; -1 = none
  int joint = 0;                         ///< from 1, at its limit there; 0 unless kLimit
  double smallest_singular_value = 0.0;  ///< of the path, or of the pose that failed
  Eigen::MatrixXd q;  ///< [rad] joints x poses in the robot's joint convention; columns from index on are 0
};

/// A path in one configuration: the first pose by inverse(), each one after it from the former solution.
/// @param reference  as for inverse(): chooses the configuration
PathResult solve_path(const RobotModel& model, std::span<const Eigen::Isometry3d> poses,
                      std::span<const double> reference = {}, const IkOptions& options = {});

}  // namespace ballbar
