#pragma once
/// What is driven: circles, their order and time, and the configuration that says so.

#include <string>
#include <vector>

#include "arm.hpp"

namespace blind {

struct Test {
  std::string name;
  Vector3d centre_mm, normal, first_axis;
  double start_deg = 0.0, sweep_deg = 360.0;
  double radius_mm = 100.0, feed_mm_s = 55.33;
  Vector3d tool_rpy_deg;
  double payload_kg = 0.438;
};

constexpr double kOvershootDeg = 60.0;

/// One recorded circle. Two repetitions, one right after the other, share the way and the shift of the bar's
/// clock.
struct Recording {
  int test = 0;
  int direction = 1;
  int repetition = 1;
  double minute = 0.0;  ///< of the first sample, since the series began
  bool held_out = false;
  double clock_s = 0.0;  ///< the bar's sample was taken this much after its stamp
};

struct Plan {
  std::string name;
  std::vector<Test> tests;
  std::vector<Recording> recordings;
};

/// `name`: PM (8 pairs), P0 (the paper's two circles), P3 (17 pairs). The circles of set-up H follow each of
/// them. Throws std::invalid_argument for another one.
Plan plan(const std::string& name);

/// How a test is sampled: bar samples are a quarter of the joints' period apart, and a full turn has a
/// multiple of 400 of them.
struct Sampling {
  int joints_per_turn = 0, before = 0, arc = 0;  ///< bar samples of an overshoot and of the measured arc
  double bar_period = 0.0;                       ///< [s]
  int bar_count() const { return 2 * before + arc + 1; }
};
Sampling sampling(const Test& test);

/// Commanded joints at times [s] since the first bar sample, on and beyond the recorded way.
std::vector<Joints> command(const Test& test, int direction, double first_time, double step,
                            std::size_t count);

/// Joints at the programmed centre, where the ball is set with this test's tool.
Joints at_centre(const Test& test);

/// The configuration file. `joints`: "commanded" or "motor feedback"; said in a comment.
std::string configuration(const Plan& plan, bool fanuc, const std::string& joints);

}  // namespace blind
