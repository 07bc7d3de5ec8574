// Inverse kinematics against printed figures, the oracle of the paper's circle, and forward kinematics.

#include "kinematics/inverse.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>

#include "kinematics/robots.hpp"

namespace ballbar {
namespace {

constexpr Vec3 kDown{kPi, 0, 0};

struct OracleRow {
  double angle_deg;
  std::vector<double> joints_deg;
  Eigen::Vector3d nominal_mm, as_built_mm;
};

std::vector<OracleRow> oracle_rows() {
  std::ifstream file(BALLBAR_SHARED_DIR "/data/oracles/circle_B_table1.csv");
  std::string line;
  std::getline(file, line);
  std::vector<OracleRow> rows;
  while (std::getline(file, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    OracleRow row{0, std::vector<double>(6), {}, {}};
    words >> row.angle_deg;
    for (double& v : row.joints_deg) words >> v;
    for (int i = 0; i < 3; ++i) words >> row.nominal_mm(i);
    for (int i = 0; i < 3; ++i) words >> row.as_built_mm(i);
    if (words) rows.push_back(row);
  }
  return rows;
}

/// Table 1 of the paper.
ChainDeviation table_1() {
  ChainDeviation deviation;
  for (const double degrees : {1.2, 2.3, -1.5, -3.2, -2.8, 0.9})
    deviation.links.push_back({.zero_offset = degrees * kRadPerDeg});
  return deviation;
}

std::vector<Eigen::Isometry3d> circle(const Vec3& centre, int poses) {
  std::vector<Eigen::Isometry3d> path;
  for (int i = 0; i < poses; ++i) {
    const double t = 2 * kPi * i / poses;
    path.push_back(
        tool_pose({centre[0] + 0.1 * std::cos(t), centre[1] + 0.1 * std::sin(t), centre[2]}, kDown));
  }
  return path;
}

TEST(Inverse, GivesThePrintedAnglesOfTheToolStraightDown) {  // metrology.md 3; B is the mirror image of A
  const RobotModel model = test::lrmate_model();
  const struct {
    Vec3 position;
    std::vector<double> tp_deg;
  } table[] = {
      {{0.480, -0.320, -0.251}, {-33.6901, 63.3312, -57.8450, 0, -32.1550, 33.6901}},
      {{0.380, -0.220, -0.251}, {-30.0686, 48.0483, -77.7909, 0, -12.2091, 30.0686}},
      {{0.280, -0.320, -0.251}, {-48.8141, 46.8933, -79.6671, 0, -10.3329, 48.8141}},
      {{0.380, -0.420, -0.251}, {-47.8624, 61.8613, -59.5446, 0, -30.4554, 47.8624}},
  };
  for (const auto& row : table)
    for (const double mirror : {1.0, -1.0}) {
      const IkResult found =
          inverse(model, tool_pose({row.position[0], mirror * row.position[1], row.position[2]}, kDown));
      ASSERT_EQ(found.status, IkStatus::kOk);
      EXPECT_GT(found.smallest_singular_value, 0.05);
      for (std::size_t i = 0; i < 6; ++i)
        EXPECT_NEAR(to_deg(found.q[i]), (i == 0 || i == 5 ? mirror : 1.0) * row.tp_deg[i], 5.1e-5)
            << "J" << i + 1;
    }
}

TEST(Inverse, GivesTheOraclesJointsOnAPathAndTheRobotOfTable1ItsPoints) {
  const std::vector<OracleRow> rows = oracle_rows();
  if (rows.empty()) GTEST_SKIP() << "no oracle circle_B_table1.csv";
  ASSERT_EQ(rows.size(), 72U);
  const RobotModel model = test::lrmate_model();
  const PathResult path = solve_path(model, circle({0.380, 0.320, -0.251}, 72));
  ASSERT_EQ(path.status, IkStatus::kOk);
  for (std::size_t i = 0; i < rows.size(); ++i) {
    SCOPED_TRACE("row " + std::to_string(i));
    const Eigen::VectorXd q = path.q.col(static_cast<int>(i));
    for (int j = 0; j < 6; ++j)
      EXPECT_NEAR(to_deg(q(j)), rows[i].joints_deg[static_cast<std::size_t>(j)], 1e-8);
    const std::span<const double> angles(q.data(), 6);
    EXPECT_LT((model.forward(angles).translation() * 1e3 - rows[i].nominal_mm).norm(), 1e-7);
    EXPECT_LT((model.forward(angles, table_1()).translation() * 1e3 - rows[i].as_built_mm).norm(), 1e-7);
  }
}

TEST(Inverse, TakesTheConfigurationThatTheReferenceIsNearTo) {
  const RobotModel model = test::lrmate_model();
  const Eigen::Isometry3d pose = tool_pose({0.480, -0.320, -0.251}, kDown);
  const IkResult flipped = inverse(model, pose, test::radians({-33, 63, -58, 180, 32, -146}));
  ASSERT_EQ(flipped.status, IkStatus::kOk);
  const double fut_deg[] = {-33.6901, 63.3312, -57.8450,
                            180,      32.1550, -146.3099};  // the same arm, the wrist turned over
  for (std::size_t i = 0; i < 6; ++i) EXPECT_NEAR(to_deg(flipped.q[i]), fut_deg[i], 5.1e-5) << "J" << i + 1;
}

TEST(Inverse, ReachesEveryPoseThatForwardGives) {
  std::vector<RobotModel> models;
  models.push_back(test::lrmate_model());
  const std::string ur10 = BALLBAR_SHARED_DIR "/data/ipa_ur10/ur10.urdf";
  if (std::filesystem::exists(ur10))
    models.emplace_back(test::text_of(ur10), "base", "tool0", JointConvention::kSerial);
  std::mt19937_64 random(17);
  SCOPED_TRACE("random 17");
  for (const RobotModel& model : models) {
    int reached = 0;
    for (int k = 0; k < 40; ++k) {
      std::vector<double> q = test::random_angles(random, 6, 1.0);
      q[1] = std::abs(q[1]);
      const Eigen::Isometry3d pose = model.forward(q);
      const IkResult found = inverse(model, pose);
      ASSERT_NE(found.status, IkStatus::kUnreachable) << k;
      reached += found.status == IkStatus::kOk;
      const Eigen::Isometry3d back = model.forward(found.q);
      EXPECT_LT((back.translation() - pose.translation()).norm(), 1e-9);
      // The sine of the angle between the two, without a formula that the solver uses.
      EXPECT_LT((back.linear() - pose.linear()).norm(), 1e-9);
      // The answer may be another one, but never farther from the reference than the one that is known.
      std::vector<double> known = q, chosen = found.q;
      model.to_chain(known);
      model.to_chain(chosen);
      const auto square = [](const std::vector<double>& v) {
        double sum = 0;
        for (const double x : v) sum += x * x;
        return sum;
      };
      EXPECT_LE(square(chosen), square(known) + 1e-9) << k;
    }
    EXPECT_GE(reached, 38);
  }
}

TEST(Inverse, IsExactWhereKdlsOwnDifferenceIsBlind) {
  const RobotModel model = test::lrmate_model();
  std::vector<double> seed = test::radians({-33, 63, -58, 5, -32, 33});
  const Eigen::Isometry3d start = model.forward(seed);
  for (const double angle : {3e-7, 3e-8, 3e-9}) {
    Eigen::Isometry3d pose = start;
    pose.linear() =
        Eigen::AngleAxisd(angle, Eigen::Vector3d(1, 2, 2) / 3).toRotationMatrix() * start.linear();
    const IkResult found = inverse_near(model, pose, seed);
    ASSERT_EQ(found.status, IkStatus::kOk);
    EXPECT_LT((model.forward(found.q).linear() - pose.linear()).norm(), 0.01 * angle + 1e-15);
  }
}

TEST(Inverse, WorksForArmsWithMoreAndWithFewerJointsThanSix) {
  std::mt19937_64 random(19);
  for (const int joints : {4, 7}) {
    SCOPED_TRACE(std::to_string(joints) + " joints, random 19");
    const RobotModel model(test::crooked_robot(9, joints, 0), "l0", "tip", JointConvention::kSerial);
    const std::vector<double> q = test::random_angles(random, joints, 1.0);
    std::vector<double> seed = q;
    for (double& v : seed) v += 0.05;
    const IkResult found = inverse_near(model, model.forward(q), seed);
    ASSERT_EQ(found.status, IkStatus::kOk);
    EXPECT_LT((model.forward(found.q).matrix() - model.forward(q).matrix()).norm(), 1e-8);
  }
}

TEST(Inverse, SaysWhyThereIsNoAnswer) {
  const RobotModel model = test::lrmate_model();
  EXPECT_EQ(inverse(model, tool_pose({2.0, 0, 0}, kDown)).status, IkStatus::kUnreachable);
  EXPECT_GT(inverse(model, tool_pose({2.0, 0, 0}, kDown)).position_error, 0.5);

  const std::vector<double> past_j5 = test::radians({0, 10, 0, 0, 125, 0});
  const IkResult limit = inverse_near(model, model.forward(past_j5), past_j5);
  EXPECT_EQ(limit.status, IkStatus::kLimit);
  EXPECT_EQ(limit.joint, 5);

  // Limits are those of the chain: J3 of 235 deg there is 95 deg on the teach pendant at J2 = 140 deg.
  const std::vector<double> past_j3 = test::radians({0, 139, 95, 0, 30, 0});
  EXPECT_EQ(inverse_near(model, model.forward(past_j3), past_j3).joint, 3);

  const std::vector<double> straight_wrist = test::radians({0, 20, -30, 0, 0, 0});
  const IkResult singular = inverse_near(model, model.forward(straight_wrist), straight_wrist);
  EXPECT_EQ(singular.status, IkStatus::kSingular);
  EXPECT_LT(singular.smallest_singular_value, 1e-6);
  EXPECT_LT(singular.position_error, 1e-9);
}

TEST(Inverse, RefusesWhatIsNoJointVector) {
  const RobotModel model = test::lrmate_model();
  const Eigen::Isometry3d pose = tool_pose({0.48, -0.32, -0.251}, kDown);
  EXPECT_THROW(inverse(model, pose, std::vector<double>(5, 0.0)), std::invalid_argument);
  EXPECT_THROW(inverse_near(model, pose, std::vector<double>(6, std::nan(""))), std::invalid_argument);
  EXPECT_THROW(inverse_near(model, tool_pose({std::nan(""), 0, 0}, kDown), std::vector<double>(6, 0.1)),
               std::invalid_argument);
}

TEST(Path, StaysInOneConfigurationAndMovesSmoothly) {
  const RobotModel model = test::lrmate_model();
  const PathResult path = solve_path(model, circle({0.380, -0.320, -0.251}, 360));
  ASSERT_EQ(path.status, IkStatus::kOk);
  EXPECT_EQ(path.index, -1);
  EXPECT_GT(path.smallest_singular_value, 0.05);
  EXPECT_LT((path.q.rightCols(359) - path.q.leftCols(359)).cwiseAbs().maxCoeff(), 0.02);
  EXPECT_LT(path.q.row(3).cwiseAbs().maxCoeff(), 1e-9) << "J4 stands still";
  EXPECT_NEAR(to_deg(path.q.row(4).maxCoeff()), -6.5, 0.05);  // metrology.md 3
  EXPECT_NEAR(to_deg(path.q.row(4).minCoeff()), -35.5, 0.05);
}

TEST(Path, NamesThePoseAndTheJointThatMeetsItsLimit) {
  const RobotModel model = test::lrmate_model();
  std::vector<Eigen::Isometry3d> poses;
  for (int degrees = 150; degrees <= 180; ++degrees) {
    const double t = degrees * kRadPerDeg;
    poses.push_back(tool_pose({0.45 * std::cos(t), 0.45 * std::sin(t), -0.1}, {kPi, 0, t}));
  }
  const PathResult path = solve_path(model, poses);
  EXPECT_EQ(path.status, IkStatus::kLimit);
  EXPECT_EQ(path.joint, 1);
  EXPECT_EQ(path.index, 171 - 150) << "J1 goes to 170 deg";
}

TEST(Path, NamesThePoseThatIsOutOfReach) {
  const RobotModel model = test::lrmate_model();
  std::vector<Eigen::Isometry3d> poses;
  int first_out = -1;
  for (int i = 0; i < 60; ++i) {
    const double x = 0.45 + 0.005 * i;
    poses.push_back(tool_pose({x, 0.1, -0.1}, kDown));
    // Wrist above the tool point; upper arm 300, forearm 320 with 75 across; J2 stands 75 from J1's axis.
    const double reach = std::hypot(std::hypot(x, 0.1) - 0.075, -0.1 + 0.08 + 0.07465);
    if (first_out < 0 && reach > 0.300 + std::hypot(0.320, 0.075)) first_out = i;
  }
  ASSERT_GT(first_out, 0);
  const PathResult path = solve_path(model, poses);
  EXPECT_EQ(path.status, IkStatus::kUnreachable);
  EXPECT_EQ(path.index, first_out);
}

TEST(Path, NamesThePoseWhereTheWristStandsStraight) {
  const RobotModel model = test::lrmate_model();
  // The forearm points straight down: J5 = 0 with the tool down. The line runs through that point, then 0.2
  // mm beside it.
  const Eigen::Vector3d middle = model.forward(test::radians({0, 40, -90, 0, 0, 0})).translation();
  for (const double beside : {0.0, 0.0002}) {
    std::vector<Eigen::Isometry3d> poses;
    for (int i = -20; i <= 20; ++i)
      poses.push_back(tool_pose({middle.x() - 0.002 * i, middle.y() + beside, middle.z()}, kDown));
    const PathResult path = solve_path(model, poses);
    EXPECT_EQ(path.status, IkStatus::kSingular);
    EXPECT_NEAR(path.index, 20, 1);
  }
}

TEST(ToolPose, TurnsAboutTheFixedAxesInTheOrderXYZ) {
  const Eigen::Isometry3d pose = tool_pose({1, 2, 3}, {0.1, -0.2, 0.3});
  for (const Eigen::Vector3d& v :
       {Eigen::Vector3d(1, 0, 0), Eigen::Vector3d(0, 1, 0), Eigen::Vector3d(0, 0, 1)}) {
    Eigen::Vector3d u = v;
    u = {u.x(), u.y() * std::cos(0.1) - u.z() * std::sin(0.1), u.y() * std::sin(0.1) + u.z() * std::cos(0.1)};
    u = {u.x() * std::cos(-0.2) + u.z() * std::sin(-0.2), u.y(),
         -u.x() * std::sin(-0.2) + u.z() * std::cos(-0.2)};
    u = {u.x() * std::cos(0.3) - u.y() * std::sin(0.3), u.x() * std::sin(0.3) + u.y() * std::cos(0.3), u.z()};
    EXPECT_LT((pose.linear() * v - u).norm(), 1e-15);
  }
  EXPECT_EQ(pose.translation(), Eigen::Vector3d(1, 2, 3));
}

TEST(RotationBetween, IsRightFromNothingToHalfATurn) {
  const Eigen::Vector3d axis = Eigen::Vector3d(2, -1, 2) / 3;
  const Eigen::Matrix3d from = Eigen::AngleAxisd(0.7, Eigen::Vector3d(1, 0, 0)).toRotationMatrix();
  for (const double angle : {0.0, 1e-12, 1e-9, 1e-6, 1e-3, 1.0, 3.0, 3.1415}) {
    const Eigen::Matrix3d to = Eigen::AngleAxisd(angle, axis).toRotationMatrix() * from;
    EXPECT_LT((rotation_between(from, to) - angle * axis).norm(), 1e-14 + 1e-12 * angle) << angle;
  }
}

}  // namespace
}  // namespace ballbar
