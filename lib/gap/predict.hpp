#pragma once
/// Where the robot as built takes its tool point, in a run that was recorded or in one that was commanded.

#include <Eigen/Core>

#include "core/run.hpp"
#include "core/spec.hpp"
#include "physics/as_built.hpp"

namespace ballbar {

/// When the series began is not known of a single run: what grows with time is as at its begin.
Conditions conditions_of(const Run& run);

/// From JOINTS: the motors' angles at each of their samples, then everything behind the motors. Between the
/// samples nominal kinematics is cubic; what differs from it is joined by straight lines, for it may step.
/// @param run   its joints must be those of the model
/// @param time  k times [s] since the begin of the run
/// @return 3 x k [m] in the base frame; NaN where no joint sample is near
Eigen::Matrix3Xd predict_from_joints(const Run& run, const AsBuilt& robot, const Eigen::VectorXd& time);

enum class Seen {
  kByInstrument,  ///< the tool point itself
  kByMotors,      ///< nominal kinematics of what the motors' encoders read
};

/// A circle from its command: inverse kinematics of the nominal robot, the motors that follow, the robot as
/// built.
/// @param direction  +1 or -1
/// @param feed       [m/s] > 0
/// @param angle      k commanded angles [rad]
/// @return 3 x k [m] in the base frame; NaN outside what the test drives
/// @throws Error(kInput) where the robot cannot drive the circle, or would take longer than anyone waits
Eigen::Matrix3Xd predict_circle(const TestSpec& test, const AsBuilt& robot, int direction, double feed,
                                const Conditions& conditions, const Eigen::VectorXd& angle, Seen seen);

/// A line from its command, at rest in its points.
/// @param position  k places [m] from the start
/// @return 3 x k [m] in the base frame; NaN beyond the ends
/// @throws Error(kInput) where the robot cannot drive the line, or would take longer than half an hour
Eigen::Matrix3Xd predict_line(const TestSpec& test, const AsBuilt& robot, int direction, double feed,
                              const Conditions& conditions, const Eigen::VectorXd& position);

}  // namespace ballbar
