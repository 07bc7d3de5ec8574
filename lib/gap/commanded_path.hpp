#pragma once
/// The motion that a configured test asks of the robot, through nominal inverse kinematics.

#include <Eigen/Core>

#include "core/spec.hpp"
#include "kinematics/robot_model.hpp"
#include "physics/motion.hpp"

namespace ballbar {

struct CommandedPath {
  Motion motion;             ///< time 0 = the robot begins to move; chain angles
  Eigen::Matrix3Xd points;   ///< [m] programmed tool points in the base frame
  Eigen::VectorXd angle;     ///< circles: [rad] commanded angle, unwrapped, one per time; lines: empty
  Eigen::VectorXd position;  ///< lines: [m] from the start, one per time; circles: empty
};

/// A circle with its overshoots at constant feed; within the overshoots the feed rises from rest and falls
/// back to it without a step.
/// @param direction  +1 or -1: clockwise runs go from start + sweep back to start
/// @param feed       [m/s] > 0
/// @param rate       [1/s] samples of the path
/// @throws Error(kInput) naming test, angle and joint, where the robot cannot reach the circle, meets a limit
/// or
///         a singularity
CommandedPath commanded_circle(const RobotModel& model, const TestSpec& test, int direction, double feed,
                               double rate);

/// A line with a stop of `dwell` [s] at each of its points.
/// @throws Error(kInput) naming test, place and joint
CommandedPath commanded_line(const RobotModel& model, const TestSpec& test, int direction, double feed,
                             double dwell, double rate);

}  // namespace ballbar
