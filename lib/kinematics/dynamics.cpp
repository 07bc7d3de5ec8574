#include "kinematics/dynamics.hpp"

#include <array>
#include <stdexcept>

namespace ballbar {
namespace {

using Eigen::Matrix3d;
using Eigen::Vector3d;

/// Force and moment about the base's origin that the bodies of one joint need.
struct Wrench {
  Vector3d force = Vector3d::Zero();
  Vector3d moment = Vector3d::Zero();
};

struct Motion {
  Vector3d spin = Vector3d::Zero();          ///< [rad/s]
  Vector3d spin_rate = Vector3d::Zero();     ///< [rad/s^2]
  Vector3d acceleration = Vector3d::Zero();  ///< [m/s^2] of the joint's origin
};

Vector3d acceleration_at(const Motion& motion, const Vector3d& arm) {
  return motion.acceleration + motion.spin_rate.cross(arm) + motion.spin.cross(motion.spin.cross(arm));
}

void add(const Body& body, const Matrix3d& rotation, const Vector3d& origin, const Motion& motion,
         Wrench& wrench) {
  const Vector3d arm = rotation * body.com;
  const Matrix3d inertia = rotation * body.inertia * rotation.transpose();
  const Vector3d force = body.mass * acceleration_at(motion, arm);
  wrench.force += force;
  wrench.moment +=
      inertia * motion.spin_rate + motion.spin.cross(inertia * motion.spin) + (origin + arm).cross(force);
}

}  // namespace

JointVector joint_torques(const Chain& chain, std::span<const Body> bodies, std::span<const double> q,
                          std::span<const double> qd, std::span<const double> qdd) {
  const auto joints = static_cast<std::size_t>(chain.joints());
  if (qd.size() != joints || qdd.size() != joints)
    throw std::invalid_argument("torques: angles, speeds and accelerations must be one per joint");
  for (const Body& body : bodies)
    if (body.joint < 1 || body.joint > chain.joints())
      throw std::invalid_argument("torques: '" + body.name + "' hangs on joint " +
                                  std::to_string(body.joint) + ", which is not there");
  const ChainFrames at = chain.frames(q);
  std::array<Vector3d, kMaxChainJoints> axis;
  std::array<Wrench, kMaxChainJoints> wrench;
  Motion motion;
  motion.acceleration = kGravity * Vector3d::UnitZ();  // a base that accelerates upwards feels like gravity
  Vector3d former = Vector3d::Zero();
  for (std::size_t i = 0; i < joints; ++i) {
    axis[i] = chain.rows()[i].sign * at.rotation[i].col(2);
    // The joint's origin lies on its axis, so it moves with the link before.
    motion.acceleration = acceleration_at(motion, at.origin[i] - former);
    motion.spin_rate += axis[i] * qdd[i] + motion.spin.cross(axis[i] * qd[i]);
    motion.spin += axis[i] * qd[i];
    former = at.origin[i];
    for (const Body& body : bodies)
      if (body.joint == static_cast<int>(i) + 1) add(body, at.rotation[i], at.origin[i], motion, wrench[i]);
  }
  JointVector torques(chain.joints());
  Wrench behind;
  for (std::size_t i = joints; i-- > 0;) {
    behind.force += wrench[i].force;
    behind.moment += wrench[i].moment;
    torques(static_cast<Eigen::Index>(i)) = axis[i].dot(behind.moment - at.origin[i].cross(behind.force));
  }
  return torques;
}

JointVector gravity_torques(const Chain& chain, std::span<const Body> bodies, std::span<const double> q) {
  const std::array<double, kMaxChainJoints> rest{};
  const std::span<const double> zero(rest.data(), static_cast<std::size_t>(chain.joints()));
  return joint_torques(chain, bodies, q, zero, zero);
}

}  // namespace ballbar
