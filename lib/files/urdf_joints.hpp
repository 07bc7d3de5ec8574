#pragma once
/// The joints of a URDF as they stand in the file, and the file with other origins: nothing else is touched.

#include <string>
#include <vector>

#include "core/spec.hpp"

namespace ballbar {

struct UrdfJoint {
  std::string name, parent, child;
  bool moves = false;  ///< not fixed
  Vec3 xyz{};          ///< [m]
  Vec3 rpy{};          ///< [rad] fixed-axis X, Y, Z
};

/// In the file's sequence. @throws Error(kInput) where the text is no XML
std::vector<UrdfJoint> urdf_joints(const std::string& urdf_text);

/// @param joints   whose origins are written; others stay
/// @param comment  stands at the top of <robot>
/// @throws Error(kInput) likewise
std::string with_origins(const std::string& urdf_text, const std::vector<UrdfJoint>& joints,
                         const std::string& comment);

}  // namespace ballbar
