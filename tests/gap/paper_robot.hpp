#pragma once
/// The paper's robot and its tests, and plain Fourier sums over an even grid: shares no code with
/// lib/numerics.

#include <Eigen/Core>
#include <cmath>
#include <complex>
#include <fstream>
#include <numbers>
#include <optional>
#include <sstream>
#include <string>
#include <vector>

#include "gap/simulate.hpp"

namespace ballbar::test {

inline constexpr double kDeg = std::numbers::pi / 180.0;
inline constexpr double kArcmin = kDeg / 60.0;

inline std::string lrmate_urdf() {
  std::ifstream file(BALLBAR_SOURCE_DIR "/scripts/robots/lrmate200ic.urdf");
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

inline RobotModel lrmate() { return {lrmate_urdf(), "base", "tcp", JointConvention::kFanuc}; }

/// Circle A (right of the robot) or B (left), tool straight down.
inline TestSpec paper_circle(const std::string& name) {
  TestSpec test;
  test.name = name;
  test.circle.centre = {0.380, name == "B" ? 0.320 : -0.320, -0.251};
  test.circle.radius = 0.1;
  test.circle.arc_sweep = 2.0 * std::numbers::pi;
  test.circle.overshoot = std::numbers::pi / 3.0;
  test.feed = 0.05533;
  test.tool_rpy = Vec3{std::numbers::pi, 0.0, 0.0};
  return test;
}

inline TestSpec paper_line() {
  TestSpec test;
  test.name = "Y";
  test.kind = TestKind::kLine;
  test.line = {{0.380, -0.470, -0.251}, {0.380, 0.470, -0.251}, 51};
  test.feed = 0.05533;
  test.tool_rpy = Vec3{std::numbers::pi, 0.0, 0.0};
  return test;
}

inline EffectSpec zero_offset(int joint, double offset_deg) {
  return {"joint_zero_offset", joint, {{"offset_deg", offset_deg}}, {}};
}

inline EffectSpec geometry(int joint, const std::string& parameter, double value) {
  return {"link_geometry", joint, {{parameter, value}}, {}};
}

inline RobotSpec paper_robot(std::vector<TestSpec> tests, std::vector<EffectSpec> effects) {
  RobotSpec robot;
  robot.name = "lrmate-1";
  robot.joint_convention = JointConvention::kFanuc;
  robot.tests = std::move(tests);
  robot.effects = std::move(effects);
  return robot;
}

inline std::vector<SimulatedRun> simulated(const RobotSpec& robot, const SimulateOptions& options) {
  std::vector<SimulatedRun> runs;
  simulate(AsBuilt(lrmate(), robot), robot, options,
           [&](SimulatedRun run) { runs.push_back(std::move(run)); });
  return runs;
}

/// One counter-clockwise run about the fitted centre.
inline SimulatedRun fitted_circle(const TestSpec& test, std::vector<EffectSpec> effects) {
  SimulateOptions options;
  options.directions = {1};
  options.ball = BallPlacement::kFitted;
  return simulated(paper_robot({test}, std::move(effects)), options).front();
}

/// a_k - i b_k would be the textbook's; here a_k + i b_k of sum a_k cos + b_k sin [m]. Order 0: the mean.
inline std::complex<double> harmonic(const SimulatedRun& run, int order) {
  std::complex<double> sum = 0.0;
  for (Eigen::Index i = 0; i < run.angle.size(); ++i)
    sum += run.deviation[i] * std::polar(1.0, order * run.angle[i]);
  return sum * (order == 0 ? 1.0 : 2.0) / static_cast<double>(run.angle.size());
}

}  // namespace ballbar::test
