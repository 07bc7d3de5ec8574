// The robots in scripts/robots against Denavit-Hartenberg tables of the makers' numbers, written here once
// more by hand: nothing of them comes from the URDF files.

#include <gtest/gtest.h>

#include <fstream>
#include <random>
#include <sstream>

#include "core/units.hpp"
#include "kinematics/robot_model.hpp"

namespace ballbar {
namespace {

/// One row of a standard (distal) table: Rz(q + theta) Tz(d) Tx(a) Rx(alpha).
struct Row {
  double theta_deg, d_m, a_m, alpha_deg;
};

struct Limit {
  double lower_deg, upper_deg, speed_deg_s;
};

struct Shipped {
  const char* file;
  JointConvention convention;
  double base_roll_deg;  ///< turn of the table's base about X
  Row rows[6];           ///< the last one ends in tool0
  double tcp_m;          ///< from tool0 along its z
  Limit limits[6];       ///< as published, of the chain
  double level_m[3];     ///< tool0 with all joints at 0, from the drawing: x, y, z
};

/// FANUC in angles of the teach pendant (J3 from the horizontal): world at the height of J2, lengths differ
/// per type.
Shipped fanuc(const char* file, double a1, double a2, double a3, double d4, const Limit (&limits)[6]) {
  Shipped robot = {file,
                   JointConvention::kFanuc,
                   0,
                   {{0, 0, a1, -90},
                    {-90, 0, a2, 180},
                    {0, 0, a3, -90},
                    {0, -d4, 0, 90},
                    {0, 0, 0, -90},
                    {0, -0.080, 0, 180}},
                   0.07465,
                   {},
                   {a1 + d4 + 0.080, 0, a2 + a3}};
  std::copy(std::begin(limits), std::end(limits), robot.limits);
  return robot;
}

std::vector<Shipped> shipped() {
  return {
      fanuc("lrmate200ic", 0.075, 0.300, 0.075, 0.320,
            {{-170, 170, 350},
             {-60, 140, 350},
             {-142, 230, 400},
             {-190, 190, 450},
             {-120, 120, 450},
             {-360, 360, 720}}),
      fanuc("lrmate200id", 0.050, 0.330, 0.035, 0.335,
            {{-170, 170, 450},
             {-100, 145, 380},
             {-70, 205, 520},
             {-190, 190, 550},
             {-125, 125, 545},
             {-360, 360, 1000}}),
      fanuc("lrmate200id7l", 0.050, 0.440, 0.035, 0.420,
            {{-170, 170, 370},
             {-100, 145, 310},
             {-70, 213, 410},
             {-190, 190, 550},
             {-125, 125, 545},
             {-360, 360, 1000}}),
      {"ur10",
       JointConvention::kSerial,
       0,
       {{0, 0.1273, 0, 90},
        {0, 0, -0.612, 0},
        {0, 0, -0.5723, 0},
        {0, 0.163941, 0, 90},
        {0, 0.1157, 0, -90},
        {0, 0.0922, 0, 0}},
       0.100,
       {{-360, 360, 120},
        {-360, 360, 120},
        {-360, 360, 180},
        {-360, 360, 180},
        {-360, 360, 180},
        {-360, 360, 180}},
       {-0.612 - 0.5723, -0.163941 - 0.0922, 0.1273 - 0.1157}},
      {"irb120",
       JointConvention::kSerial,
       0,
       {{0, 0.290, 0, -90},
        {-90, 0, 0.270, 0},
        {0, 0, 0.070, -90},
        {0, 0.302, 0, 90},
        {0, 0, 0, -90},
        {180, 0.072, 0, 0}},
       0.07465,
       {{-165, 165, 250},
        {-110, 110, 250},
        {-110, 70, 250},
        {-160, 160, 320},
        {-120, 120, 320},
        {-400, 400, 420}},
       {0.302 + 0.072, 0, 0.290 + 0.270 + 0.070}},
      {"kr300r2500ultra",
       JointConvention::kSerial,
       180,
       {{0, -0.675, 0.350, 90},
        {0, -0.189, 1.150, 0},
        {90, 0.189, 0.041, -90},
        {0, -1.0, 0, 90},
        {0, 0, 0, -90},
        {0, -0.240, 0, 180}},
       0.150,
       {{-147, 147, 105},
        {-140, -5, 101},
        {-112, 153, 107},
        {-350, 350, 122},
        {-122.5, 122.5, 113},
        {-350, 350, 175}},
       {0.350 + 1.150 + 1.0 + 0.240, 0, 0.675 - 0.041}},
  };
}

Eigen::AngleAxisd turn(double radians, const Eigen::Vector3d& axis) { return {radians, axis}; }

/// Pose of tool0 in the maker's base frame by the table.
Eigen::Isometry3d by_table(const Shipped& robot, std::vector<double> q) {
  if (robot.convention == JointConvention::kFanuc)
    q[2] += q[1];  // the table's third angle is between upper arm and forearm
  Eigen::Isometry3d pose(turn(robot.base_roll_deg * kRadPerDeg, Eigen::Vector3d::UnitX()));
  for (std::size_t i = 0; i < 6; ++i) {
    const Row& row = robot.rows[i];
    pose = pose * turn(q[i] + row.theta_deg * kRadPerDeg, Eigen::Vector3d::UnitZ()) *
           Eigen::Translation3d(row.a_m, 0, row.d_m) *
           turn(row.alpha_deg * kRadPerDeg, Eigen::Vector3d::UnitX());
  }
  return pose;
}

RobotModel model_of(const Shipped& robot, const std::string& tip) {
  std::ifstream file(std::string(BALLBAR_SOURCE_DIR "/scripts/robots/") + robot.file + ".urdf");
  std::ostringstream text;
  text << file.rdbuf();
  return RobotModel(text.str(), "base", tip, robot.convention);
}

class ShippedRobots : public ::testing::TestWithParam<Shipped> {};

TEST_P(ShippedRobots, AgreeWithTheMakersDenavitHartenbergTable) {
  const Shipped& robot = GetParam();
  const unsigned seed = 20;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> angle(-kPi, kPi);
  const RobotModel tool0 = model_of(robot, "tool0");
  const RobotModel tcp = model_of(robot, "tcp");
  ASSERT_EQ(tool0.joints(), 6);
  for (int i = 0; i < 1000; ++i) {
    std::vector<double> q(6);
    for (double& v : q) v = angle(random);
    const Eigen::Isometry3d truth = by_table(robot, q);
    const Eigen::Isometry3d pose = tool0.forward(q);
    EXPECT_LT((pose.translation() - truth.translation()).norm(), 1e-9) << "[m]";
    EXPECT_LT((pose.linear() - truth.linear()).norm(), 1e-9);
    EXPECT_LT((tcp.forward(q).translation() - truth * Eigen::Vector3d(0, 0, robot.tcp_m)).norm(), 1e-9)
        << "[m]";
  }
}

TEST_P(ShippedRobots, StandWhereTheDrawingSaysWithAllJointsAtZero) {
  const Shipped& robot = GetParam();
  const Eigen::Vector3d tool0 = model_of(robot, "tool0").forward(std::vector<double>(6, 0.0)).translation();
  EXPECT_LT((tool0 - Eigen::Vector3d(robot.level_m[0], robot.level_m[1], robot.level_m[2])).norm(), 1e-9)
      << tool0;
}

TEST_P(ShippedRobots, HoldThePublishedLimitsAndSpeeds) {
  const Shipped& robot = GetParam();
  const RobotModel model = model_of(robot, "tcp");
  ASSERT_EQ(model.limits().size(), 6u);
  for (std::size_t i = 0; i < 6; ++i) {  // 1e-7 deg: the files have ten decimals of a radian
    EXPECT_NEAR(to_deg(model.limits()[i].lower), robot.limits[i].lower_deg, 1e-7) << "joint " << i + 1;
    EXPECT_NEAR(to_deg(model.limits()[i].upper), robot.limits[i].upper_deg, 1e-7) << "joint " << i + 1;
    EXPECT_NEAR(to_deg(model.limits()[i].velocity), robot.limits[i].speed_deg_s, 1e-7) << "joint " << i + 1;
  }
}

TEST_P(ShippedRobots, HaveTheFlangeWhereTheToolFrameIsWithXOutOfIt) {
  const Shipped& robot = GetParam();
  const std::vector<double> q = {0.3, -0.4, 0.5, -0.6, 0.7, -0.8};
  const Eigen::Isometry3d flange = model_of(robot, "flange").forward(q);
  const Eigen::Isometry3d tool0 = model_of(robot, "tool0").forward(q);
  EXPECT_LT((flange.translation() - tool0.translation()).norm(), 1e-12);
  EXPECT_LT((flange.linear().col(0) - tool0.linear().col(2)).norm(), 1e-12);
}

INSTANTIATE_TEST_SUITE_P(Each, ShippedRobots, ::testing::ValuesIn(shipped()),
                         [](const auto& robot) { return std::string(robot.param.file); });

}  // namespace
}  // namespace ballbar
