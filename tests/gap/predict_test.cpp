// What the model says of a run: from its joints, and from its command.

#include "gap/predict.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <iterator>
#include <numbers>

#include "core/units.hpp"
#include "gap/add_gap.hpp"
#include "gap/commanded_path.hpp"
#include "support/planar_cell.hpp"

namespace ballbar {
namespace {

using Eigen::VectorXd;
using test::PlanarCircle;

RobotSpec with_effects(std::vector<EffectSpec> effects) {
  RobotSpec spec;
  spec.effects = std::move(effects);
  return spec;
}

AsBuilt planar(std::vector<EffectSpec> effects = {}) {
  return {RobotModel(test::kPlanarUrdf, "base", "tcp", JointConvention::kSerial),
          with_effects(std::move(effects))};
}

EffectSpec zero_offset(int joint, double deg) {
  return {"joint_zero_offset", joint, {{"offset_deg", deg}}, {}};
}

/// School geometry: both links of the planar arm, with its joints off by these angles [rad].
Eigen::Vector2d elbow_arm(double q1, double q2, double off1, double off2) {
  const double a = q1 + off1, b = a + q2 + off2;
  return {0.4 * std::cos(a) + 0.3 * std::cos(b), 0.4 * std::sin(a) + 0.3 * std::sin(b)};
}

/// Joints of the planar arm on its circle, elbow as in the recordings.
Eigen::Vector2d planar_joints(double angle) {
  const double x = 0.45 + 0.1 * std::cos(angle), y = 0.1 + 0.1 * std::sin(angle);
  const double q2 = std::acos((x * x + y * y - 0.25) / 0.24);
  return {std::atan2(y, x) - std::atan2(0.3 * std::sin(q2), 0.4 + 0.3 * std::cos(q2)), q2};
}

TEST(Predict, BetweenTheJointsSamplesItIsTheTruePath) {
  PlanarCircle circle;
  const ballbar::Run run = test::planar_run(circle);
  const VectorXd time = VectorXd::LinSpaced(1234, 0.5, 11.0);
  const double off = 0.3 * kRadPerDeg;
  const Eigen::Matrix3Xd nominal = predict_from_joints(run, planar()).points(time);
  const Eigen::Matrix3Xd as_built = predict_from_joints(run, planar({zero_offset(2, 0.3)})).points(time);
  for (Eigen::Index i = 0; i < time.size(); ++i) {
    const double angle = -60.0 * kRadPerDeg + 0.5 * (time[i] - 0.02);  // 50 mm/s, 20 ms after the mark
    const Eigen::Vector2d q = planar_joints(angle);
    ASSERT_LT((nominal.col(i).head<2>() - elbow_arm(q[0], q[1], 0.0, 0.0)).norm(), 1e-10) << time[i];
    ASSERT_LT((as_built.col(i).head<2>() - elbow_arm(q[0], q[1], 0.0, off)).norm(), 1e-8) << time[i];
  }
}

TEST(Predict, NothingIsSaidWhereNoJointSampleIsNear) {
  PlanarCircle circle;
  ballbar::Run run = test::planar_run(circle);
  const std::size_t from = 400, to = 450;  // 0.4 s
  run.joint_time.erase(run.joint_time.begin() + from, run.joint_time.begin() + to);
  run.joint_position.erase(run.joint_position.begin() + 2 * from, run.joint_position.begin() + 2 * to);
  VectorXd time(3);
  time << run.joint_time[from] - 0.2, run.joint_time[from] + 0.001, 1e6;
  const Eigen::Matrix3Xd points = predict_from_joints(run, planar()).points(time);
  EXPECT_FALSE(points.col(0).allFinite());
  EXPECT_TRUE(points.col(1).allFinite());
  EXPECT_FALSE(points.col(2).allFinite());
}

// The whole way: a robot with a wrong zero drives, a bar reads, the nominal model is asked, then the right
// one.
TEST(Gap, IsTheZeroOffsetUntilTheModelKnowsIt) {
  for (const int direction : {1, -1}) {
    SCOPED_TRACE(direction);
    PlanarCircle circle;
    circle.direction = direction;
    ballbar::Run run = test::planar_run(circle);
    const TestSpec test = test::planar_test(circle);
    const double off = 0.2 * kRadPerDeg;
    RunResult result;
    result.source = "bar";
    result.direction = direction;
    result.circle.emplace();
    result.arc_end = run.bar_time.size();
    for (std::size_t i = 0; i < run.bar_time.size(); ++i) {
      const double angle =
          (direction > 0 ? -60.0 : 420.0) * kRadPerDeg + direction * 0.5 * (run.bar_time[i] - 0.02);
      const Eigen::Vector2d q = planar_joints(angle);
      const Eigen::Vector2d ball(0.4507, 0.0996);
      run.bar_deviation[i] = (elbow_arm(q[0], q[1], 0.0, off) - ball).norm() - 0.1;
      result.angle.push_back(angle);
      if (angle < 0.0) ++result.arc_begin;
    }
    if (direction < 0) result.arc_begin = 0;

    RunResult nominal = result;
    add_gap(run, test, planar(), nominal);
    ASSERT_TRUE(nominal.circle_gap.has_value());
    EXPECT_EQ(nominal.predicted_from, "joints");
    EXPECT_GT(to_um(nominal.circle_gap->rms), 100.0);

    const AsBuilt known = planar({zero_offset(2, 0.2)});
    add_gap(run, test, known, result);
    EXPECT_LT(to_um(result.circle_gap->rms), 0.01);
    EXPECT_LT(std::abs(to_um(result.circle_gap->largest)), 0.01);
    for (std::size_t i = result.arc_begin; i < run.bar_time.size(); i += 100) {
      if (std::isfinite(result.predicted[i])) {
        EXPECT_NEAR(to_um(result.predicted[i]), to_um(run.bar_deviation[i]), 0.05) << i;
      }
    }
  }
}

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  return {std::istreambuf_iterator<char>(file), {}};
}

AsBuilt lrmate(std::vector<EffectSpec> effects) {
  return {RobotModel(text_of(BALLBAR_SOURCE_DIR "/scripts/robots/lrmate200ic.urdf"), "base", "tcp",
                     JointConvention::kFanuc),
          with_effects(std::move(effects))};
}

TestSpec lrmate_circle() {
  TestSpec test;
  test.name = "A";
  test.circle.centre = {0.38, -0.32, -0.251};
  test.circle.arc_sweep = 2.0 * std::numbers::pi;
  test.circle.overshoot = 60.0 * kRadPerDeg;
  test.tool_rpy = Vec3{std::numbers::pi, 0.0, 0.0};
  return test;
}

// Two ways to one prediction: inverse kinematics of the configured test, and joints as a controller would
// send them.
TEST(Predict, FromTheCommandAndFromJointsThatFollowItIsTheSame) {
  const AsBuilt robot = lrmate({zero_offset(3, 0.17), zero_offset(4, -0.1)});
  const TestSpec test = lrmate_circle();
  for (const int direction : {1, -1}) {
    SCOPED_TRACE(direction);
    const CommandedPath path = commanded_circle(robot.model(), test, direction, 0.055, 125.0);
    ballbar::Run run;
    run.joints = 6;
    for (Eigen::Index i = 0; i < path.motion.time.size(); ++i) {
      Eigen::VectorXd q = path.motion.q.col(i);
      robot.model().from_chain({q.data(), 6});
      run.joint_time.push_back(path.motion.time[i]);
      run.joint_position.insert(run.joint_position.end(), q.begin(), q.end());
    }
    const Eigen::Index n = path.arc_end - path.arc_begin;
    const Eigen::Matrix3Xd from_joints =
        predict_from_joints(run, robot).points(path.motion.time.segment(path.arc_begin, n));
    const VectorXd at = direction * path.angle.segment(path.arc_begin, n);
    const Eigen::Matrix3Xd from_command =
        predict_circle(test, robot, direction, 0.055, {}, Seen::kByInstrument).points(at);
    EXPECT_LT((from_joints - from_command).colwise().norm().maxCoeff(), 2e-8);
    const Eigen::Matrix3Xd motors =
        predict_circle(test, robot, direction, 0.055, {}, Seen::kByMotors).points(at);
    EXPECT_LT((motors - path.points.middleCols(path.arc_begin, n)).colwise().norm().maxCoeff(), 1e-8)
        << "the motors know nothing of wrong zeros";
  }
}

TEST(Predict, ALineStandsAtItsPoints) {
  const AsBuilt robot = lrmate({zero_offset(3, 0.17)});
  TestSpec test;
  test.name = "Y";
  test.kind = TestKind::kLine;
  test.line = {{0.38, -0.47, -0.251}, {0.38, 0.47, -0.251}, 51};
  test.tool_rpy = Vec3{std::numbers::pi, 0.0, 0.0};
  const VectorXd position = VectorXd::LinSpaced(51, 0.0, 0.94);
  const Eigen::Matrix3Xd there = predict_line(test, robot, 1, 0.055, {}, position);
  const Eigen::Matrix3Xd back = predict_line(test, robot, -1, 0.055, {}, position);
  EXPECT_LT((there - back).colwise().norm().maxCoeff(), 1e-9);
  // metrology.md 6.2: J3 = 0.172 deg alone gives straightness of 716 um along X.
  const VectorXd x = there.row(0);
  const double slope = (x[50] - x[0]) / 0.94;
  const VectorXd bow = (x - slope * position).array() - x[0];
  EXPECT_NEAR(to_um(bow.maxCoeff() - bow.minCoeff()), 716.0 * 0.17 / 0.172, 8.0);
}

TEST(Gap, OfATestThatCannotBeDrivenIsNotThere) {
  TestSpec test = lrmate_circle();
  test.circle.centre = {2.0, 0.0, 0.0};
  ballbar::Run run;
  run.feed = 0.05;
  RunResult result;
  result.direction = 1;
  result.circle.emplace();
  for (int i = 0; i < 100; ++i) {
    run.bar_time.push_back(0.1 * i);
    run.bar_deviation.push_back(0.0);
    result.angle.push_back(2.0 * std::numbers::pi * i / 100);
  }
  result.arc_end = 100;
  add_gap(run, test, lrmate({}), result);
  EXPECT_FALSE(result.circle_gap.has_value());
  EXPECT_EQ(result.predicted_from, "");
}

/// A whole turn in 11.4 s, of which a bar read nothing, and its analysis.
struct QuietTurn {
  ballbar::Run run;
  RunResult result;

  QuietTurn() {
    run.feed = 0.055;
    result.direction = 1;
    result.source = "bar";
    result.circle.emplace();
    for (int i = 0; i < 1000; ++i) {
      run.bar_time.push_back(0.0114 * i);
      run.bar_deviation.push_back(0.0);
      result.angle.push_back(2.0 * std::numbers::pi * i / 1000);
    }
    result.arc_end = 1000;
  }
};

// Feeds come from the network. 1e-12 mm/s would be years of samples, 1e300 m/s none at all.
TEST(Gap, AFeedThatTheSamplesDoNotBearOutIsNotBelieved) {
  const AsBuilt robot = lrmate({zero_offset(3, 0.17), {"servo_lag", 2, {{"lag_ms", 3.0}}, {}}});
  QuietTurn right;
  add_gap(right.run, lrmate_circle(), robot, right.result);
  ASSERT_TRUE(right.result.circle_gap.has_value());
  for (const double feed : {0.0, 5e-324, 1e-300, 1e-15, 1e-6, 1e-3, 1.0, 1e6, 1e300}) {
    SCOPED_TRACE(feed);
    QuietTurn wrong;
    wrong.run.feed = feed;
    add_gap(wrong.run, lrmate_circle(), robot, wrong.result);
    ASSERT_TRUE(wrong.result.circle_gap.has_value());
    EXPECT_NEAR(to_um(wrong.result.circle_gap->rms), to_um(right.result.circle_gap->rms), 0.2);
  }
}

TEST(Gap, OfACircleThatTakesADayIsKnownAllTheSame) {
  const AsBuilt robot = lrmate({zero_offset(3, 0.17)});
  QuietTurn usual, slow;
  for (double& time : slow.run.bar_time) time *= 8000.0;
  slow.run.feed = 0.0;
  add_gap(usual.run, lrmate_circle(), robot, usual.result);
  add_gap(slow.run, lrmate_circle(), robot, slow.result);
  ASSERT_TRUE(slow.result.circle_gap.has_value());
  EXPECT_NEAR(to_um(slow.result.circle_gap->rms), to_um(usual.result.circle_gap->rms), 0.01);
}

TEST(Gap, OfAPathThatComesBackToItsBeginWithoutAFeedIsNotThere) {
  QuietTurn there_and_back;
  there_and_back.run.feed = 0.0;
  there_and_back.result.source = "joints";
  for (std::size_t i = 0; i < 1000; ++i)
    there_and_back.result.angle[i] = 3.0 - std::abs(3.0 * (1.0 - static_cast<double>(i) / 499.5));
  ASSERT_EQ(there_and_back.result.angle.front(), there_and_back.result.angle.back());
  EXPECT_NO_THROW(add_gap(there_and_back.run, lrmate_circle(), lrmate({}), there_and_back.result));
  EXPECT_FALSE(there_and_back.result.circle_gap.has_value());
}

TEST(Gap, ALineThatNobodyCanHaveDrivenHasNone) {
  TestSpec test;
  test.name = "Y";
  test.kind = TestKind::kLine;
  test.line = {{0.38, -0.47, -0.251}, {0.38, 0.47, -0.251}, 51};
  test.tool_rpy = Vec3{std::numbers::pi, 0.0, 0.0};
  for (const double feed : {5e-324, 1e-300, 1e-9, 1e-4, 0.055, 1e300}) {
    SCOPED_TRACE(feed);
    ballbar::Run run;
    run.kind = TestKind::kLine;
    run.feed = feed;
    RunResult result;
    result.direction = 1;
    result.lines.emplace_back().axis = 'X';
    for (int k = 0; k < 51; ++k) result.lines[0].points.emplace_back().position = 0.0188 * k;
    add_gap(run, test, lrmate({}), result);
    EXPECT_EQ(result.lines[0].gap.has_value(), feed > 1e-3);
  }
}

TEST(Gap, AJumpOfTheGaugeIsCountedFromTheRunsFirstReading) {
  QuietTurn jumped;
  jumped.result.arc_begin = 250;
  for (std::size_t i = 599; i < 1000; ++i) jumped.run.bar_deviation[i] = 10e-6;
  const AsBuilt robot = lrmate({{"gauge_jump", 0, {{"jump_um", 10.0}, {"row", 600.0}}, {}}});
  add_gap(jumped.run, lrmate_circle(), robot, jumped.result);
  ASSERT_TRUE(jumped.result.circle_gap.has_value());
  EXPECT_LT(to_um(jumped.result.circle_gap->rms), 1e-3);
}

// The arm hangs still at its points: only gravity bends it, however fast it came there.
TEST(Predict, ALineIsReadAtRestNotAtTheStartOfTheNextMove) {
  const AsBuilt robot = lrmate({{"joint_compliance", 2, {{"compliance_rad_per_nm", 4e-5}}, {}}});
  TestSpec test;
  test.name = "Y";
  test.kind = TestKind::kLine;
  test.line = {{0.38, -0.47, -0.251}, {0.38, 0.47, -0.251}, 51};
  test.tool_rpy = Vec3{std::numbers::pi, 0.0, 0.0};
  const VectorXd position = VectorXd::LinSpaced(51, 0.0, 0.94);
  const Eigen::Matrix3Xd slow = predict_line(test, robot, 1, 0.01, {}, position);
  const Eigen::Matrix3Xd fast = predict_line(test, robot, 1, 0.5, {}, position);
  EXPECT_LT(to_um((slow - fast).colwise().norm().maxCoeff()), 1e-6);
}

}  // namespace
}  // namespace ballbar
