#pragma once
/// Inside physics/ only: a link that follows its motor with play between them.

#include <Eigen/Core>

namespace ballbar {

/// The play operator: the link stays where it is until the motor has crossed the play. Begins in the middle.
/// With s the motor's place in the play, -1 .. 1: s <- clip(s + dq / h, -1, 1), deflection = -h s. Source:
/// M. A. Krasnosel'skii, A. V. Pokrovskii, Systems with Hysteresis (1989); physics-gap.md 3, rows 2 and 4.
/// @param q     [rad] n motor angles
/// @param half  [rad] n half widths >= 0
/// @return [rad] n values, link's angle minus motor's
Eigen::VectorXd play(const Eigen::Ref<const Eigen::VectorXd>& q,
                     const Eigen::Ref<const Eigen::VectorXd>& half);

/// What a link in a gap with friction is given, one value per time.
struct GapLoad {
  Eigen::VectorXd time;          ///< [s] rising
  Eigen::VectorXd speed;         ///< [rad/s] of the motor, at the joint
  Eigen::VectorXd acceleration;  ///< [rad/s^2] of the motor, at the joint
  Eigen::VectorXd torque;        ///< [Nm] that moves the link along with the motor, without friction
  Eigen::VectorXd inertia;       ///< [kg m^2] > 0
};

/// Backlash with its dynamics. At a flank the link moves with the motor, as long as the motor has to push
/// that flank: s (torque + F sgn(speed)) >= 0, s = +1 where it pushes in + sense. Between the flanks the link
/// coasts:
///     inertia * acceleration of the link = -(torque - inertia * acceleration of the motor) - F sgn(its
///     speed),
/// it sticks where its speed is 0 and the load below F, and a flank stops it without bounce. Slowly this is
/// the play operator, pinned to one flank where |torque| > F. Steps of 1 ms, at most 100 between two samples.
/// Begins in the middle of the gap, or at the flank to which the load presses it. Source: physics-gap.md 3,
/// row 3, and 5 ("dynamic gap"), found there against a simulation with contacts.
/// @param half      [rad] half the gap
/// @param friction  [Nm] F, of the link's side
/// @return [rad] n values, link's angle minus motor's
Eigen::VectorXd gap(const GapLoad& load, double half, double friction);

}  // namespace ballbar
