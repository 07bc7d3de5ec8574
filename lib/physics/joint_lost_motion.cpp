#include <cmath>
#include <limits>

#include "core/units.hpp"
#include "physics/drive.hpp"
#include "physics/effects.hpp"
#include "physics/play.hpp"

namespace ballbar {
namespace {

constexpr double kUnlimited = std::numeric_limits<double>::infinity();
constexpr double kLeastInertia = 1e-5;  // [kg m^2] of a bare flange, where the URDF gives a link no mass
constexpr int kBacklash = 0, kLoadFriction = 2;  // of the words below

Eigen::VectorXd joint_lost_motion_deflection(const Effect& effect, Drive& drive) {
  const Eigen::VectorXd q = drive.motor().q.row(effect.joint - 1);
  const double half = effect.values[0] / 2.0;
  const double friction = effect.values[1];
  if (half == 0.0) return Eigen::VectorXd::Zero(q.size());
  if (effect.word == kLoadFriction) {
    const double at = std::isfinite(friction) ? friction : 1.0;
    return play(q, half / at * drive.torque().row(effect.joint - 1).transpose().cwiseAbs());
  }
  if (effect.word != kBacklash || !std::isfinite(friction))
    return play(q, Eigen::VectorXd::Constant(q.size(), half));
  return gap(
      {drive.motor().time, drive.speed().row(effect.joint - 1), drive.acceleration().row(effect.joint - 1),
       drive.torque().row(effect.joint - 1), drive.inertia(effect.joint).cwiseMax(kLeastInertia)},
      half, friction);
}

}  // namespace

/// The link lags by half the width, to the side that it came from. Odd: a step at each reversal of the joint.
/// By kind, with h = width / 2 and F = friction (play.hpp has the formulas):
/// - friction_windup, unresolved: the play operator with h. Constant in speed and payload. F has no part in
/// it.
/// - load_friction: the play operator with h |tau| / F; without F per 1 Nm. Grows with payload.
/// - backlash: a gap with friction F on the link's side; pinned to one flank while |tau| > F, crossed with
/// the
///   link's own dynamics when fast. Without F the load never moves the link: the play operator.
/// State at the begin of a motion: the middle of the play, or the flank to which the load presses. A joint
/// that turns by more than the width since knows nothing of it any more; the overshoots of a test see to
/// that. Simplified: no stiffness within the play, no bounce.
/// Source: physics-gap.md 3, rows 2 to 4, and 5.
EffectKind joint_lost_motion() {
  return {
      .name = "joint_lost_motion",
      .joint = JointUse::kOne,
      .parameters = {{.name = "width_deg",
                      .si = kRadPerDeg,
                      .typical = 0.007,
                      .least = 0.0,
                      .most = 10.0,
                      .meaning = "full play, flank to flank"},
                     {.name = "friction_nm",
                      .typical = 1.0,
                      .need = Need::kOptional,
                      .least = 1e-6,
                      .most = 1e6,
                      .absent = kUnlimited,
                      .meaning = "backlash: load that still does not move the link; load_friction: load at "
                                 "which the play is width_deg (1 unless given)"}},
      .word = {"kind", {"backlash", "friction_windup", "load_friction", "unresolved"}, true},
      .meaning = "motion lost behind the encoder when the joint reverses",
      .source =
          "Krasnosel'skii, Pokrovskii, Systems with Hysteresis (1989); Ruderman, Hoffmann, Bertram, "
          "IEEE Trans. Ind. Electron. 56 (2009)",
      .loaded = true,
      .deflection = joint_lost_motion_deflection};
}

}  // namespace ballbar
