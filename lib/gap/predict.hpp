#pragma once
/// Where the robot as built takes its tool point, in a run that was recorded or in one that was commanded.

#include <Eigen/Core>

#include "core/run.hpp"
#include "core/spec.hpp"
#include "physics/as_built.hpp"

namespace ballbar {

/// When the series began is not known of a single run: what grows with time is as at its begin, and what
/// oscillates is left out.
Conditions conditions_of(const Run& run);

/// What JOINTS say, as angles of the chain. @param run  its joints must be those of the model
Motion motion_of(const Run& run, const RobotModel& model);

/// A predicted path between its samples: nominal kinematics is cubic; what differs from it is joined by
/// straight lines, for it may step.
struct PredictedPath {
  Eigen::VectorXd
      along;  ///< n abscissae, rising: of a run [s] since its begin, of a command direction x angle [rad]
  Eigen::Matrix3Xd nominal;   ///< [m] 3 x n in the base frame
  Eigen::Matrix3Xd as_built;  ///< [m] 3 x n
  double widest = 0.0;        ///< samples further apart than this are not joined

  /// @return 3 x k [m]; NaN outside the path and in its holes
  Eigen::Matrix3Xd points(const Eigen::VectorXd& at) const;
};

/// From JOINTS: the motors' angles at each of their samples (where JOINTS are commanded angles, those of the
/// motors that follow them), then everything behind the motors.
/// @param run  its joints must be those of the model
/// @return along time
PredictedPath predict_from_joints(const Run& run, const AsBuilt& robot);

enum class Seen {
  kByInstrument,  ///< the tool point itself
  kByMotors,      ///< nominal kinematics of what the motors' encoders read
};

/// A circle from its command: inverse kinematics of the nominal robot, the motors that follow, the robot as
/// built.
/// @param direction  +1 or -1
/// @param feed       [m/s] > 0
/// @return along direction x commanded angle
/// @throws Error(kInput) where the robot cannot drive the circle, or would take longer than anyone waits
PredictedPath predict_circle(const TestSpec& test, const AsBuilt& robot, int direction, double feed,
                             const Conditions& conditions, Seen seen);

/// A line from its command, at rest in its points.
/// @param position  k places [m] from the start
/// @return 3 x k [m] in the base frame; NaN beyond the ends
/// @throws Error(kInput) where the robot cannot drive the line, or would take longer than half an hour
Eigen::Matrix3Xd predict_line(const TestSpec& test, const AsBuilt& robot, int direction, double feed,
                              const Conditions& conditions, const Eigen::VectorXd& position);

}  // namespace ballbar
