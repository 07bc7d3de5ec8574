#pragma once
/// Robots that the kinematics are tried on, and a second opinion on them: KDL, by a conversion of its own.

#include <urdf_parser/urdf_parser.h>

#include <array>
#include <cmath>
#include <fstream>
#include <kdl/chain.hpp>
#include <kdl/jntarray.hpp>
#include <random>
#include <sstream>
#include <string>
#include <vector>

#include "core/units.hpp"
#include "kinematics/robot_model.hpp"

namespace ballbar::test {

inline std::string text_of(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

inline const std::string& lrmate() {
  static const std::string text = text_of(BALLBAR_SOURCE_DIR "/scripts/robots/lrmate200ic.urdf");
  return text;
}

inline RobotModel lrmate_model(JointConvention convention = JointConvention::kFanuc) {
  return RobotModel(lrmate(), "base", "tcp", convention);
}

inline std::vector<double> radians(std::vector<double> degrees) {
  for (double& d : degrees) d *= kRadPerDeg;
  return degrees;
}

inline std::vector<double> random_angles(std::mt19937_64& random, int joints, double range) {
  std::uniform_real_distribution<double> angle(-range, range);
  std::vector<double> q(static_cast<std::size_t>(joints));
  for (double& v : q) v = angle(random);
  return q;
}

/// Links that lie askew at random, with masses; joints `nearly` and `nearly` + 1 differ by 0.2 deg only (0 =
/// none).
inline std::string crooked_robot(unsigned seed, int joints, int nearly) {
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  std::ostringstream urdf;
  urdf.precision(17);
  urdf << "<robot name='crooked'><link name='l0'/>";
  std::array<double, 3> axis{};
  for (int i = 1; i <= joints; ++i) {
    const bool same = nearly > 0 && i == nearly + 1;
    urdf
        << "<link name='l" << i << "'><inertial><origin xyz='" << any(random) << " " << any(random) << " "
        << any(random) << "' rpy='0.1 0.2 0.3'/><mass value='" << 2 + any(random)
        << "'/><inertia ixx='0.11' ixy='0.01' ixz='0.02' iyy='0.12' iyz='0.03' izz='0.13'/></inertial></link>"
        << "<joint name='j" << i << "' type='continuous'><parent link='l" << i - 1 << "'/><child link='l" << i
        << "'/><origin xyz='" << any(random) << " " << any(random) << " " << any(random) << "' rpy='";
    if (same)
      urdf << "0 0 0'/>";
    else
      urdf << any(random) << " " << any(random) << " " << any(random) << "'/>";
    for (double& v : axis) v = same ? v + 0.002 * any(random) : any(random);
    urdf << "<axis xyz='" << axis[0] << " " << axis[1] << " " << axis[2] << "'/></joint>";
  }
  urdf << "<link name='tip'/><joint name='jt' type='fixed'><parent link='l" << joints
       << "'/><child link='tip'/><origin xyz='0.3 0.1 0.2' rpy='0.4 0.5 0.6'/></joint></robot>";
  return urdf.str();
}

/// The chain from `base` down to `tip`, with masses, as KDL sees it. Base must be an ancestor of tip.
inline KDL::Chain kdl_chain(const std::string& urdf, const std::string& base, const std::string& tip) {
  const auto model = urdf::parseURDF(urdf);
  const auto frame = [](const urdf::Pose& pose) {
    double roll = 0, pitch = 0, yaw = 0;
    pose.rotation.getRPY(roll, pitch, yaw);
    return KDL::Frame(KDL::Rotation::RPY(roll, pitch, yaw),
                      KDL::Vector(pose.position.x, pose.position.y, pose.position.z));
  };
  std::vector<KDL::Segment> segments;
  for (auto link = model->getLink(tip); link->name != base; link = link->getParent()) {
    const urdf::Joint& joint = *link->parent_joint;
    const KDL::Frame origin = frame(joint.parent_to_joint_origin_transform);
    const KDL::Vector axis = origin.M * KDL::Vector(joint.axis.x, joint.axis.y, joint.axis.z);
    KDL::RigidBodyInertia body = KDL::RigidBodyInertia::Zero();
    if (link->inertial) {
      const urdf::Inertial& i = *link->inertial;
      const KDL::Frame at = frame(i.origin);
      const KDL::RotationalInertia turned =
          (KDL::Frame(at.M) *
           KDL::RigidBodyInertia(0, KDL::Vector::Zero(),
                                 KDL::RotationalInertia(i.ixx, i.iyy, i.izz, i.ixy, i.ixz, i.iyz)))
              .getRotationalInertia();
      body = KDL::RigidBodyInertia(i.mass, at.p, turned);
    }
    segments.push_back(joint.type == urdf::Joint::FIXED
                           ? KDL::Segment(link->name, KDL::Joint(joint.name, KDL::Joint::None), origin, body)
                           : KDL::Segment(link->name,
                                          KDL::Joint(joint.name, origin.p, axis, KDL::Joint::RotAxis), origin,
                                          body));
  }
  KDL::Chain chain;
  for (auto segment = segments.rbegin(); segment != segments.rend(); ++segment) chain.addSegment(*segment);
  return chain;
}

inline KDL::JntArray to_kdl(const std::vector<double>& q) {
  KDL::JntArray array(static_cast<unsigned>(q.size()));
  for (std::size_t i = 0; i < q.size(); ++i) array(static_cast<unsigned>(i)) = q[i];
  return array;
}

}  // namespace ballbar::test
