#pragma once
/// Inside physics/ only: effects whose first three parameters are a displacement along x, y and z.

#include <Eigen/Core>

#include "core/units.hpp"
#include "physics/effect.hpp"

namespace ballbar {

/// @param si  from the parameter's unit: micrometres, or micrometres per time
inline ParameterKind displacement_along(std::string_view name, std::string_view meaning,
                                        double si = kMetresPerUm) {
  return {.name = name,
          .si = si,
          .typical = 10.0,
          .need = Need::kSomeOf,
          .least = -1e6,
          .most = 1e6,
          .meaning = meaning};
}

inline Eigen::Vector3d displacement(const Effect& effect) {
  return {effect.values[0], effect.values[1], effect.values[2]};
}

}  // namespace ballbar
