#pragma once
/// The URDF of a robot as built: the origins of its joints moved to where they were found.

#include <string>

#include "physics/as_built.hpp"

namespace ballbar {

/// Zero offsets, lengths, twists and the tool's place, as far as `built` knows them; masses, meshes and
/// limits move along with their links. What a URDF cannot hold (everything that is no geometry) is named in a
/// comment. Read back, its tool point is that of built.chain() to 1e-9 m.
/// @param urdf_text  of which `built` was made
/// @throws Error(kInput) where the tool is off and the tip has no fixed joint of its own, or moving joints
/// lie
///         between the base and the root
std::string as_built_urdf(const std::string& urdf_text, const RobotSpec& spec, const AsBuilt& built);

}  // namespace ballbar
