#include "kinematics/urdf_reader.hpp"

#include <console_bridge/console.h>
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

using Eigen::Isometry3d;

[[noreturn]] void refuse(const std::string& why) { throw Error(Cause::kInput, "URDF: " + why); }

/// urdfdom says what is wrong on the terminal only, by way of this library. Here it becomes the error's text.
class ParserMessages : public console_bridge::OutputHandler {
 public:
  ParserMessages() { console_bridge::useOutputHandler(this); }
  ~ParserMessages() override { console_bridge::restorePreviousOutputHandler(); }
  ParserMessages(const ParserMessages&) = delete;
  ParserMessages& operator=(const ParserMessages&) = delete;
  void log(const std::string& text, console_bridge::LogLevel level, const char*, int) override {
    if (level != console_bridge::CONSOLE_BRIDGE_LOG_ERROR) return;
    const std::string line = text.substr(0, text.find('\n'));
    if (inertial_.empty() && line.find("inertial element for Link") != std::string::npos)
      inertial_ = before_ + "; " + line;
    before_ = line;
    // The first says what, the second where; what follows only repeats that it failed.
    if (++count_ <= 2) said_ += (said_.empty() ? "" : "; ") + line;
  }
  const std::string& said() const { return said_; }
  /// Of an <inertial> that was left out; empty: all were read.
  const std::string& inertial() const { return inertial_; }

 private:
  std::string said_, inertial_, before_;
  int count_ = 0;
};

urdf::ModelInterfaceSharedPtr parse(const std::string& text) {
  ParserMessages messages;
  urdf::ModelInterfaceSharedPtr model;
  // urdfdom takes what it quotes of a file for a format of printf: "%n" there writes to memory.
  std::string harmless = text;
  std::replace(harmless.begin(), harmless.end(), '%', '_');
  std::string thrown;
  try {
    model = urdf::parseURDF(harmless);
  } catch (const std::exception& error) {  // not seen so far, but nothing promises it
    thrown = error.what();
  }
  if (!model) {
    const std::string& why = messages.said().empty() ? thrown : messages.said();
    refuse("cannot be read as a robot" + (why.empty() ? why : " (" + why + ")") +
           "; check it with check_urdf");
  }
  // urdfdom goes on with a link without mass.
  if (!messages.inertial().empty()) refuse(messages.inertial() + "; correct its <inertial>");
  return model;
}

KDL::Frame to_kdl(const urdf::Pose& pose) {
  const auto& r = pose.rotation;
  const auto& p = pose.position;
  return {KDL::Rotation::Quaternion(r.x, r.y, r.z, r.w), KDL::Vector(p.x, p.y, p.z)};
}

Eigen::Vector3d to_eigen(const KDL::Vector& v) { return {v(0), v(1), v(2)}; }

Isometry3d to_eigen(const KDL::Frame& frame) {
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() = to_eigen(frame.p);
  for (int row = 0; row < 3; ++row)
    for (int column = 0; column < 3; ++column) pose.linear()(row, column) = frame.M(row, column);
  return pose;
}

bool moves(const urdf::Joint& joint) { return joint.type != urdf::Joint::FIXED; }

/// One URDF joint and the link behind it: the joint's axis goes through its origin, in the parent's frame.
KDL::Segment to_segment(const urdf::Joint& joint) {
  constexpr double kFarthest = 1000.0;  // [m]
  const KDL::Frame origin = to_kdl(joint.parent_to_joint_origin_transform);
  if (!(origin.p.Norm() < kFarthest))
    refuse("joint '" + joint.name +
           "' lies a kilometre or more from its parent; an <origin xyz=.../> is in metres");
  if (!moves(joint))
    return KDL::Segment(joint.child_link_name, KDL::Joint(joint.name, KDL::Joint::None), origin);
  if (joint.type != urdf::Joint::REVOLUTE && joint.type != urdf::Joint::CONTINUOUS)
    refuse("joint '" + joint.name + "' is neither revolute nor fixed; only rotating joints are known");
  if (joint.mimic)
    refuse("joint '" + joint.name + "' follows another one (mimic); a chain of free joints is needed");
  const KDL::Vector axis(joint.axis.x, joint.axis.y, joint.axis.z);
  if (!(axis.Norm() > 1e-6) || !std::isfinite(axis.Norm()))
    refuse("joint '" + joint.name + "' has no axis; give <axis xyz=.../> a length");
  return KDL::Segment(joint.child_link_name,
                      KDL::Joint(joint.name, origin.p, origin.M * axis, KDL::Joint::RotAxis), origin);
}

JointLimit limit_of(const urdf::Joint& joint) {
  JointLimit limit{joint.name, -1e9, 1e9, 0.0};
  if (joint.type != urdf::Joint::REVOLUTE || !joint.limits) return limit;
  limit = {joint.name, joint.limits->lower, joint.limits->upper, joint.limits->velocity};
  if (!std::isfinite(limit.lower) || !std::isfinite(limit.upper) || !std::isfinite(limit.velocity))
    refuse("joint '" + joint.name + "' has a limit that is not a number; correct its <limit>");
  if (limit.lower >= limit.upper)
    refuse("joint '" + joint.name +
           "' has a lower limit that is not below its upper one; correct its <limit>");
  return limit;
}

using Path = std::vector<const urdf::Link*>;

Path to_root(const urdf::ModelInterface& model, const std::string& name) {
  Path path;
  for (urdf::LinkConstSharedPtr link = model.getLink(name); link; link = link->getParent()) {
    path.push_back(link.get());
    if (path.size() > model.links_.size())  // urdfdom takes links that hang on each other
      refuse("the links that '" + name + "' hangs on form a ring");
  }
  if (path.empty()) refuse("no link '" + name + "'; base and tip name links of the URDF");
  return path;
}

Body body_of(const urdf::Link& link, int joint, const KDL::Frame& pose) {
  const urdf::Inertial& inertial = *link.inertial;
  const KDL::Frame at = pose * to_kdl(inertial.origin);
  const Eigen::Matrix3d rotation = to_eigen(at).linear();
  Body body{link.name, joint, inertial.mass, to_eigen(at.p), Eigen::Matrix3d::Zero()};
  body.inertia << inertial.ixx, inertial.ixy, inertial.ixz, inertial.ixy, inertial.iyy, inertial.iyz,
      inertial.ixz, inertial.iyz, inertial.izz;
  body.inertia = (rotation * body.inertia * rotation.transpose()).eval();
  if (!std::isfinite(body.mass) || body.mass < 0 || !body.com.allFinite() || !body.inertia.allFinite())
    refuse("link '" + link.name + "' has a mass, centre or inertia that cannot be; correct its <inertial>");
  return body;
}

/// The link and all that is fixed to it, without what moves against it.
void add_rigid(const urdf::Link& link, int joint, const KDL::Frame& pose, UrdfChain& found) {
  if (link.inertial && joint > 0) found.bodies.push_back(body_of(link, joint, pose));
  found.hand[link.name] = to_eigen(pose);
  for (const urdf::JointSharedPtr& child : link.child_joints)
    if (!moves(*child))
      for (const urdf::LinkSharedPtr& next : link.child_links)
        if (next->name == child->child_link_name)
          add_rigid(*next, joint, pose * to_kdl(child->parent_to_joint_origin_transform), found);
}

/// Postures away from zero, so that a wrong sign anywhere shows.
void add_checkpoints(const KDL::Chain& chain, const KDL::Frame& base_in_start, UrdfChain& found) {
  KDL::ChainFkSolverPos_recursive solver(chain);
  for (int k = 0; k < 3; ++k) {
    Checkpoint checkpoint;
    KDL::JntArray q(chain.getNrOfJoints());
    for (unsigned i = 0; i < q.rows(); ++i) {
      q(i) = 0.37 * k * (i + 1.0);
      checkpoint.q.push_back(q(i));
    }
    KDL::Frame tip;
    if (solver.JntToCart(q, tip) < 0) throw std::logic_error("KDL refused a chain that was checked");
    checkpoint.tip = to_eigen(base_in_start.Inverse() * tip);
    found.checkpoints.push_back(checkpoint);
  }
}

}  // namespace

UrdfChain read_urdf(const std::string& urdf_text, const std::string& base, const std::string& tip) {
  const urdf::ModelInterfaceSharedPtr model = parse(urdf_text);
  const Path base_path = to_root(*model, base);
  Path tip_path = to_root(*model, tip);
  // Both hang on one tree: from the nearest link they share, one way leads to the base (fixed) and one to the
  // tip (the chain).
  const auto shared =
      std::find_first_of(base_path.begin(), base_path.end(), tip_path.begin(), tip_path.end());
  KDL::Frame base_in_start;
  for (auto link = std::make_reverse_iterator(shared); link != base_path.rend(); ++link) {
    const urdf::Joint& joint = *(*link)->parent_joint;
    if (moves(joint))
      refuse("'" + base + "' moves with joint '" + joint.name + "'; the base must stand still");
    base_in_start = base_in_start * to_kdl(joint.parent_to_joint_origin_transform);
  }
  tip_path.erase(std::find(tip_path.begin(), tip_path.end(), *shared), tip_path.end());

  UrdfChain found;
  KDL::Chain chain;
  KDL::Frame pose = base_in_start.Inverse();  // of the link at hand, all joints at zero, in the base frame
  for (auto link = tip_path.rbegin(); link != tip_path.rend(); ++link) {
    const urdf::Joint& joint = *(*link)->parent_joint;
    chain.addSegment(to_segment(joint));
    pose = pose * to_kdl(joint.parent_to_joint_origin_transform);
    if (!moves(joint)) continue;
    const KDL::Vector axis(joint.axis.x, joint.axis.y, joint.axis.z);
    found.axes.push_back({to_eigen(pose.p), to_eigen(pose.M * axis).normalized()});
    found.limits.push_back(limit_of(joint));
    found.hand.clear();
    add_rigid(**link, static_cast<int>(found.axes.size()), pose, found);
  }
  if (found.axes.empty())
    refuse("no joint moves between '" + base + "' and '" + tip + "'; name the robot's base and tool point");
  if (found.axes.size() > kMaxChainJoints)
    refuse(std::to_string(found.axes.size()) + " joints between '" + base + "' and '" + tip + "'; at most " +
           std::to_string(kMaxChainJoints) + " are possible");
  found.tip = to_eigen(pose);
  add_checkpoints(chain, base_in_start, found);
  return found;
}

}  // namespace ballbar
