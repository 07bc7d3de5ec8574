// The motion that a test asks for: where the robot is when, how it starts and stops, and what stands in its
// way.

#include "gap/commanded_path.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"
#include "gap/paper_robot.hpp"

namespace ballbar {
namespace {

using std::numbers::pi;
using test::kDeg;

constexpr double kFeed = 0.05533;

std::string error_of(const TestSpec& test) {
  try {
    if (test.kind == TestKind::kCircle)
      commanded_circle(test::lrmate(), test, 1, kFeed, 50.0);
    else
      commanded_line(test::lrmate(), test, 1, kFeed, 0.1, 50.0);
  } catch (const Error& error) {
    EXPECT_EQ(error.cause(), Cause::kInput);
    return error.what();
  }
  return "";
}

TEST(CommandedCircle, NominalKinematicsOfTheJointsLieOnTheProgrammedPath) {
  const RobotModel model = test::lrmate();
  TestSpec test = test::paper_circle("A");
  test.circle.normal = {0.0, std::sin(20 * kDeg), std::cos(20 * kDeg)};  // a tilted plane
  const CommandedPath path = commanded_circle(model, test, 1, kFeed, 20.0);
  const Eigen::Vector3d centre(0.380, -0.320, -0.251);
  for (Eigen::Index i = 0; i < path.motion.time.size(); ++i) {
    const Eigen::VectorXd q = path.motion.q.col(i);
    const Eigen::Isometry3d tip = model.chain().forward({q.data(), 6});
    const Eigen::Vector3d along =
        std::cos(path.angle[i]) * Eigen::Vector3d::UnitX() +
        std::sin(path.angle[i]) * Eigen::Vector3d(0, std::cos(20 * kDeg), -std::sin(20 * kDeg));
    ASSERT_LT((tip.translation() - centre - 0.1 * along).norm(), 1e-9) << "sample " << i;
    ASSERT_LT((tip.linear() * Eigen::Vector3d::UnitZ() + Eigen::Vector3d::UnitZ()).norm(), 1e-9);
  }
}

TEST(CommandedCircle, FeedIsConstantOnTheArcAndRisesAndFallsInTheOvershoots) {
  const CommandedPath path = commanded_circle(test::lrmate(), test::paper_circle("A"), 1, kFeed, 100.0);
  const Eigen::VectorXd& t = path.motion.time;
  EXPECT_GE(t[0], 0.0);
  EXPECT_LT(t[0], 0.01);
  EXPECT_LE(t[t.size() - 1], path.duration);
  EXPECT_GT(t[t.size() - 1], path.duration - 0.01);
  EXPECT_NEAR(path.angle[0], -60 * kDeg, 1e-6) << "it begins at the begin of the overshoot";
  EXPECT_NEAR(path.angle[t.size() - 1], 420 * kDeg, 1e-6);
  EXPECT_NEAR(path.angle[path.arc_begin], 0.0, 1e-12) << "one sample on the arc's start";
  double feed_before = 0.0;
  for (Eigen::Index i = 1; i < t.size(); ++i) {
    const double feed = (path.angle[i] - path.angle[i - 1]) * 0.1 / (t[i] - t[i - 1]);
    const bool on_arc = path.angle[i - 1] > -1e-9 && path.angle[i] < 360 * kDeg + 1e-9;
    if (on_arc) {
      EXPECT_NEAR(feed, kFeed, 1e-9);
    }
    EXPECT_LE(feed, kFeed + 1e-9);
    EXPECT_LT(std::abs(feed - feed_before), 0.05 * kFeed) << "no step at " << t[i] << " s";
    feed_before = feed;
  }
  EXPECT_LT(feed_before, 0.05 * kFeed) << "and it comes to rest";
}

TEST(CommandedCircle, ClockwiseIsTheSameWayBack) {
  const CommandedPath up = commanded_circle(test::lrmate(), test::paper_circle("A"), 1, kFeed, 100.0);
  const CommandedPath down = commanded_circle(test::lrmate(), test::paper_circle("A"), -1, kFeed, 100.0);
  EXPECT_NEAR(down.angle[down.arc_begin], 2 * pi, 1e-12) << "from start + sweep";
  ASSERT_EQ(up.angle.size(), down.angle.size());
  for (Eigen::Index i = 0; i < up.angle.size(); ++i)
    ASSERT_NEAR(up.angle[i] - 0.0, 2 * pi - down.angle[i], 1e-12) << "as far from the arc's entry";
}

TEST(CommandedCircle, WithoutOvershootItIsTheArcAloneAtConstantFeed) {
  TestSpec test = test::paper_circle("A");
  test.circle.overshoot = 0.0;
  test.circle.arc_start = 30 * kDeg;
  test.circle.arc_sweep = 90 * kDeg;
  const double rate = 90.0 * kFeed / (0.1 * 90 * kDeg);  // a sample a degree
  const CommandedPath path = commanded_circle(test::lrmate(), test, 1, kFeed, rate);
  ASSERT_EQ(path.angle.size(), 91);
  EXPECT_EQ(path.arc_begin, 0);
  EXPECT_EQ(path.arc_end, 91);
  for (Eigen::Index i = 0; i < 91; ++i)
    EXPECT_NEAR(path.angle[i], (30.0 + static_cast<double>(i)) * kDeg, 1e-12);
}

TEST(CommandedCircle, ThePostureChoosesTheConfiguration) {
  TestSpec test = test::paper_circle("A");
  const CommandedPath plain = commanded_circle(test::lrmate(), test, 1, kFeed, 20.0);
  test.posture = {0, 0, 0, pi, 0, 0};
  const CommandedPath flipped = commanded_circle(test::lrmate(), test, 1, kFeed, 20.0);
  for (Eigen::Index i = 0; i < plain.motion.time.size(); ++i) {
    EXPECT_NEAR(plain.motion.q(3, i), 0.0, 1e-9);
    EXPECT_NEAR(flipped.motion.q(3, i), pi, 1e-9);
    EXPECT_NEAR(flipped.motion.q(4, i), -plain.motion.q(4, i), 1e-9) << "J5 the other way";
  }
}

TEST(CommandedCircle, ATestWithoutToolKeepsTheOrientationOfItsPosture) {
  TestSpec test = test::paper_circle("A");
  const RobotModel model = test::lrmate();
  test.tool_rpy.reset();
  EXPECT_NE(error_of(test).find("test 'A': how the tool is held is not configured; give tool_rpy_deg"),
            std::string::npos)
      << error_of(test);
  test.posture = {-40 * kDeg, 50 * kDeg, -70 * kDeg, 0, -20 * kDeg, 40 * kDeg};  // straight down
  const CommandedPath path = commanded_circle(model, test, 1, kFeed, 20.0);
  const Eigen::Matrix3d held = model.forward(test.posture).linear();
  for (Eigen::Index i = 0; i < path.motion.time.size(); ++i) {
    const Eigen::VectorXd q = path.motion.q.col(i);
    EXPECT_LT((model.chain().forward({q.data(), 6}).linear() - held).norm(), 1e-8);
  }
}

TEST(CommandedCircle, WhatStandsInTheWayIsNamedWithItsPlace) {
  TestSpec far = test::paper_circle("A");
  far.circle.centre = {0.900, 0.0, -0.251};
  EXPECT_EQ(error_of(far).find("test 'A': at 300.0 deg of the circle no joint angles bring the tool there"),
            0u)
      << error_of(far);

  TestSpec wrist = test::paper_circle("A");  // physics-gap.md 2: tool down, J5 passes 0
  wrist.circle.centre = {0.390, 0.0, -0.251};
  const std::string singular = error_of(wrist);
  EXPECT_EQ(singular.find("test 'A': at "), 0u);
  EXPECT_NE(singular.find(
                " deg of the circle the arm is singular: J4 and J6 turn against each other; tilt the tool"),
            std::string::npos)
      << singular;

  TestSpec behind = test::paper_circle("A");
  behind.circle.centre = {-0.480, 0.0, -0.251};
  behind.posture = {170 * kDeg, 0, 0, 0, 0, 0};
  const std::string limit = error_of(behind);
  EXPECT_NE(limit.find(" deg of the circle J1 (joint_1) would pass its limits of -170.0 to 170.0 deg"),
            std::string::npos)
      << limit;

  TestSpec posture = test::paper_circle("A");
  posture.posture = {0, 0, 0};
  EXPECT_EQ(error_of(posture), "test 'A': 'posture_deg' holds 3 angles, the chain has 6 joints");
}

TEST(CommandedLine, StandsAtEachPointAndGoesBackTheSameWay) {
  const RobotModel model = test::lrmate();
  for (const int direction : {1, -1}) {
    SCOPED_TRACE(direction);
    const CommandedPath path = commanded_line(model, test::paper_line(), direction, kFeed, 0.3, 100.0);
    ASSERT_EQ(path.stop_end.size(), 51);
    for (Eigen::Index k = 0; k < 51; ++k) {
      const double expected =
          direction > 0 ? 0.0188 * static_cast<double>(k) : 0.940 - 0.0188 * static_cast<double>(k);
      EXPECT_NEAR(path.stop_position[k], expected, 1e-12);
      for (Eigen::Index i = 0; i < path.motion.time.size(); ++i) {
        const double until = path.stop_end[k] - path.motion.time[i];
        if (until > 1e-9 && until < 0.3 - 1e-9) {
          ASSERT_NEAR(path.position[i], expected, 1e-12) << "at " << path.motion.time[i] << " s";
        }
      }
    }
    double fastest = 0.0;
    for (Eigen::Index i = 1; i < path.position.size(); ++i) {
      EXPECT_GE(direction * (path.position[i] - path.position[i - 1]), -1e-12);
      fastest = std::max(fastest, std::abs(path.position[i] - path.position[i - 1]) * 100.0);
      const Eigen::VectorXd q = path.motion.q.col(i);
      ASSERT_LT((model.chain().forward({q.data(), 6}).translation() - path.points.col(i)).norm(), 1e-9);
    }
    EXPECT_NEAR(fastest, kFeed, 1e-6);
  }
}

TEST(CommandedLine, WhatStandsInTheWayIsNamedWithItsPlace) {
  TestSpec line = test::paper_line();
  line.line.end = {0.380, 1.000, -0.251};
  const std::string far = error_of(line);
  EXPECT_EQ(far.find("test 'Y': at "), 0u);
  EXPECT_NE(far.find(" mm of the line no joint angles bring the tool there; move start_mm and end_mm"),
            std::string::npos)
      << far;
  line = test::paper_line();
  line.line.points = 0;
  EXPECT_NE(error_of(line).find("test 'Y': give 'points'"), std::string::npos);
}

}  // namespace
}  // namespace ballbar
