#pragma once
/// Joints in, circles out: forward kinematics in front of metrology/recogniser.

#include <memory>

#include "core/recognition.hpp"
#include "kinematics/robot_model.hpp"

namespace ballbar {

/// Recognises the circles among the robot's tests, by the nominal kinematics. JOINTS of another count than
/// the chain's, or that are not finite, end a path.
/// @return null where the robot has no circles
std::unique_ptr<Recogniser> make_recogniser(const RobotSpec& robot, const RobotModel& model);

}  // namespace ballbar
