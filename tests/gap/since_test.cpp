// Changes of known kind from physics that share no code with lib/ (tests/blind): what they look like.

#include "gap/since.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "blind/generator/truth.hpp"
#include "gap/paper_robot.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kMicrodegree = 1e-6 * std::numbers::pi / 180.0;
constexpr Index kRows = 2 * (kLastChangedOrder - kFirstChangedOrder + 1);

TestSpec spec_of(const blind::Test& test) {
  TestSpec spec;
  spec.name = test.name;
  const auto set = [](Vec3& to, const Eigen::Vector3d& from) { to = {from.x(), from.y(), from.z()}; };
  set(spec.circle.centre, 1e-3 * test.centre_mm);
  set(spec.circle.normal, test.normal);
  set(spec.circle.first_axis, test.first_axis);
  spec.circle.radius = 1e-3 * test.radius_mm;
  spec.circle.arc_start = test.start_deg * test::kDeg;
  spec.circle.arc_sweep = test.sweep_deg * test::kDeg;
  spec.circle.overshoot = blind::kOvershootDeg * test::kDeg;
  spec.feed = 1e-3 * test.feed_mm_s;
  spec.payload = test.payload_kg;
  return spec;
}

/// Plain sums over one turn: the arc of a full circle has evenly spaced samples.
VectorXd harmonics(const std::vector<double>& angle, const std::vector<double>& value, std::size_t begin,
                   std::size_t end) {
  VectorXd sums = VectorXd::Zero(kRows);
  const auto n = static_cast<double>(end - begin);
  for (std::size_t i = begin; i < end; ++i)
    for (int k = kFirstChangedOrder; k <= kLastChangedOrder; ++k) {
      sums[2 * (k - kFirstChangedOrder)] += 2.0 / n * value[i] * std::cos(k * angle[i]);
      sums[2 * (k - kFirstChangedOrder) + 1] += 2.0 / n * value[i] * std::sin(k * angle[i]);
    }
  return sums;
}

/// Circles of the plan that the paper's robot drives before and after a change of its physics.
class SinceTest : public testing::Test {
 protected:
  SinceTest() : plan_(blind::plan("PM")) {
    before_.masses.upper_arm = 1.08;  // wrong masses, as everywhere
    before_.masses.forearm = 0.93;
    before_.compliance = {0, 2e-6, 2e-6, 0, 2e-6, 0};
  }

  /// What looks_like() says of the change from `before_` to `after`.
  std::vector<Likeness> likeness(const blind::Physics& after) const {
    std::vector<TestSpec> tests;
    for (const blind::Test& test : plan_.tests) tests.push_back(spec_of(test));
    RobotSpec robot = test::paper_robot(tests, {});
    robot.joint_convention = JointConvention::kSerial;
    robot.gear_ratio = {120, 121, 100, 80, 80, 50};
    robot.payload_com = {0.0, 0.0, 0.05};
    const RobotModel model(test::lrmate_urdf(), "base", "tcp", JointConvention::kSerial);
    std::vector<MeasuredRun> runs;
    std::vector<VectorXd> steps;
    for (const blind::Recording& recording : plan_.recordings) {
      if (recording.repetition != 1 || recording.held_out) continue;
      const blind::Test& test = plan_.tests[static_cast<std::size_t>(recording.test)];
      if (test.sweep_deg != 360.0) continue;
      const blind::Sampling sampling = blind::sampling(test);
      const auto bar = [&](const blind::Physics& physics) {
        return blind::bar(physics, blind::way(physics, test, recording.direction, 0.0), plan_, recording,
                          blind::ball_place(physics, test, Eigen::Vector3d(1e-5, -2e-5, 1e-5)), 0.0);
      };
      const std::vector<double> was = bar(before_), is = bar(after);
      MeasuredRun one;
      one.run.robot = robot.name;
      one.run.test = test.name;
      one.run.series = "s";
      one.run.direction = recording.direction;
      one.run.repetition = 1;
      one.run.feed = 1e-3 * test.feed_mm_s;
      one.run.payload = test.payload_kg;
      one.run.started_us = static_cast<std::int64_t>(6e7 * recording.minute);
      one.run.joints = 6;
      const auto asked = blind::command(test, recording.direction, 0.0, sampling.bar_period, was.size());
      std::vector<double> moved(was.size());
      for (std::size_t i = 0; i < was.size(); ++i) {
        const double time = static_cast<double>(i) * sampling.bar_period;
        one.run.bar_time.push_back(time);
        one.run.bar_deviation.push_back(was[i]);
        one.run.joint_time.push_back(time);
        one.run.joint_position.insert(one.run.joint_position.end(), asked[i].begin(), asked[i].end());
        const double turn = (static_cast<double>(i) - sampling.before) / sampling.arc;
        const double way = recording.direction > 0 ? turn : 1.0 - turn;
        one.angle.push_back((test.start_deg + test.sweep_deg * way) * test::kDeg);
        moved[i] = is[i] - was[i];
      }
      one.run.ended_us = one.run.started_us + static_cast<std::int64_t>(1e6 * one.run.bar_time.back());
      one.arc_begin = static_cast<std::size_t>(sampling.before);
      one.arc_end = one.arc_begin + static_cast<std::size_t>(sampling.arc);
      steps.push_back(harmonics(one.angle, moved, one.arc_begin, one.arc_end));
      runs.push_back(std::move(one));
    }
    const Observations seen = observe(std::move(runs), robot, model);
    EXPECT_TRUE(seen.left_aside.empty()) << seen.left_aside.front();
    EXPECT_EQ(seen.all.size(), steps.size());
    std::vector<HarmonicChange> changes;
    for (std::size_t i = 0; i < steps.size(); ++i)
      changes.push_back({i, steps[i], VectorXd::Constant(kRows, 0.1e-6)});
    return looks_like(GapModel(AsBuilt(model, robot), robot), seen.all, changes);
  }

  static void expect_named(const std::vector<Likeness>& found, const std::string& effect, int joint) {
    ASSERT_FALSE(found.empty());
    EXPECT_EQ(found[0].effect, effect);
    EXPECT_EQ(found[0].joint, joint);
    EXPECT_GT(found[0].explains, 0.9);
    EXPECT_EQ(found[0].worse, 0.0);
  }

  blind::Plan plan_;
  blind::Physics before_;
};

TEST_F(SinceTest, AZeroOffsetThatMovedIsNamedWithItsSize) {
  for (const int joint : {2, 3, 5}) {
    SCOPED_TRACE(joint);
    blind::Physics after = before_;
    after.zero_offset[static_cast<std::size_t>(joint - 1)] += 0.02 * test::kDeg;
    const std::vector<Likeness> found = likeness(after);
    expect_named(found, "joint_zero_offset", joint);
    ASSERT_EQ(found[0].parameters.size(), 1u);
    EXPECT_EQ(found[0].parameters[0].first, "offset_deg");
    EXPECT_NEAR(found[0].parameters[0].second, 0.02, 0.002);
  }
}

TEST_F(SinceTest, WearOfAGearIsLostMotionOfItsJoint) {
  for (const int joint : {2, 3, 4}) {
    SCOPED_TRACE(joint);
    blind::Physics after = before_;
    after.windup_half[static_cast<std::size_t>(joint - 1)] += 6000 * kMicrodegree;
    expect_named(likeness(after), "joint_lost_motion", joint);
  }
}

TEST_F(SinceTest, AGearThatHasGrownSoftIsCompliance) {
  for (const int joint : {2, 3}) {
    SCOPED_TRACE(joint);
    blind::Physics after = before_;
    after.compliance[static_cast<std::size_t>(joint - 1)] += 8e-6;
    expect_named(likeness(after), "joint_compliance", joint);
  }
}

TEST_F(SinceTest, ACollisionThatBentALinkIsGeometry) {
  blind::Physics after = before_;
  after.geometry.alpha[3] += 0.03 * test::kDeg;
  const std::vector<Likeness> found = likeness(after);
  expect_named(found, "link_geometry", 4);
}

TEST_F(SinceTest, NothingIsNamedWhereNothingMoved) {
  const std::vector<Likeness> found = likeness(before_);
  EXPECT_TRUE(found.empty());
}

}  // namespace
}  // namespace ballbar
