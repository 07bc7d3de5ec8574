#include "kinematics/robot_model.hpp"

#include <urdf_model/model.h>
#include <urdf_parser/urdf_parser.h>

#include <algorithm>
#include <cmath>
#include <kdl/chain.hpp>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <stdexcept>

#include "core/error.hpp"

namespace ballbar {
namespace {

KDL::Frame to_kdl(const urdf::Pose& pose) {
  const auto& r = pose.rotation;
  const auto& p = pose.position;
  return {KDL::Rotation::Quaternion(r.x, r.y, r.z, r.w), KDL::Vector(p.x, p.y, p.z)};
}

/// One URDF joint and the link behind it: the joint's axis goes through its origin, in the parent's frame.
KDL::Segment to_segment(const urdf::Joint& joint) {
  const KDL::Frame origin = to_kdl(joint.parent_to_joint_origin_transform);
  const KDL::Vector axis(joint.axis.x, joint.axis.y, joint.axis.z);
  switch (joint.type) {
    case urdf::Joint::FIXED:
      return KDL::Segment(joint.child_link_name, KDL::Joint(joint.name, KDL::Joint::None), origin);
    case urdf::Joint::REVOLUTE:
    case urdf::Joint::CONTINUOUS:
      return KDL::Segment(joint.child_link_name,
                          KDL::Joint(joint.name, origin.p, origin.M * axis, KDL::Joint::RotAxis), origin);
    default:
      throw Error(Cause::kInput, "URDF: joint '" + joint.name +
                                     "' is neither revolute nor fixed; only rotating joints are known");
  }
}

std::vector<const urdf::Link*> to_root(const urdf::ModelInterface& model, const std::string& name) {
  std::vector<const urdf::Link*> path;
  for (urdf::LinkConstSharedPtr link = model.getLink(name); link; link = link->getParent())
    path.push_back(link.get());
  if (path.empty())
    throw Error(Cause::kInput, "URDF: no link '" + name + "'; base and tip name links of the URDF");
  return path;
}

JointLimit limit_of(const urdf::Joint& joint) {
  JointLimit limit{joint.name, -1e9, 1e9, 0.0};
  if (joint.type == urdf::Joint::REVOLUTE && joint.limits)
    limit = {joint.name, joint.limits->lower, joint.limits->upper, joint.limits->velocity};
  return limit;
}

}  // namespace

struct RobotModel::Impl {
  KDL::Frame base_in_start;  ///< the base may hang on the tree beside the chain (FANUC World)
  KDL::Chain chain;          ///< from the nearest link that base and tip share
  std::vector<JointLimit> limits;
  JointConvention convention = JointConvention::kSerial;
};

RobotModel::RobotModel(const std::string& urdf_text, const std::string& base, const std::string& tip,
                       JointConvention convention)
    : impl_(std::make_unique<Impl>()) {
  const urdf::ModelInterfaceSharedPtr model = urdf::parseURDF(urdf_text);
  if (!model) throw Error(Cause::kInput, "URDF: cannot be read as a robot; check it with check_urdf");
  impl_->convention = convention;
  const std::vector<const urdf::Link*> base_path = to_root(*model, base);
  std::vector<const urdf::Link*> tip_path = to_root(*model, tip);
  // Both hang on one tree: from the nearest link they share, one way leads to the base (fixed) and one to the
  // tip (the chain).
  const auto shared =
      std::find_first_of(base_path.begin(), base_path.end(), tip_path.begin(), tip_path.end());
  for (auto link = std::make_reverse_iterator(shared); link != base_path.rend(); ++link) {
    const urdf::Joint& joint = *(*link)->parent_joint;
    if (joint.type != urdf::Joint::FIXED)
      throw Error(Cause::kInput,
                  "URDF: '" + base + "' moves with joint '" + joint.name + "'; the base must stand still");
    impl_->base_in_start = impl_->base_in_start * to_kdl(joint.parent_to_joint_origin_transform);
  }
  tip_path.erase(std::find(tip_path.begin(), tip_path.end(), *shared), tip_path.end());
  for (auto link = tip_path.rbegin(); link != tip_path.rend(); ++link) {
    const urdf::Joint& joint = *(*link)->parent_joint;
    impl_->chain.addSegment(to_segment(joint));
    if (joint.type != urdf::Joint::FIXED) impl_->limits.push_back(limit_of(joint));
  }
  if (impl_->limits.empty())
    throw Error(Cause::kInput, "URDF: no joint moves between '" + base + "' and '" + tip +
                                   "'; name the robot's base and tool point");
  if (convention == JointConvention::kFanuc && joints() < 3)
    throw Error(Cause::kInput, "URDF: joint_convention \"fanuc\" needs at least 3 joints");
}

RobotModel::~RobotModel() = default;
RobotModel::RobotModel(RobotModel&&) noexcept = default;
RobotModel& RobotModel::operator=(RobotModel&&) noexcept = default;

int RobotModel::joints() const { return static_cast<int>(impl_->limits.size()); }

const std::vector<JointLimit>& RobotModel::limits() const { return impl_->limits; }

void RobotModel::to_chain(std::span<double> q) const {
  if (impl_->convention == JointConvention::kFanuc) q[2] += q[1];
}

Eigen::Isometry3d RobotModel::forward(std::span<const double> q) const {
  if (q.size() != static_cast<std::size_t>(joints()))
    throw std::invalid_argument("forward: " + std::to_string(q.size()) + " joint angles for a chain of " +
                                std::to_string(joints()));
  std::vector<double> chain_angles(q.begin(), q.end());
  to_chain(chain_angles);
  KDL::JntArray array(static_cast<unsigned>(joints()));
  for (int i = 0; i < joints(); ++i) {
    if (!std::isfinite(chain_angles[static_cast<std::size_t>(i)]))
      throw std::invalid_argument("forward: a joint angle is not finite");
    array(static_cast<unsigned>(i)) = chain_angles[static_cast<std::size_t>(i)];
  }
  KDL::ChainFkSolverPos_recursive solver(impl_->chain);
  KDL::Frame tip;
  if (solver.JntToCart(array, tip) < 0)
    throw std::logic_error("forward: KDL refused a chain that was checked");
  const KDL::Frame in_base = impl_->base_in_start.Inverse() * tip;
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (int row = 0; row < 3; ++row) {
    pose.translation()(row) = in_base.p(row);
    for (int column = 0; column < 3; ++column) pose.linear()(row, column) = in_base.M(row, column);
  }
  return pose;
}

}  // namespace ballbar
