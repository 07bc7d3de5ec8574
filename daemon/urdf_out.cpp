#include "daemon/urdf_out.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <map>
#include <vector>

#include "core/error.hpp"
#include "files/urdf_joints.hpp"
#include "physics/catalogue.hpp"

namespace ballbar {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

Isometry3d origin_of(const UrdfJoint& joint) {
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() = (AngleAxisd(joint.rpy[2], Vector3d::UnitZ()) * AngleAxisd(joint.rpy[1], Vector3d::UnitY()) *
                   AngleAxisd(joint.rpy[0], Vector3d::UnitX()))
                      .toRotationMatrix();
  pose.translation() = Vector3d(joint.xyz[0], joint.xyz[1], joint.xyz[2]);
  return pose;
}

/// Roll first, the rest from what it leaves: exact near a pitch of 90 degrees too.
UrdfJoint with_origin(UrdfJoint joint, const Isometry3d& pose) {
  const Matrix3d rotation = pose.linear();
  const double roll = std::atan2(rotation(2, 1), rotation(2, 2));
  const Matrix3d rest = rotation * AngleAxisd(-roll, Vector3d::UnitX()).toRotationMatrix();
  joint.rpy = {roll, std::atan2(-rest(2, 0), rest(2, 2)), std::atan2(-rest(0, 1), rest(1, 1))};
  joint.xyz = {pose.translation().x(), pose.translation().y(), pose.translation().z()};
  return joint;
}

/// Joints from the root to a link.
std::vector<UrdfJoint> way_to(const std::vector<UrdfJoint>& joints, const std::string& link) {
  std::map<std::string, UrdfJoint> above;
  for (const UrdfJoint& joint : joints) above[joint.child] = joint;
  std::vector<UrdfJoint> way;
  for (auto found = above.find(link); found != above.end(); found = above.find(found->second.parent))
    way.insert(way.begin(), found->second);
  return way;
}

Isometry3d frame(const ChainFrames& frames, std::size_t joint) {
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() = frames.rotation.at(joint);
  pose.translation() = frames.origin.at(joint);
  return pose;
}

/// Effects that are not in the file, for a comment.
std::string left_aside(const AsBuilt& built) {
  std::string names;
  for (const Effect& effect : built.effects())
    if (!effect.kind->geometry || effect.kind->growth)
      names += (names.empty() ? "" : ", ") + std::string(effect.kind->name) +
               (effect.joint > 0 ? " of joint " + std::to_string(effect.joint) : "");
  return names;
}

}  // namespace

std::string as_built_urdf(const std::string& urdf_text, const RobotSpec& spec, const AsBuilt& built) {
  const std::vector<UrdfJoint> joints = urdf_joints(urdf_text);
  Isometry3d root_to_base = Isometry3d::Identity();
  for (const UrdfJoint& joint : way_to(joints, spec.base)) {
    if (joint.moves)
      throw Error(Cause::kInput, "URDF: joint '" + joint.name + "' moves between the root and '" + spec.base +
                                     "': the robot as built cannot be written");
    root_to_base = root_to_base * origin_of(joint);
  }
  const std::vector<double> zero(static_cast<std::size_t>(built.model().joints()), 0.0);
  const ChainFrames nominal = built.model().chain().frames(zero), found = built.chain().frames(zero);

  // Every link keeps its place in the frame of its joint; a joint's origin makes up for what moved before it.
  Isometry3d was = Isometry3d::Identity(), is = Isometry3d::Identity();
  std::size_t number = 0;
  std::vector<UrdfJoint> changed;
  const std::vector<UrdfJoint> way = way_to(joints, spec.tip);
  for (const UrdfJoint& joint : way) {
    const Isometry3d before = is;
    was = was * origin_of(joint);
    if (joint.moves) {
      is = root_to_base * frame(found, number) * (root_to_base * frame(nominal, number)).inverse() * was;
      ++number;
    } else if (&joint == &way.back()) {
      is = root_to_base * found.tip;
    } else {
      is = is * origin_of(joint);
      continue;
    }
    changed.push_back(with_origin(joint, before.inverse() * is));
  }
  if (!way.empty() && way.back().moves &&
      (is.translation() - root_to_base * found.tip.translation()).norm() > 1e-9)
    throw Error(Cause::kInput, "URDF: tip '" + spec.tip +
                                   "' turns with the last joint: a tool that is off has no place; put a "
                                   "fixed joint before the tip");
  std::string comment =
      " As built, by ballbar diagnose: zero offsets, lengths, twists and tool are in the joints' origins. ";
  if (const std::string names = left_aside(built); !names.empty())
    comment += "Not in here, for a URDF holds only geometry: " + names + ". ";
  return with_origins(urdf_text, changed, comment);
}

}  // namespace ballbar
