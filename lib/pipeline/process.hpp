#pragma once
/// The pure heart: a Run in, a RunResult out. No clock, disk, log or thread.

#include <optional>
#include <vector>

#include "core/result.hpp"
#include "metrology/circle_iso.hpp"
#include "physics/as_built.hpp"

namespace ballbar {

/// Points of the latest run the other way (same robot, test, series, axis), for the reversal values of a
/// line.
struct LinePartner {
  char axis = 'X';
  std::vector<LinePoint> points;
};

/// What the runs before give to this one.
struct Partners {
  std::vector<LinePartner> lines;
  std::optional<CircleTrace> circle;  ///< measured arc of the same robot, test, series and repetition
  bool bar = false;                   ///< the circle before this one in its series had a bar
};

/// Analyses one run. Never throws for what the recording holds: `status` and `message` say what is wrong.
///
/// @param run     as assembled
/// @param test    the configured test that the run belongs to
/// @param robot   its nominal kinematics and what is known beyond them; null where there is no model
/// @param partners  what the runs before give to it
/// @throws std::invalid_argument where run.kind is not the test's, or a sample is not finite
RunResult process(const Run& run, const TestSpec& test, const AsBuilt* robot, const Partners& partners = {});

/// All of process() but the comparison of measured with predicted, which takes most of the time.
/// @param model  null where there is none
RunResult process_measured(const Run& run, const TestSpec& test, const RobotModel* model,
                           const Partners& partners = {});

/// The first part of process() for a circle: status, direction, angles and measured arc, no figure.
/// @throws std::invalid_argument where the run or the test is no circle, or a sample is not finite
RunResult locate(const Run& run, const TestSpec& test, const RobotModel& robot);

}  // namespace ballbar
