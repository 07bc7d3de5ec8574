#include "physics/effects.hpp"

namespace ballbar {

/// What a diagnosis says where structure is left that nothing here explains; the curve that it found stands
/// with it. There is nothing to predict from: a curve holds where it was measured only.
/// Source: physics-gap.md 5, step 8.
EffectKind not_in_catalogue() {
  return {.name = "not_in_catalogue",
          .joint = JointUse::kOneOrAll,
          .word = {"driver", {"angle", "velocity", "direction", "torque", "time"}},
          .meaning = "structure is left that no effect here explains; a finding, not to be configured",
          .source = "diagnosis",
          .forward = false};
}

}  // namespace ballbar
