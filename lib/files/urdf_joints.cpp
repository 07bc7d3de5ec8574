#include "files/urdf_joints.hpp"

#include <array>
#include <charconv>
#include <locale>
#include <pugixml.hpp>
#include <sstream>

#include "core/error.hpp"

namespace ballbar {
namespace {

Vec3 triple(const char* text) {
  Vec3 values{};
  std::istringstream words(text);
  words.imbue(std::locale::classic());
  for (double& value : values) words >> value;
  return values;
}

/// Digits enough to read back the same bits.
std::string text_of(const Vec3& values) {
  std::string text;
  for (const double value : values) {
    std::array<char, 32> digits{};
    const auto end = std::to_chars(digits.data(), digits.data() + digits.size(), value);
    text += (text.empty() ? "" : " ") + std::string(digits.data(), end.ptr);
  }
  return text;
}

void load(pugi::xml_document& document, const std::string& text) {
  if (!document.load_string(text.c_str(), pugi::parse_full) || !document.child("robot"))
    throw Error(Cause::kInput, "URDF: no XML with a <robot>");
}

}  // namespace

std::vector<UrdfJoint> urdf_joints(const std::string& urdf_text) {
  pugi::xml_document document;
  load(document, urdf_text);
  std::vector<UrdfJoint> joints;
  for (const pugi::xml_node& node : document.child("robot").children("joint")) {
    const pugi::xml_node origin = node.child("origin");
    joints.push_back({node.attribute("name").value(), node.child("parent").attribute("link").value(),
                      node.child("child").attribute("link").value(),
                      std::string(node.attribute("type").value()) != "fixed",
                      triple(origin.attribute("xyz").as_string("0 0 0")),
                      triple(origin.attribute("rpy").as_string("0 0 0"))});
  }
  return joints;
}

std::string with_origins(const std::string& urdf_text, const std::vector<UrdfJoint>& joints,
                         const std::string& comment) {
  pugi::xml_document document;
  load(document, urdf_text);
  pugi::xml_node robot = document.child("robot");
  for (const UrdfJoint& joint : joints) {
    pugi::xml_node node = robot.find_child_by_attribute("joint", "name", joint.name.c_str());
    pugi::xml_node origin = node.child("origin");
    if (!origin) origin = node.prepend_child("origin");
    for (const auto& [name, values] : {std::pair{"xyz", joint.xyz}, std::pair{"rpy", joint.rpy}}) {
      pugi::xml_attribute attribute = origin.attribute(name);
      if (!attribute) attribute = origin.append_attribute(name);
      attribute.set_value(text_of(values).c_str());
    }
  }
  robot.prepend_child(pugi::node_comment).set_value(comment.c_str());
  std::ostringstream text;
  document.save(text, "  ");
  return text.str();
}

}  // namespace ballbar
