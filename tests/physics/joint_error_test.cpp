// Errors that are fixed in a joint's angle, growth and drift over time: closed forms.

#include <gtest/gtest.h>

#include "physics/physics_test.hpp"

namespace ballbar {
namespace {

using test::effect;
using test::lrmate_with;

TEST(TransmissionError, IsASineOfTheMotorsAngleInEitherDirection) {
  const Motion motion = test::swing(1000, 100);
  const AsBuilt robot = lrmate_with({effect(
      "transmission_error", 2, {{"cycles_per_turn", 242}, {"amplitude_deg", 0.003}, {"phase_deg", 40}})});
  const Eigen::MatrixXd link = robot.link_angles(motion, {});
  for (int k = 0; k < 1000; ++k)
    for (int j = 0; j < 6; ++j) {
      const double deg = motion.q(j, k) / kPi * 180;
      const double want = j == 1 ? 0.003 / 180 * kPi * std::sin((242 * deg + 40) / 180 * kPi) : 0.0;
      EXPECT_NEAR(link(j, k) - motion.q(j, k), want, 1e-14) << "joint " << j + 1 << " sample " << k;
    }
}

TEST(JointEccentricity, ComesOncePerTurn) {
  const Motion turns = test::single(721, 10, [](double t) { return -kPi + 10 * t / 360 * 2 * kPi; });
  const AsBuilt robot =
      test::arm_with({effect("joint_eccentricity", 1, {{"amplitude_deg", 0.02}, {"phase_deg", -90}})});
  const Eigen::MatrixXd off = robot.link_angles(turns, {}) - turns.q;
  for (int k = 0; k + 360 < 721; ++k) {
    EXPECT_NEAR(off(0, k), -0.02 / 180 * kPi * std::cos(turns.q(0, k)), 1e-15);
    EXPECT_NEAR(off(0, k), off(0, k + 360), 1e-15);
  }
}

TEST(ThermalGrowth, LengthensTheArmAsItWarms) {
  // The arm's only link ends in the tool, which stays cold; a second joint makes a link of 0.4 m in between.
  const std::string urdf = R"(<robot name="two"><link name="base"/><link name="l1"/><link name="tcp"/>
    <joint name="j1" type="continuous"><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/></joint>
    <joint name="j2" type="continuous"><parent link="l1"/><child link="tcp0"/><origin xyz="0.4 0 0"/><axis xyz="0 1 0"/></joint>
    <link name="tcp0"/><joint name="t" type="fixed"><parent link="tcp0"/><child link="tcp"/><origin xyz="0.2 0 0"/></joint></robot>)";
  const EffectSpec warm = effect("thermal_growth", 1, {{"strain_ppm", 250}, {"time_constant_min", 30}});
  const AsBuilt robot(RobotModel(urdf, "base", "tcp", JointConvention::kSerial), test::with_effects({warm}));
  Motion still{Eigen::VectorXd::LinSpaced(61, 0.0, 600.0), Eigen::MatrixXd::Zero(2, 61)};
  const Eigen::Matrix3Xd points = robot.tool_points(still, {.series_time = 1200});
  for (int k = 0; k <= 60; ++k) {
    const double minutes = 20.0 + k / 6.0;
    const double length = 0.6 + 0.4 * 250e-6 * (1 - std::exp(-minutes / 30));
    EXPECT_LT((points.col(k) - Eigen::Vector3d(length, 0, 0)).norm(), 1e-15) << minutes << " min";
  }
}

TEST(ThermalGrowth, OfUpperArmAndForearmIsThatOfTheMakersLengths) {
  // Upper arm 300 mm, forearm 320 mm along and 75 mm across, shoulder 75 mm, wrist 80 mm to the flange.
  const auto lengths = [](int joint) {
    return std::vector<EffectSpec>{
        effect("thermal_growth", joint, {{"strain_ppm", 1e4}, {"time_constant_min", 0.01}})};
  };
  const auto grown = [](const std::vector<std::pair<std::string, double>>& rows, std::vector<int> joints) {
    std::vector<EffectSpec> all;
    for (std::size_t i = 0; i < rows.size(); ++i)
      all.push_back(effect("link_geometry", joints[i], {{rows[i].first, rows[i].second}}));
    return all;
  };
  const Motion motion = test::swing(20, 10);
  const Conditions warm{.series_time = 3600};
  const auto same = [&](const std::vector<EffectSpec>& a, const std::vector<EffectSpec>& b) {
    return (lrmate_with(a).tool_points(motion, warm) - lrmate_with(b).tool_points(motion, warm)).norm();
  };
  EXPECT_LT(same(lengths(2), grown({{"a_mm", 3.0}}, {3})), 1e-12);
  EXPECT_LT(same(lengths(3), grown({{"a_mm", 0.75}, {"d_mm", 3.2}}, {4, 4})), 1e-12);
  EXPECT_LT(
      same(lengths(0), grown({{"a_mm", 0.75}, {"a_mm", 3.0}, {"a_mm", 0.75}, {"d_mm", 3.2}, {"d_mm", 0.8}},
                             {2, 3, 4, 4, 6})),
      1e-12);
}

TEST(BaseDrift, GoesOnWithTheHours) {
  const Motion motion = test::swing(20, 10);
  const AsBuilt robot = lrmate_with({effect("base_drift", 0, {{"x_um", 12}, {"z_um", -6}})});
  const Eigen::Matrix3Xd moved =
      robot.tool_points(motion, {.series_time = 7200}) - lrmate_with({}).tool_points(motion, {});
  for (int k = 0; k < 20; ++k) {
    const double hours = 2.0 + k / 10.0 / 3600;
    EXPECT_LT((moved.col(k) - Eigen::Vector3d(12e-6, 0, -6e-6) * hours).norm(), 1e-15);
  }
}

}  // namespace
}  // namespace ballbar
