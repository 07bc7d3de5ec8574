#pragma once
/// A chain of rotating joints as a modified DH table: forward kinematics, Jacobian, and what each parameter
/// does to the tip. All joint angles here are those of the URDF chain; RobotModel translates the ones on the
/// wire.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <array>
#include <span>
#include <vector>

namespace ballbar {

inline constexpr int kMaxChainJoints = 16;  ///< so that nothing here needs the heap

using JointVector = Eigen::Matrix<double, Eigen::Dynamic, 1, Eigen::ColMajor, kMaxChainJoints, 1>;
using JointColumns = Eigen::Matrix<double, 3, Eigen::Dynamic, Eigen::ColMajor, 3, kMaxChainJoints>;
using Jacobian = Eigen::Matrix<double, 6, Eigen::Dynamic, Eigen::ColMajor, 6, kMaxChainJoints>;

/// Row i of the table: X_{i-1,i} = Tx(a) Rx(alpha) Ry(beta) Rz(theta + sign q) Tz(d). z_i lies along joint
/// axis i, x_{i-1} along the way from axis i-1 to axis i. beta is 0 unless the axes are nearly, but not
/// quite, parallel. Source: J. J. Craig, Introduction to Robotics (modified DH); S. Hayati, CDC 1983, for
/// beta of parallel axes.
struct DhRow {
  double a = 0.0;      ///< [m] axis i-1 to axis i, along x_{i-1}
  double alpha = 0.0;  ///< [rad] z_{i-1} to z_i, about x_{i-1}
  double beta =
      0.0;  ///< [rad] second tilt of z_i, about y after alpha, through the point of axis i that a leads to
  double theta = 0.0;  ///< [rad] x_{i-1} to x_i about z_i, at chain angle 0
  double d = 0.0;      ///< [m] along z_i
  double sign = 1.0;   ///< +1 where the joint turns about z_i, -1 where it turns about -z_i
};

/// How one row of a real robot differs from the nominal one. The angle that counts is (chain angle +
/// zero_offset).
struct LinkDeviation {
  double zero_offset =
      0.0;             ///< [rad] in the chain angle, about the joint's own axis (so not times DhRow::sign)
  double a = 0.0;      ///< [m]
  double d = 0.0;      ///< [m]
  double alpha = 0.0;  ///< [rad]
  double beta = 0.0;   ///< [rad]
};

struct ChainDeviation {
  std::vector<LinkDeviation> links;                ///< one per joint, or empty
  Eigen::Vector3d tool = Eigen::Vector3d::Zero();  ///< [m] of the tool point, along the axes of the tip frame
};

/// Where a joint turns at given angles, in the base frame.
struct JointAxis {
  Eigen::Vector3d origin;     ///< [m] a point on the axis
  Eigen::Vector3d direction;  ///< unit; + is the sense in which the chain angle grows
};

/// Derivatives of the tip's position in the base frame by every parameter; one column per joint.
struct PositionColumns {
  JointColumns joint;    ///< [m/rad] zero offset, which is also the chain angle itself
  JointColumns a;        ///< [m/m]
  JointColumns d;        ///< [m/m]
  JointColumns alpha;    ///< [m/rad]
  JointColumns beta;     ///< [m/rad]
  Eigen::Matrix3d tool;  ///< [m/m] x, y, z in the tip frame
};

/// Frames of the table at given angles, in the base frame; frame i turns with joint i. Entries up to joints -
/// 1 are set.
struct ChainFrames {
  std::array<Eigen::Matrix3d, kMaxChainJoints> rotation;
  std::array<Eigen::Vector3d, kMaxChainJoints> origin;  ///< [m] each on its joint's axis
  Eigen::Isometry3d tip;
};

/// Immutable value. Every function takes joints() finite chain angles [rad] and throws std::invalid_argument
/// for anything else.
class Chain {
 public:
  /// @param base  X_B0, the pose of the table's frame 0 in the base frame
  /// @param rows  1..kMaxChainJoints
  /// @param tool  the pose of the tip in the last joint's frame
  /// @throws std::invalid_argument for another count of rows
  Chain(const Eigen::Isometry3d& base, std::vector<DhRow> rows, const Eigen::Isometry3d& tool);

  int joints() const { return static_cast<int>(rows_.size()); }
  const std::vector<DhRow>& rows() const { return rows_; }

  /// The same chain as built. Deviations of a chain that is as built already add up.
  /// @throws std::invalid_argument where the links are neither none nor one per joint
  Chain with(const ChainDeviation& deviation) const;

  /// Pose X_BT of the tip in the base frame.
  Eigen::Isometry3d forward(std::span<const double> q) const;

  /// The tip's place alone [m], in half the time: a point is carried from the tip to the base.
  Eigen::Vector3d tip(std::span<const double> q) const;

  ChainFrames frames(std::span<const double> q) const;

  std::vector<JointAxis> joint_axes(std::span<const double> q) const;

  /// Rows 0..2: velocity of the tip [m/rad], rows 3..5: its angular velocity [rad/rad]; both in the base
  /// frame.
  Jacobian jacobian(std::span<const double> q) const;

  /// Exact at this chain, whether nominal or as built. A length moves the tip along its axis, an angle turns
  /// it about its line.
  PositionColumns position_columns(std::span<const double> q) const;

 private:
  struct Link {                   ///< a row, multiplied out
    Eigen::Matrix3d rotation;     ///< Rx(alpha) Ry(beta) Rz(theta)
    Eigen::Vector3d translation;  ///< [m] of Tx(a) and of d along z_i
    Eigen::Vector3d tilt_axis;    ///< of beta, in frame i-1: y after alpha
  };

  void check(std::span<const double> q) const;
  void step(std::size_t joint, double angle, Eigen::Matrix3d& rotation, Eigen::Vector3d& origin) const;

  Eigen::Isometry3d base_;
  std::vector<DhRow> rows_;
  Eigen::Isometry3d tool_;
  std::vector<Link> links_;
};

}  // namespace ballbar
