#pragma once
/// The virtual ballbar: what a bar would have read, had the tool point been where the joints say.

#include "core/run.hpp"
#include "kinematics/robot_model.hpp"

namespace ballbar {

/// Gives a circle without BALLBAR samples one reading per joint sample: |p(q) - c| - radius, p the nominal
/// forward kinematics, c as test.virtual_centre says; process() then makes of it what it makes of a bar's.
/// Angles stay those about the configured centre, also where c is fitted.
///
/// Leaves a run as it is that has bar samples, is discarded, or whose JOINTS do not fit the chain. So a bar
/// that was not heard at all gives a virtual run, too: process() says where the circle before had one.
///
/// @throws std::invalid_argument where a joint angle is not finite
void add_virtual_bar(Run& run, const TestSpec& test, const RobotModel& model);

}  // namespace ballbar
