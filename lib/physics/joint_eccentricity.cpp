#include <cmath>

#include "core/units.hpp"
#include "physics/drive.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

Eigen::VectorXd deflection(const Effect& effect, Drive& drive) {
  return effect.values[0] *
         (drive.motor().q.row(effect.joint - 1).transpose().array() + effect.values[1]).sin().matrix();
}

}  // namespace

/// Link's angle - motor's angle = A sin(q + phase): the output wheel runs out of centre. Even. Nearly the
/// same as zero offset and lengths unless the joint turns far.
/// Source: physics-gap.md 3, row 10.
EffectKind joint_eccentricity() {
  return {.name = "joint_eccentricity",
          .joint = JointUse::kOne,
          .parameters = {{.name = "amplitude_deg",
                          .si = kRadPerDeg,
                          .typical = 0.02,
                          .least = -10.0,
                          .most = 10.0,
                          .meaning = "half of peak to peak"},
                         {.name = "phase_deg",
                          .si = kRadPerDeg,
                          .typical = 0.0,
                          .need = Need::kOptional,
                          .least = -1e5,
                          .most = 1e5,
                          .meaning = "of the sine, at joint angle 0"}},
          .meaning = "an error once per turn of the joint: its output wheel or encoder is off centre",
          .source = "Whitney, Lozinski, Rourke 1986",
          .deflection = deflection};
}

}  // namespace ballbar
