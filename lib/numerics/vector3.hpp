#pragma once
/// Points and directions of specifications as Eigen vectors.

#include <Eigen/Core>

#include "core/spec.hpp"

namespace ballbar {

inline Eigen::Vector3d vector_of(const Vec3& v) { return {v[0], v[1], v[2]}; }

}  // namespace ballbar
