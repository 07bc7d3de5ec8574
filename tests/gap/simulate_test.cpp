// What the instruments publish: streams in order, noise of its own for each run, the ball where it was set.

#include "gap/simulate.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "gap/paper_robot.hpp"

namespace ballbar {
namespace {

using test::paper_circle;
using test::paper_line;
using test::paper_robot;
using test::simulated;

/// All numbers that a run publishes, to compare bit by bit.
std::vector<double> published(const SimulatedRun& run, bool with_time) {
  std::vector<double> all;
  const auto add = [&](const std::vector<double>& values) {
    all.insert(all.end(), values.begin(), values.end());
  };
  for (const Sample& sample : run.samples) {
    if (with_time) {
      std::visit([&](const auto& s) { all.push_back(static_cast<double>(s.header.time_us)); }, sample);
      std::visit([&](const auto& s) { all.push_back(static_cast<double>(s.header.seq)); }, sample);
    }
    if (const auto* bar = std::get_if<BallbarBlock>(&sample)) add(bar->deviation);
    if (const auto* joints = std::get_if<JointSample>(&sample)) add(joints->position);
    if (const auto* reading = std::get_if<InterferometerBlock>(&sample)) add(reading->deviation);
  }
  return all;
}

SimulateOptions noisy(std::uint64_t seed) {
  SimulateOptions options;
  options.noise = 0.7e-6;
  options.seed = seed;
  options.repetitions = 2;
  return options;
}

TestSpec short_line() {
  TestSpec line = paper_line();
  line.line = {{0.380, -0.100, -0.251}, {0.380, 0.000, -0.251}, 6};
  line.name = "short";
  line.tool_rpy = Vec3{std::numbers::pi, 0.35, 0.0};
  return line;
}

TEST(Simulate, ARunIsMarksJointsAndBarAtTheirRatesInTheSequenceInWhichTheyAreSent) {
  const SimulatedRun run = simulated(paper_robot({paper_circle("A")}, {}), {}).front();
  ASSERT_TRUE(std::holds_alternative<TestMark>(run.samples.front()));
  ASSERT_TRUE(std::holds_alternative<TestMark>(run.samples.back()));
  const auto& begin = std::get<TestMark>(run.samples.front());
  const auto& end = std::get<TestMark>(run.samples.back());
  EXPECT_EQ(begin.mark, Mark::kBegin);
  EXPECT_EQ(end.mark, Mark::kEnd);
  EXPECT_EQ(begin.header.time_us, SimulateOptions().start_us);
  EXPECT_EQ(begin.feed, 0.05533);
  EXPECT_NEAR(static_cast<double>(end.header.time_us - begin.header.time_us) * 1e-6,
              0.2 + 0.1 * (2 * std::numbers::pi * 4 / 3) / 0.05533 + 0.5 + 0.2, 1e-6)
      << "rest, path, ramp, rest";
  std::int64_t sent = 0;
  std::int64_t bar_samples = 0;
  std::int64_t joint_samples = 0;
  std::map<std::size_t, std::int64_t> seq;
  for (const Sample& sample : run.samples) {
    EXPECT_GE(sent_us(sample), sent);
    sent = sent_us(sample);
    std::visit([&](const auto& s) { EXPECT_EQ(s.header.seq, ++seq[sample.index()]); }, sample);
    if (const auto* bar = std::get_if<BallbarBlock>(&sample)) {
      EXPECT_NEAR(1.0 / bar->period, 246.0, 0.1);
      EXPECT_LE(bar->deviation.size(), 50u);
      bar_samples += static_cast<std::int64_t>(bar->deviation.size());
    }
    if (const auto* joints = std::get_if<JointSample>(&sample)) {
      EXPECT_EQ(joints->header.time_us, begin.header.time_us + 8000 * joint_samples++);
    }
  }
  const double duration = static_cast<double>(end.header.time_us - begin.header.time_us) * 1e-6;
  EXPECT_NEAR(static_cast<double>(bar_samples), duration * 246.0, 3.0);
  EXPECT_NEAR(static_cast<double>(joint_samples), duration * 125.0, 1.0);
}

TEST(Simulate, ANominalRobotGivesABarOfItsNominalLengthWhereverItsBallIsPlaced) {
  for (const BallPlacement ball : {BallPlacement::kSet, BallPlacement::kProgrammed, BallPlacement::kFitted}) {
    SimulateOptions options;
    options.ball = ball;
    for (const SimulatedRun& run : simulated(paper_robot({paper_circle("B")}, {}), options)) {
      EXPECT_LT((run.ball - Eigen::Vector3d(0.380, 0.320, -0.251)).norm(), 1e-9);
      EXPECT_LT(run.deviation.cwiseAbs().maxCoeff(), 1e-9);
    }
  }
}

TEST(Simulate, TheBallIsSetWhereTheTrueToolPointIs) {
  // J1 turns everything about the base's z: the set ball turns with it, and the bar sees nothing.
  SimulateOptions options;
  options.directions = {1};
  const RobotSpec robot = paper_robot({paper_circle("A")}, {test::zero_offset(1, 0.5)});
  const SimulatedRun set = simulated(robot, options).front();
  const Eigen::Vector3d turned =
      Eigen::AngleAxisd(0.5 * test::kDeg, Eigen::Vector3d::UnitZ()) * Eigen::Vector3d(0.380, -0.320, -0.251);
  EXPECT_LT((set.ball - turned).norm(), 1e-9);
  EXPECT_LT(set.deviation.cwiseAbs().maxCoeff(), 1e-9);

  // Left at the programmed place it is off by e, and the bar reads |R u(angle + turn) - e|.
  options.ball = BallPlacement::kProgrammed;
  const SimulatedRun programmed = simulated(robot, options).front();
  const Eigen::Vector3d e = turned - Eigen::Vector3d(0.380, -0.320, -0.251);
  for (Eigen::Index i = 0; i < programmed.angle.size(); i += 100) {
    const double angle = programmed.angle[i] + 0.5 * test::kDeg;
    const Eigen::Vector3d tool = 0.1 * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0) + e;
    EXPECT_NEAR(programmed.deviation[i], tool.norm() - 0.1, 1e-9);
  }
}

TEST(Simulate, TestsWithOneCentreShareOneSetUp) {
  TestSpec tilted = paper_circle("A");
  tilted.name = "tilted";
  tilted.circle.normal = {0.0, std::sin(0.3), std::cos(0.3)};
  tilted.tool_rpy = Vec3{std::numbers::pi - 0.3, 0.0, 0.0};
  const std::vector<EffectSpec> effects{test::zero_offset(5, 0.3)};
  const std::vector<SimulatedRun> both = simulated(paper_robot({paper_circle("A"), tilted}, effects), {});
  const std::vector<SimulatedRun> alone = simulated(paper_robot({tilted}, effects), {});
  ASSERT_EQ(both.size(), 4u);
  for (const SimulatedRun& run : both) EXPECT_EQ(run.ball, both.front().ball) << run.test;
  EXPECT_GT((alone.front().ball - both.front().ball).norm(), 1e-5)
      << "held otherwise it would have stood elsewhere";
}

TEST(Simulate, TheInterferometerReadsAcrossTheLineBeforeEachStopEnds) {
  // A tool point that lies 30 um further along x of the tool: with the tool straight down that is +X of the
  // world.
  TestSpec line = short_line();
  line.line = {{0.380, -0.300, -0.251}, {0.380, -0.200, -0.251}, 6};
  line.tool_rpy = Vec3{std::numbers::pi, 0.0, 0.0};
  const std::vector<EffectSpec> effects{
      {"tool_offset", 0, {{"x_mm", 0.03}, {"y_mm", 0.0}, {"z_mm", -0.02}}, {}}};
  for (const SimulatedRun& run : simulated(paper_robot({line}, effects), {})) {
    SCOPED_TRACE(run.direction);
    std::map<char, int> readings;
    for (const Sample& sample : run.samples) {
      const auto* block = std::get_if<InterferometerBlock>(&sample);
      if (!block) continue;
      const int k = readings[block->axis]++;
      EXPECT_NEAR(block->position.at(0), run.direction > 0 ? 0.02 * k : 0.1 - 0.02 * k, 1e-12);
      EXPECT_NEAR(block->deviation.at(0), block->axis == 'X' ? 30e-6 : 20e-6, 1e-10)
          << "+ = towards the axis";
      const double after = static_cast<double>(block->header.time_us -
                                               std::get<TestMark>(run.samples.front()).header.time_us) *
                           1e-6;
      EXPECT_NEAR(after, 0.2 + run.commanded->stop_end[k] - 0.04, 1e-6);
    }
    EXPECT_EQ(readings, (std::map<char, int>{{'X', 6}, {'Z', 6}}));
  }
}

TEST(Simulate, SameSeedSameBytesOtherSeedOtherNoise) {
  const RobotSpec robot = paper_robot({paper_circle("A"), short_line()}, {test::zero_offset(3, 0.1)});
  const std::vector<SimulatedRun> once = simulated(robot, noisy(7));
  const std::vector<SimulatedRun> again = simulated(robot, noisy(7));
  const std::vector<SimulatedRun> other = simulated(robot, noisy(8));
  ASSERT_EQ(once.size(), 8u);
  for (std::size_t i = 0; i < once.size(); ++i) {
    EXPECT_EQ(published(once[i], true), published(again[i], true));
    EXPECT_NE(published(once[i], true), published(other[i], true));
  }
}

TEST(Simulate, EachRunHasNoiseOfItsOwnThatOtherTestsDoNotMove) {
  const std::vector<SimulatedRun> both =
      simulated(paper_robot({paper_circle("A"), paper_circle("B")}, {}), noisy(7));
  const std::vector<SimulatedRun> first = simulated(paper_robot({paper_circle("A")}, {}), noisy(7));
  const std::vector<SimulatedRun> second = simulated(paper_robot({paper_circle("B")}, {}), noisy(7));
  ASSERT_EQ(both.size(), 8u);
  for (std::size_t i = 0; i < 4; ++i) {
    EXPECT_EQ(published(both[i], true), published(first[i], true)) << "a test was added behind";
    EXPECT_EQ(published(both[i + 4], false), published(second[i], false)) << "a test was added in front";
  }
  for (std::size_t i = 0; i < both.size(); ++i)
    for (std::size_t k = i + 1; k < both.size(); ++k) EXPECT_NE(both[i].deviation, both[k].deviation);
}

TEST(Simulate, TheNoiseIsWhiteGaussianOfTheStatedSize) {
  const SimulatedRun run = simulated(paper_robot({paper_circle("A")}, {}), noisy(7)).front();
  const double n = static_cast<double>(run.deviation.size());
  const double sd = std::sqrt(run.deviation.squaredNorm() / n);
  EXPECT_NEAR(sd * 1e6, 0.7, 5 * 0.7 / std::sqrt(2 * n));
  const double neighbours =
      run.deviation.head(run.deviation.size() - 1).dot(run.deviation.tail(run.deviation.size() - 1)) / n /
      (sd * sd);
  EXPECT_NEAR(neighbours, 0.0, 5 / std::sqrt(n));
  const double beyond_two = static_cast<double>((run.deviation.array().abs() > 2 * sd).count()) / n;
  EXPECT_NEAR(beyond_two, 0.0455, 5 * std::sqrt(0.0455 / n)) << "of a Gaussian";
}

TEST(Simulate, JointsSayWhatTheControllerBelieves) {
  // A zero offset is behind the encoder: nothing of it in JOINTS. A servo lag is in front of it: J1 comes
  // later.
  const RobotSpec plain = paper_robot({paper_circle("A")}, {});
  const std::vector<double> nominal = published(simulated(plain, {}).front(), false);
  const auto joints = [](const SimulatedRun& run) {
    std::vector<std::vector<double>> all;
    for (const Sample& sample : run.samples)
      if (const auto* s = std::get_if<JointSample>(&sample)) all.push_back(s->position);
    return all;
  };
  const auto believed = joints(simulated(plain, {}).front());
  EXPECT_EQ(joints(simulated(paper_robot({paper_circle("A")}, {test::zero_offset(2, 1.0)}), {}).front()),
            believed);
  const auto late = joints(
      simulated(paper_robot({paper_circle("A")}, {{"servo_lag", 1, {{"lag_ms", 8.0}}, {}}}), {}).front());
  ASSERT_EQ(late.size(), believed.size());
  for (std::size_t i = believed.size() / 2; i < believed.size() / 2 + 50; ++i) {
    EXPECT_NEAR(late[i][0], believed[i - 1][0], 5e-6) << "one sample of 8 ms behind, of steps of 7e-4";
    EXPECT_EQ(late[i][1], believed[i][1]);
  }
}

TEST(Simulate, WhatIsMissingIsNamed) {
  const auto error_of = [](const RobotSpec& robot, const SimulateOptions& options) -> std::string {
    try {
      simulated(robot, options);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  SimulateOptions options;
  options.tests = {"A", "Q"};
  EXPECT_EQ(error_of(paper_robot({paper_circle("A"), paper_line()}, {}), options),
            "robot 'lrmate-1' has no test 'Q'; configured are: A, Y");
  TestSpec slow = paper_circle("A");
  slow.feed = 0.0;
  EXPECT_EQ(error_of(paper_robot({slow}, {}), {}), "test 'A': give 'feed_mm_s', the speed of the tool point");
}

}  // namespace
}  // namespace ballbar
