#include "daemon/urdf_out.hpp"

#include <Eigen/Geometry>
#include <cmath>
#include <cstdio>
#include <map>
#include <pugixml.hpp>
#include <sstream>
#include <vector>

#include "core/error.hpp"
#include "physics/catalogue.hpp"

namespace ballbar {
namespace {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

Vector3d triple(const char* text) {
  Vector3d values = Vector3d::Zero();
  std::istringstream words(text);
  words.imbue(std::locale::classic());
  for (double& value : values) words >> value;
  return values;
}

std::string text_of(const Vector3d& values) {
  char text[100];
  std::snprintf(text, sizeof text, "%.17g %.17g %.17g", values[0], values[1], values[2]);
  return text;
}

Isometry3d origin_of(const pugi::xml_node& joint) {
  const pugi::xml_node origin = joint.child("origin");
  const Vector3d rpy = triple(origin.attribute("rpy").as_string("0 0 0"));
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() = (AngleAxisd(rpy[2], Vector3d::UnitZ()) * AngleAxisd(rpy[1], Vector3d::UnitY()) *
                   AngleAxisd(rpy[0], Vector3d::UnitX()))
                      .toRotationMatrix();
  pose.translation() = triple(origin.attribute("xyz").as_string("0 0 0"));
  return pose;
}

/// Fixed-axis X, Y, Z. Roll first, the rest from what it leaves: exact near a pitch of 90 degrees too.
Vector3d rpy_of(const Matrix3d& rotation) {
  const double roll = std::atan2(rotation(2, 1), rotation(2, 2));
  const Matrix3d rest = rotation * AngleAxisd(-roll, Vector3d::UnitX()).toRotationMatrix();
  return {roll, std::atan2(-rest(2, 0), rest(2, 2)), std::atan2(-rest(0, 1), rest(1, 1))};
}

void set_origin(pugi::xml_node joint, const Isometry3d& pose) {
  pugi::xml_node origin = joint.child("origin");
  if (!origin) origin = joint.prepend_child("origin");
  const auto set = [&origin](const char* name, const std::string& value) {
    pugi::xml_attribute attribute = origin.attribute(name);
    if (!attribute) attribute = origin.append_attribute(name);
    attribute.set_value(value.c_str());
  };
  set("xyz", text_of(pose.translation()));
  set("rpy", text_of(rpy_of(pose.linear())));
}

bool moves(const pugi::xml_node& joint) { return std::string(joint.attribute("type").value()) != "fixed"; }

/// Joints from the root to a link.
std::vector<pugi::xml_node> way_to(const std::map<std::string, pugi::xml_node>& joint_above,
                                   const std::string& link) {
  std::vector<pugi::xml_node> way;
  for (auto above = joint_above.find(link); above != joint_above.end();
       above = joint_above.find(above->second.child("parent").attribute("link").value()))
    way.insert(way.begin(), above->second);
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
  pugi::xml_document document;
  if (!document.load_string(urdf_text.c_str(), pugi::parse_full)) throw Error(Cause::kInput, "URDF: no XML");
  pugi::xml_node robot = document.child("robot");
  std::map<std::string, pugi::xml_node> joint_above;
  for (const pugi::xml_node& joint : robot.children("joint"))
    joint_above[joint.child("child").attribute("link").value()] = joint;

  Isometry3d root_to_base = Isometry3d::Identity();
  for (const pugi::xml_node& joint : way_to(joint_above, spec.base)) {
    if (moves(joint))
      throw Error(Cause::kInput, "URDF: joint '" + std::string(joint.attribute("name").value()) +
                                     "' moves between the root and '" + spec.base +
                                     "': the robot as built cannot be written");
    root_to_base = root_to_base * origin_of(joint);
  }
  const std::vector<double> zero(static_cast<std::size_t>(built.model().joints()), 0.0);
  const ChainFrames nominal = built.model().chain().frames(zero), found = built.chain().frames(zero);

  // Every link keeps its place in the frame of its joint; a joint's origin makes up for what moved before it.
  Isometry3d was = Isometry3d::Identity(), is = Isometry3d::Identity();
  std::size_t joint_number = 0;
  const std::vector<pugi::xml_node> way = way_to(joint_above, spec.tip);
  for (const pugi::xml_node& joint : way) {
    const Isometry3d before = is;
    was = was * origin_of(joint);
    if (moves(joint)) {
      is = root_to_base * frame(found, joint_number) *
           (root_to_base * frame(nominal, joint_number)).inverse() * was;
      ++joint_number;
    } else if (&joint == &way.back()) {
      is = root_to_base * found.tip;
    } else {
      is = is * origin_of(joint);
      continue;
    }
    set_origin(joint, before.inverse() * is);
  }
  if (!way.empty() && moves(way.back()) &&
      (is.translation() - root_to_base * found.tip.translation()).norm() > 1e-9)
    throw Error(Cause::kInput,
                "URDF: tip '" + spec.tip +
                    "' turns with the last joint: a tool that is off has no place; put a fixed "
                    "joint before the tip");
  std::string comment =
      " As built, by ballbar diagnose: zero offsets, lengths, twists and tool are in the joints' origins. ";
  if (const std::string names = left_aside(built); !names.empty())
    comment += "Not in here, for a URDF holds only geometry: " + names + ". ";
  robot.prepend_child(pugi::node_comment).set_value(comment.c_str());
  std::ostringstream text;
  document.save(text, "  ");
  return text.str();
}

}  // namespace ballbar
