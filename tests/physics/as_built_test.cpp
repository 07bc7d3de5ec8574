// The robot as built: constant geometry against forward kinematics by another road, and what does not matter.

#include "physics/as_built.hpp"

#include <gtest/gtest.h>

#include <stdexcept>

#include "physics/physics_test.hpp"

namespace ballbar {
namespace {

using test::effect;
using test::lrmate_with;

TEST(AsBuilt, WithoutEffectsIsNominalForwardKinematics) {
  const AsBuilt robot = lrmate_with({});
  EXPECT_TRUE(robot.nominal());
  const Motion motion = test::swing(50, 10);
  const Eigen::Matrix3Xd points = robot.tool_points(motion, {.payload = 3.0});
  EXPECT_EQ(robot.follow(motion, {}).q, motion.q);
  EXPECT_EQ(robot.readback(motion, {}), motion.q);
  EXPECT_EQ(robot.gauge_offset(motion.time, {}), Eigen::VectorXd::Zero(50));
  EXPECT_EQ(robot.ball_displacement(motion.time, {}), Eigen::Matrix3Xd::Zero(3, 50));
  for (int k = 0; k < 50; ++k) {
    std::vector<double> q = test::column(motion, k);
    robot.model().from_chain(q);
    EXPECT_LT((points.col(k) - robot.model().forward(q).translation()).norm(), 1e-15);
  }
}

TEST(AsBuilt, AZeroOffsetIsAnAngleMoreOfThatChainJoint) {
  const Motion motion = test::swing(20, 10);
  for (int joint = 1; joint <= 6; ++joint) {
    const AsBuilt robot = lrmate_with({effect("joint_zero_offset", joint, {{"offset_deg", 0.172}})});
    EXPECT_FALSE(robot.nominal());
    Motion turned = motion;
    turned.q.row(joint - 1).array() += 0.172 * kRadPerDeg;
    const Eigen::Matrix3Xd want = lrmate_with({}).tool_points(turned, {});
    EXPECT_LT((robot.tool_points(motion, {}) - want).norm(), 1e-13) << "joint " << joint;
  }
}

// A payload of a mark, a hundred digits long: where the arm would bend to is not known, the rest is.
TEST(AsBuilt, WhereNoAngleIsLeftThereIsNoPoint) {
  const AsBuilt robot = lrmate_with({effect("joint_compliance", 2, {{"compliance_rad_per_nm", 4e-5}})});
  const Motion motion = test::swing(20, 10);
  EXPECT_FALSE(robot.tool_points(motion, {.payload = 1e308}).array().isFinite().any());
  EXPECT_TRUE(robot.tool_points(motion, {.payload = 1.0}).allFinite());
}

// The nominal chain in words of the maker's table, with one row changed by hand: Tx(a) Rx(alpha) Ry(beta)
// Rz(theta) Tz(d), multiplied as 4 x 4 matrices.
TEST(AsBuilt, LinkGeometryChangesItsRowOfTheTable) {
  const Motion motion = test::swing(10, 5);
  const std::vector<DhRow> rows = lrmate_with({}).model().chain().rows();
  const Eigen::Isometry3d tip = lrmate_with({}).model().chain().forward(std::vector<double>(6, 0.0));
  const auto by_hand = [&](const std::vector<DhRow>& table, const Eigen::Isometry3d& tool, int k) {
    Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
    for (std::size_t i = 0; i < table.size(); ++i) {
      const DhRow& r = table[i];
      const double angle = k < 0 ? 0.0 : motion.q(static_cast<int>(i), k);
      pose = pose * Eigen::Translation3d(r.a, 0, 0) * Eigen::AngleAxisd(r.alpha, Eigen::Vector3d::UnitX()) *
             Eigen::AngleAxisd(r.beta, Eigen::Vector3d::UnitY()) *
             Eigen::AngleAxisd(r.theta + r.sign * angle, Eigen::Vector3d::UnitZ()) *
             Eigen::Translation3d(0, 0, r.d);
    }
    return (pose * tool).translation().eval();
  };
  // With the base frame on axis 1 the tool follows from the tip at zero.
  Eigen::Isometry3d last = Eigen::Isometry3d::Identity();
  for (const DhRow& r : rows)
    last = last * Eigen::Translation3d(r.a, 0, 0) * Eigen::AngleAxisd(r.alpha, Eigen::Vector3d::UnitX()) *
           Eigen::AngleAxisd(r.theta, Eigen::Vector3d::UnitZ()) * Eigen::Translation3d(0, 0, r.d);
  const Eigen::Isometry3d tool = last.inverse() * tip;

  std::vector<DhRow> changed = rows;
  changed[2].a += 0.3e-3;
  changed[2].beta += 0.04 * kRadPerDeg;
  changed[3].d += -0.2e-3;
  changed[3].alpha += 0.06 * kRadPerDeg;
  const AsBuilt robot = lrmate_with({effect("link_geometry", 3, {{"a_mm", 0.3}, {"beta_deg", 0.04}}),
                                     effect("link_geometry", 4, {{"d_mm", -0.2}}),
                                     effect("link_geometry", 4, {{"alpha_deg", 0.06}})});
  const Eigen::Matrix3Xd points = robot.tool_points(motion, {});
  for (int k = 0; k < 10; ++k)
    EXPECT_LT((points.col(k) - by_hand(changed, tool, k)).norm(), 1e-13) << "sample " << k;
}

TEST(AsBuilt, AToolOffsetLiesAlongTheTipsAxes) {
  const Motion motion = test::swing(10, 5);
  const AsBuilt robot = lrmate_with({effect("tool_offset", 0, {{"x_mm", 0.1}, {"z_mm", -0.2}})});
  const Eigen::Matrix3Xd points = robot.tool_points(motion, {});
  for (int k = 0; k < 10; ++k) {
    const Eigen::Isometry3d tip = robot.model().chain().forward(test::column(motion, k));
    EXPECT_LT((points.col(k) - tip * Eigen::Vector3d(0.1e-3, 0, -0.2e-3)).norm(), 1e-15);
  }
}

TEST(AsBuilt, TakesMotionsOfItsJointsOnly) {
  const AsBuilt robot = lrmate_with({});
  Motion motion = test::swing(5, 10);
  motion.time(3) = motion.time(2);
  EXPECT_THROW(robot.tool_points(motion, {}), std::invalid_argument);
  EXPECT_THROW(robot.follow({Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Zero(5, 1)}, {}),
               std::invalid_argument);
  EXPECT_THROW(robot.readback({Eigen::VectorXd::Zero(2), Eigen::MatrixXd::Zero(6, 1)}, {}),
               std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
