#pragma once
/// Inside physics/ only: the entries of the catalogue, each from the file of its name.

#include "physics/effect.hpp"

namespace ballbar {

EffectKind joint_zero_offset();
EffectKind link_geometry();
EffectKind tool_offset();

}  // namespace ballbar
