#pragma once
/// Inside physics/ only: errors of a joint that are a sine of its angle.

#include <Eigen/Core>

#include "core/units.hpp"
#include "physics/drive.hpp"
#include "physics/effect.hpp"

namespace ballbar {

inline ParameterKind sine_amplitude(double typical_deg) {
  return {.name = "amplitude_deg",
          .si = kRadPerDeg,
          .typical = typical_deg,
          .least = -10.0,
          .most = 10.0,
          .meaning = "half of peak to peak"};
}

inline ParameterKind sine_phase() {
  return {.name = "phase_deg",
          .si = kRadPerDeg,
          .typical = 0.0,
          .need = Need::kOptional,
          .least = -1e5,
          .most = 1e5,
          .meaning = "of the sine, at joint angle 0"};
}

/// amplitude sin(cycles q + phase), q = the motor's angle at the effect's joint.
/// @param amplitude,phase  [rad]
/// @return [rad] one value per time
inline Eigen::VectorXd sine_of_joint(const Effect& effect, Drive& drive, double cycles, double amplitude,
                                     double phase) {
  return amplitude *
         (cycles * drive.motor().q.row(effect.joint - 1).transpose().array() + phase).sin().matrix();
}

}  // namespace ballbar
