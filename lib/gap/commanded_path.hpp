#pragma once
/// The motion that a configured test asks of the robot, through nominal inverse kinematics.

#include <Eigen/Core>
#include <Eigen/Geometry>

#include "core/spec.hpp"
#include "kinematics/robot_model.hpp"
#include "physics/motion.hpp"

namespace ballbar {

struct CommandedPath {
  Motion motion;                  ///< time 0 = the robot begins to move; chain angles
  Eigen::Matrix3Xd points;        ///< [m] programmed tool points in the base frame
  Eigen::VectorXd angle;          ///< circles: [rad] commanded angle, unwrapped, one per time; lines: empty
  Eigen::VectorXd position;       ///< lines: [m] from the start, one per time; circles: empty
  double duration = 0.0;          ///< [s] from time 0 until the robot stands at its end
  Eigen::Index arc_begin = 0;     ///< circles: samples [arc_begin, arc_end) lie on the measured arc, a full
  Eigen::Index arc_end = 0;       ///< turn's last angle not twice; lines: 0
  Eigen::VectorXd stop_end;       ///< lines: [s] when the robot leaves each of its points; circles: empty
  Eigen::VectorXd stop_position;  ///< lines: [m] where each of them lies, from the line's start
};

/// A circle with its overshoots at constant feed; within the overshoots the feed rises from rest and falls
/// back to it without a step. Where the overshoot is 0 the feed is constant from end to end.
///
/// One sample falls on the moment where the measured arc is entered, the others lie whole periods away from
/// it; so a rate of whole samples a turn gives an even grid of the arc with its start on it.
/// @param direction  +1 or -1: clockwise runs go from start + sweep back to start
/// @param feed       [m/s] > 0
/// @param rate       [1/s] samples of the path
/// @throws Error(kInput) naming test, angle and joint, where the robot cannot reach the circle, meets a limit
/// or a singularity, or where the test leaves open how the tool is held
/// @throws std::invalid_argument for another direction, feed, rate or kind of test
CommandedPath commanded_circle(const RobotModel& model, const TestSpec& test, int direction, double feed,
                               double rate);

/// A line with a stop of `dwell` [s] at each of its points, the first and the last among them.
/// @param direction  +1 or -1: backward runs go from the end to the start; positions count from the start
/// @throws Error(kInput) naming test, place and joint; or where the line's number of points is not configured
/// @throws std::invalid_argument as above
CommandedPath commanded_line(const RobotModel& model, const TestSpec& test, int direction, double feed,
                             double dwell, double rate);

/// The orientation in which a test holds its tool: tool_rpy, or else that of its posture.
/// @throws Error(kInput) naming the test where both are missing, or the posture is not one angle per joint
Eigen::Matrix3d tool_orientation(const RobotModel& model, const TestSpec& test);

/// Chain angles with the tool point at one place, in the configuration nearest to the test's posture. Where
/// the robot only stands it may stand in a singularity.
/// @param place  [m] in the base frame
/// @param what   how an error names the place, e.g. "at the centre of the circle"
/// @throws Error(kInput) naming test, place and joint
Eigen::VectorXd commanded_posture(const RobotModel& model, const TestSpec& test, const Eigen::Vector3d& place,
                                  const std::string& what);

}  // namespace ballbar
