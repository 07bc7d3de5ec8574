#include "core/units.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

void joint_zero_offset_geometry(const Effect& effect, const Chain& /*nominal*/, ChainDeviation& deviation) {
  deviation.links[static_cast<std::size_t>(effect.joint - 1)].zero_offset += effect.values[0];
}

}  // namespace

/// Link's angle = motor's angle + offset, in the chain's angle. Even: the same in both directions.
/// Source: physics-gap.md 3, row 0.
EffectKind joint_zero_offset() {
  return {.name = "joint_zero_offset",
          .joint = JointUse::kOne,
          .parameters = {{.name = "offset_deg",
                          .si = kRadPerDeg,
                          .typical = 0.1,
                          .least = -360.0,
                          .most = 360.0,
                          .meaning = "joint angle minus the angle that the controller believes"}},
          .meaning = "mastering error: the joint's zero is not where the controller has it",
          .source = "doi 10.1177/1729881420905723; 1 to 5 mrad after zero-position mastering",
          .geometry = joint_zero_offset_geometry};
}

}  // namespace ballbar
