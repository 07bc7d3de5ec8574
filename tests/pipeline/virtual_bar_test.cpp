// The virtual ballbar: what the joints of a planar_model arm say of the circle it drives.

#include "pipeline/virtual_bar.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "metrology/circle.hpp"
#include "pipeline/catalogue.hpp"
#include "pipeline/process.hpp"
#include "support/planar_cell.hpp"

namespace ballbar {
namespace {

using test::PlanarCircle;

const AsBuilt& robot() {
  static const AsBuilt as_built(RobotModel(test::kPlanarUrdf, "base", "tcp", JointConvention::kSerial), {});
  return as_built;
}

const RobotModel& planar_model() { return robot().model(); }

/// JOINTS of a circle, of which the second joint says `off` radians too much; no bar.
ballbar::Run joints_only(const PlanarCircle& circle, double off = 0.0) {
  ballbar::Run run = test::planar_run(circle);
  run.bar_time.clear();
  run.bar_deviation.clear();
  for (std::size_t i = 1; i < run.joint_position.size(); i += 2) run.joint_position[i] += off;
  return run;
}

/// School geometry: distance of the arm's tip from a point.
double distance(const ballbar::Run& run, std::size_t i, double x, double y) {
  const double shoulder = run.joint_position[2 * i];
  const double elbow = shoulder + run.joint_position[2 * i + 1];
  return std::hypot(0.4 * std::cos(shoulder) + 0.3 * std::cos(elbow) - x,
                    0.4 * std::sin(shoulder) + 0.3 * std::sin(elbow) - y);
}

TEST(VirtualBar, ReadsTheDistanceFromTheConfiguredCentre) {
  const PlanarCircle circle;
  ballbar::Run run = joints_only(circle, 1e-3);
  const TestSpec test = test::planar_test(circle);
  add_virtual_bar(run, test, planar_model());
  EXPECT_TRUE(run.virtual_bar);
  ASSERT_EQ(run.bar_time, run.joint_time);
  for (std::size_t i = 0; i < run.bar_time.size(); ++i)
    ASSERT_NEAR(run.bar_deviation[i], distance(run, i, 0.45, 0.1) - 0.1, 1e-12) << i;
  const RunResult result = process(run, test, &robot());
  EXPECT_EQ(result.status, "ok") << result.message;
  EXPECT_EQ(result.source, "joints");
  EXPECT_EQ(result.angle_source, "joints");
  EXPECT_EQ(records(run, result).front().source, "joints");
}

// With the path's own shape in the joints, a bar on the programmed centre reads the same as the joints.
TEST(VirtualBar, GivesTheFiguresOfABarThatSeesTheSamePath) {
  const PlanarCircle circle;
  const TestSpec test = test::planar_test(circle);
  ballbar::Run virtual_run = joints_only(circle, 2e-3);
  ballbar::Run bar_run = virtual_run;
  for (std::size_t i = 0; i < bar_run.joint_time.size(); ++i) {
    bar_run.bar_time.push_back(bar_run.joint_time[i]);
    bar_run.bar_deviation.push_back(distance(bar_run, i, 0.45, 0.1) - 0.1);
  }
  add_virtual_bar(virtual_run, test, planar_model());
  const RunResult of_joints = process(virtual_run, test, &robot());
  const RunResult of_bar = process(bar_run, test, &robot());
  EXPECT_EQ(of_bar.source, "bar");
  ASSERT_TRUE(of_joints.circle && of_bar.circle);
  EXPECT_GT(ovality(*of_joints.circle)->value, 1e-6) << "an elbow that is off leaves more than a shift";
  for (std::size_t k = 0; k < 5; ++k) {
    EXPECT_NEAR(of_joints.circle->harmonics[k].cos, of_bar.circle->harmonics[k].cos, 1e-11);
    EXPECT_NEAR(of_joints.circle->harmonics[k].sin, of_bar.circle->harmonics[k].sin, 1e-11);
  }
  EXPECT_NEAR(of_joints.circle->circular_deviation, of_bar.circle->circular_deviation, 1e-11);
}

TEST(VirtualBar, TheFittedCentreTakesTheShiftAwayAndLeavesTheShape) {
  PlanarCircle circle;
  for (const double sweep : {360.0, 220.0}) {
    circle.arc_sweep_deg = sweep;
    TestSpec test = test::planar_test(circle);
    test.circle.centre[0] += 1.2e-3;  // configured 1.2 mm beside the circle that is driven
    ballbar::Run configured = joints_only(circle);
    ballbar::Run fitted = configured;
    add_virtual_bar(configured, test, planar_model());
    test.virtual_centre = VirtualCentre::kFitted;
    add_virtual_bar(fitted, test, planar_model());
    const RunResult about_configured = process(configured, test, &robot());
    const RunResult about_fitted = process(fitted, test, &robot());
    EXPECT_EQ(about_fitted.status, "ok") << about_fitted.message;
    EXPECT_NEAR(about_configured.circle->eccentricity_x, -1.2e-3, 2e-6);
    EXPECT_NEAR(about_fitted.circle->eccentricity_x, 0.0, 1e-9);
    EXPECT_NEAR(about_fitted.circle->circular_deviation, 0.0, 1e-9);
    for (const double d : fitted.bar_deviation) ASSERT_NEAR(d, 0.0, 1e-9);
  }
}

TEST(VirtualBar, StandsInOnlyWhereThereIsNoBarAndTheJointsFit) {
  const PlanarCircle circle;
  const TestSpec test = test::planar_test(circle);
  ballbar::Run with_bar = test::planar_run(circle);
  const std::vector<double> readings = with_bar.bar_deviation;
  add_virtual_bar(with_bar, test, planar_model());
  EXPECT_FALSE(with_bar.virtual_bar);
  EXPECT_EQ(with_bar.bar_deviation, readings);

  ballbar::Run other_chain = joints_only(circle);
  other_chain.joints = 1;
  add_virtual_bar(other_chain, test, planar_model());
  EXPECT_FALSE(other_chain.virtual_bar);

  ballbar::Run silent = joints_only(circle);
  silent.joint_time.clear();
  silent.joint_position.clear();
  add_virtual_bar(silent, test, planar_model());
  EXPECT_FALSE(silent.virtual_bar);
  EXPECT_EQ(process(silent, test, &robot()).status, "too_few_samples");

  for (const RunEnd end : {RunEnd::kAborted, RunEnd::kProducerRestart, RunEnd::kNoBegin}) {
    ballbar::Run discarded = joints_only(circle);
    discarded.end = end;
    add_virtual_bar(discarded, test, planar_model());
    EXPECT_FALSE(discarded.virtual_bar);
  }
}

TEST(VirtualBar, ACircleThatTheJointsDoNotDriveIsNotOk) {
  const PlanarCircle circle;
  TestSpec elsewhere = test::planar_test(circle);
  elsewhere.circle.centre[1] += 0.02;
  for (const VirtualCentre centre : {VirtualCentre::kConfigured, VirtualCentre::kFitted}) {
    elsewhere.virtual_centre = centre;
    ballbar::Run run = joints_only(circle);
    add_virtual_bar(run, elsewhere, planar_model());
    EXPECT_EQ(process(run, elsewhere, &robot()).status, "wrong_path");
  }
}

// A cable that is out must not look like a robot that is measured by its joints.
TEST(VirtualBar, IsNotOkWhereTheCircleBeforeHadABar) {
  const PlanarCircle circle;
  const TestSpec test = test::planar_test(circle);
  ballbar::Run run = joints_only(circle);
  add_virtual_bar(run, test, planar_model());
  Partners before;
  EXPECT_EQ(process(run, test, &robot(), before).status, "ok");
  before.bar = true;
  const RunResult without = process(run, test, &robot(), before);
  EXPECT_EQ(without.status, "no_bar");
  EXPECT_NE(without.message.find("no BALLBAR came"), std::string::npos) << without.message;
  EXPECT_EQ(without.source, "joints");
  EXPECT_TRUE(without.circle) << "the figures are there all the same";
  run.end = RunEnd::kGeometry;
  EXPECT_EQ(process(run, test, &robot(), before).status, "ok") << "without marks it may be at work";
  EXPECT_EQ(process(test::planar_run(circle), test, &robot(), before).status, "ok") << "the bar was there";
}

TEST(VirtualBar, ASecondCallChangesNothing) {
  const PlanarCircle circle;
  ballbar::Run run = joints_only(circle);
  add_virtual_bar(run, test::planar_test(circle), planar_model());
  const std::vector<double> once = run.bar_deviation;
  add_virtual_bar(run, test::planar_test(circle), planar_model());
  EXPECT_EQ(run.bar_deviation, once);
}

}  // namespace
}  // namespace ballbar
