// What the controller and the instrument add: readings that are late or rounded, balls and gauges that jump.

#include <gtest/gtest.h>

#include "physics/physics_test.hpp"

namespace ballbar {
namespace {

using test::effect;
using test::lrmate_with;

constexpr std::int64_t kStart = 1'773'219'600'000'000;  // 2026-03-11, microseconds

TEST(Readback, ThatIsLateShowsWhereTheJointWas) {
  const auto angle = [](double t) { return 0.3 + 0.5 * t; };
  const Motion motion = test::single(100, 250, angle);
  const AsBuilt robot = test::arm_with({effect("joint_readback_lag", 0, {{"lag_ms", 7}})});
  const Eigen::MatrixXd reading = robot.readback(motion, {});
  for (int k = 0; k < 100; ++k)
    EXPECT_NEAR(reading(0, k), angle(std::max(0.0, motion.time(k) - 0.007)), 1e-15) << k;
}

TEST(Readback, OfOneJointOrOfAll) {
  const Motion motion = test::swing(100, 50);
  for (int joint = 0; joint <= 6; ++joint) {
    const Eigen::MatrixXd reading =
        lrmate_with({effect("joint_readback_lag", joint, {{"lag_ms", 7}})}).readback(motion, {});
    for (int j = 1; j <= 6; ++j)
      EXPECT_EQ((reading.row(j - 1) - motion.q.row(j - 1)).norm() > 0.0, joint == 0 || j == joint);
  }
}

TEST(Readback, AtPosesLacksAPartOfTheLastMove) {
  Motion poses{Eigen::VectorXd::LinSpaced(3, 0, 2), Eigen::MatrixXd(1, 3)};
  poses.q << 0.1, 0.5, -0.3;
  const AsBuilt robot = test::arm_with({effect("joint_readback_lag", 1, {{"fraction_of_move", 0.01}})});
  const Eigen::MatrixXd reading = robot.readback(poses, {});
  EXPECT_NEAR(reading(0, 0), 0.1, 1e-16);
  EXPECT_NEAR(reading(0, 1), 0.5 - 0.004, 1e-16);
  EXPECT_NEAR(reading(0, 2), -0.3 + 0.008, 1e-16);
}

TEST(Readback, IsRoundedAsThePendantShowsIt) {
  const Motion motion = test::swing(200, 50);
  const AsBuilt robot = lrmate_with({effect("joint_readback_rounding", 0, {{"step_deg", 0.01}})});
  const Eigen::MatrixXd reading = robot.readback(motion, {});
  for (int k = 0; k < 200; ++k) {
    for (int j = 0; j < 6; ++j) {
      // J3 of a FANUC pendant is J3 of the chain - J2.
      const double shown = (reading(j, k) - (j == 2 ? reading(1, k) : 0.0)) / kPi * 180 / 0.01;
      const double truth = (motion.q(j, k) - (j == 2 ? motion.q(1, k) : 0.0)) / kPi * 180 / 0.01;
      EXPECT_NEAR(shown, std::round(shown), 1e-9);
      EXPECT_LE(std::abs(shown - truth), 0.5 + 1e-9);
    }
  }
}

TEST(Readback, IsLateFirstAndRoundedThen) {
  const Motion motion = test::single(50, 100, [](double t) { return 0.0123 * t; });
  const AsBuilt robot = test::arm_with({effect("joint_readback_rounding", 0, {{"step_deg", 0.01}}),
                                        effect("joint_readback_lag", 1, {{"lag_ms", 50}})});
  const Eigen::MatrixXd reading = robot.readback(motion, {});
  for (int k = 0; k < 50; ++k) {
    const double steps = reading(0, k) / kPi * 180 / 0.01;
    EXPECT_NEAR(steps, std::round(steps), 1e-9);
  }
}

TEST(BallSlip, HappensOnTheProducersClock) {
  const AsBuilt robot = lrmate_with({effect(
      "ball_slip", 0, {{"x_um", 8}, {"z_um", -3}, {"time_us", static_cast<double>(kStart + 5'000'000)}})});
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(11, 0, 10);
  const Eigen::Matrix3Xd moved = robot.ball_displacement(time, {.start_us = kStart});
  for (int k = 0; k <= 10; ++k)
    EXPECT_LT((moved.col(k) - (k >= 5 ? Eigen::Vector3d(8e-6, 0, -3e-6) : Eigen::Vector3d::Zero())).norm(),
              1e-20);
  EXPECT_EQ(robot.ball_displacement(time, {.start_us = kStart - 60'000'000}).norm(), 0.0)
      << "a run before it";
  EXPECT_GT(robot.ball_displacement(time, {.start_us = kStart + 60'000'000}).colwise().norm().minCoeff(),
            8e-6)
      << "a run after it";
  EXPECT_EQ(robot.ball_displacement(time, {}).norm(), 0.0) << "when the run started is not known";
}

TEST(BallSlip, LeavesBallsThatStandElsewhere) {
  const Eigen::Vector3d here(0.38, -0.32, -0.251), there(0.38, 0.32, -0.251);
  const auto slip = [](std::map<std::string, double> where) {
    where["x_um"] = 8;
    where["time_us"] = static_cast<double>(kStart);
    return lrmate_with({effect("ball_slip", 0, where)});
  };
  const AsBuilt one = slip({{"centre_x_mm", 380}, {"centre_y_mm", -320}, {"centre_z_mm", -251}});
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(3, 1, 2);
  const auto moved = [&](const AsBuilt& robot, std::optional<Eigen::Vector3d> ball) {
    return robot.ball_displacement(time, {.start_us = kStart, .ball = ball}).norm() > 0.0;
  };
  EXPECT_TRUE(moved(one, here));
  EXPECT_FALSE(moved(one, there));
  EXPECT_FALSE(moved(one, std::nullopt)) << "nobody knows which ball that was";
  EXPECT_TRUE(moved(slip({}), there)) << "any ball";
  EXPECT_TRUE(moved(slip({{"centre_x_mm", 380}}), there)) << "all with that x";
}

TEST(GaugeJump, HappensOnTheClockOrAtARow) {
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(4, 0, 3);
  const AsBuilt by_clock = lrmate_with(
      {effect("gauge_jump", 0, {{"jump_um", -9}, {"time_us", static_cast<double>(kStart) + 2e6}})});
  const AsBuilt by_row = lrmate_with({effect("gauge_jump", 0, {{"jump_um", -9}, {"row", 3}})});
  const Eigen::Vector4d want(0, 0, -9e-6, -9e-6);
  EXPECT_LT((by_clock.gauge_offset(time, {.start_us = kStart}) - want).norm(), 1e-20);
  EXPECT_LT((by_row.gauge_offset(time, {}) - want).norm(), 1e-20);
}

TEST(StructuralVibration, HasTheSameFrequencyAtAnySpeedAndGoesOnBetweenRuns) {
  const AsBuilt robot =
      lrmate_with({effect("structural_vibration", 0, {{"frequency_hz", 12.5}, {"amplitude_um", 6}})});
  const Eigen::VectorXd time = Eigen::VectorXd::LinSpaced(101, 0, 1);
  const Eigen::VectorXd bar = robot.gauge_offset(time, {.series_time = 100.03});
  for (int k = 0; k <= 100; ++k)
    EXPECT_NEAR(bar(k), 6e-6 * std::sin(2 * kPi * 12.5 * (0.03 + time(k))), 1e-16);  // 100 s are whole turns
}

}  // namespace
}  // namespace ballbar
