#pragma once
/// FANUC LR Mate 200iC with numbers of its own: modified (Craig) DH, 4x4 matrices, point masses. Metres,
/// radians. Angles are those of the URDF chain. Shares nothing with lib/.

#include <Eigen/Geometry>
#include <array>
#include <vector>

namespace blind {

using Eigen::Vector3d;
using Joints = std::array<double, 6>;

constexpr double kRad = std::numbers::pi / 180.0;

/// What a robot as built differs in from the drawing; row 0 is that of joint 1.
struct Deviations {
  Joints a{}, d{}, alpha{}, beta{};
  Vector3d tool = Vector3d::Zero();  ///< in the axes of the flange, z out of it
};

/// Assumed masses (the maker publishes none), true ones beside them: factors of the upper arm, forearm and
/// wrist, and how far their centres lie off, along the arm.
struct Masses {
  double upper_arm = 1.0, forearm = 1.0, wrist = 1.0;
  double upper_arm_off = 0.0, forearm_off = 0.0, payload_off = 0.0;  ///< [m]
};

/// Tool point in base coordinates.
Vector3d tool_point(const Joints& q, const Deviations& off);

/// Angles at which the nominal tool point stands at `point` with `tool` as orientation: elbow up, J5
/// negative. J4 and J6 are within half a turn of those of `near`. Throws std::domain_error where the arm does
/// not reach, or comes within 2 deg of the wrist's singularity.
Joints inverse(const Vector3d& point, const Eigen::Matrix3d& tool, const Joints& near);

/// Torque [Nm] that each joint must give about its own axis, against gravity and inertia. q: steps of one
/// motion, `step` [s] apart. Accelerations of the point masses are second differences of their places.
std::vector<Joints> torques(const std::vector<Joints>& q, double step, double payload_kg,
                            const Masses& masses);

}  // namespace blind
