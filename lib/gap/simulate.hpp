#pragma once
/// What the instruments would publish of a robot as built that drives its configured tests.

#include <Eigen/Core>
#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/samples.hpp"
#include "core/spec.hpp"
#include "gap/commanded_path.hpp"
#include "numerics/harmonics.hpp"
#include "physics/as_built.hpp"

namespace ballbar {

/// Where the ball of the bar stands. Tests with the same centre share one set-up, that of the first of them.
enum class BallPlacement {
  kSet,  ///< where the true tool point is with the robot at the programmed centre: as a person sets it up
  kProgrammed,  ///< at the programmed centre
  kFitted,  ///< at the true points' mean height above the plane, where the bar's deviations on the measured
            ///< arc have the least sum of squares about their mean
};

struct SimulateOptions {
  std::vector<std::string> tests;  ///< names, driven in this sequence; empty: all, as configured
  std::vector<int> directions{1, -1};
  int repetitions = 1;
  BallPlacement ball = BallPlacement::kSet;
  double noise = 0.0;  ///< [m] standard deviation of each reading of the bar and of the interferometer; white
  std::uint64_t seed = 1;
  std::string series = "simulated";
  std::int64_t start_us = 1'767'225'600'000'000;  ///< producer's clock at the first mark: 2026-01-01 UTC
};

struct SimulatedRun {
  std::string test;
  TestKind kind = TestKind::kCircle;
  int direction = 0;
  int repetition = 0;
  std::vector<Sample> samples;                     ///< in the sequence in which they are sent: sent_us()
  std::shared_ptr<const CommandedPath> commanded;  ///< what was programmed
  Eigen::Vector3d ball = Eigen::Vector3d::Zero();  ///< circles: [m] in the base frame
  Eigen::VectorXd angle;      ///< circles: [rad] commanded angle of each bar sample on the measured arc
  Eigen::VectorXd deviation;  ///< circles: [m] what the bar publishes there, bar length - radius
};

/// Harmonics of a circle's deviation over the commanded angle, orders 0..10: on a full turn plain Fourier
/// coefficients.
HarmonicFit bar_harmonics(const SimulatedRun& circle);

/// When a message leaves its sender: at its last sample.
std::int64_t sent_us(const Sample& sample);

/// Drives tests, one run after another, each test's directions in turn and then its next repetition.
///
/// BALLBAR at about 246 Hz (whole samples a turn, one on the start of the arc) in blocks of 50, JOINTS at 125
/// Hz on circles and 50 Hz on lines: what the controller believes, motor side, in the robot's joint
/// convention. INTERFEROMETER 40 ms before each stop ends, one reading a message, for both world axes that
/// are not the line's main one: deviation = (true - programmed tool point) along that axis made orthogonal to
/// the line, + = towards the axis; zero is the programmed line. The robot rests for 0.2 s behind the begin
/// mark and before the end mark.
///
/// The noise of a run depends on seed, robot, test, direction and repetition only: tests that are added
/// behind others leave every byte of those as it is.
/// @param robot  of which `as_built` was made
/// @param take   called once per run
/// @throws Error(kInput) naming the test: unknown, without feed, or as commanded_circle(), commanded_line()
void simulate(const AsBuilt& as_built, const RobotSpec& robot, const SimulateOptions& options,
              const std::function<void(SimulatedRun)>& take);

}  // namespace ballbar
