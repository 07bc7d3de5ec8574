#include "physics/drive.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

Eigen::VectorXd joint_compliance_deflection(const Effect& effect, Drive& drive) {
  return -effect.values[0] * drive.torque().row(effect.joint - 1).transpose();
}

}  // namespace

/// Link's angle - motor's angle = -C tau(q, q', q''; payload), tau = what the drive must give (dynamics.hpp):
/// an arm that is held up hangs lower. Gravity, payload and inertia are all in tau. Even; grows with payload,
/// its inertial part with speed squared. Simplified: a linear spring about the joint's axis, and tau of the
/// unbent arm (of C tau some 0.1 %).
/// Source: physics-gap.md 3, rows 1 and 13.
EffectKind joint_compliance() {
  return {.name = "joint_compliance",
          .joint = JointUse::kOne,
          .parameters = {{.name = "compliance_rad_per_nm",
                          .typical = 4e-5,
                          .least = 0.0,
                          .most = 1.0,
                          .meaning = "angle by which gear and link give way per torque"}},
          .meaning = "gear and link bend about the joint under gravity, payload and inertia",
          .source = "Whitney, Lozinski, Rourke 1986; Judd, Knasinski 1990",
          .loaded = true,
          .deflection = joint_compliance_deflection};
}

}  // namespace ballbar
