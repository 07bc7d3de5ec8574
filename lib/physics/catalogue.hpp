#pragma once
/// Every effect that this project can name, once: `[[robot.effect]]`, the diagnosis and docs/effects.md take
/// names, parameters and units from here.

#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "core/spec.hpp"
#include "physics/effect.hpp"

namespace ballbar {

/// In the order in which effects act and are shown. Source: physics-gap.md, section "Names", and the source
/// that each entry names.
const std::vector<EffectKind>& effect_catalogue();

/// @return null where there is none of that name
const EffectKind* find_effect_kind(std::string_view name);

/// Why an effect is refused.
struct EffectFault {
  std::string key;   ///< what it is about: "effect", "joint", or a parameter or word; "" = one is missing
  std::string what;  ///< what is wrong and what to do
};

/// @param joints  of the robot
std::optional<EffectFault> effect_fault(const EffectSpec& spec, int joints = kMaxChainJoints);

/// @throws Error(kInput) with what effect_fault() says, naming the effect
Effect make_effect(const EffectSpec& spec, int joints = kMaxChainJoints);

}  // namespace ballbar
