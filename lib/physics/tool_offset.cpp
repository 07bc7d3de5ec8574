#include "core/units.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

void tool_offset_geometry(const Effect& effect, const Chain& /*nominal*/, ChainDeviation& deviation) {
  deviation.tool += Eigen::Vector3d(effect.values[0], effect.values[1], effect.values[2]);
}

ParameterKind along(std::string_view name, std::string_view meaning) {
  return {.name = name,
          .si = kMetresPerMm,
          .typical = 0.1,
          .need = Need::kSomeOf,
          .least = -1000.0,
          .most = 1000.0,
          .meaning = meaning};
}

}  // namespace

/// The tool point lies elsewhere in the tip frame. Even: the same in both directions.
/// Source: physics-gap.md 3, row 11.
EffectKind tool_offset() {
  return {.name = "tool_offset",
          .parameters = {along("x_mm", "along x of the tip frame"), along("y_mm", "along y of the tip frame"),
                         along("z_mm", "along z of the tip frame")},
          .meaning = "the tool point is not where it is configured",
          .source = "geometry of the tip frame",
          .geometry = tool_offset_geometry};
}

}  // namespace ballbar
