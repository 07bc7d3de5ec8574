// Nominal kinematics against figures that were computed elsewhere, and an independent formulation.

#include "kinematics/robot_model.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <random>
#include <sstream>

#include "core/error.hpp"
#include "core/units.hpp"
#include "kinematics/robots.hpp"

namespace ballbar {
namespace {

using test::lrmate;
using test::lrmate_model;
using test::radians;

/// Standard DH of the LR Mate 200iC in teach-pendant angles (metrology.md 3), tool point 74.65 mm before the
/// flange.
Eigen::Vector3d dh_tool_point(const std::vector<double>& tp) {
  const double deg90 = kPi / 2;
  const struct {
    double theta, d, a, alpha;
  } rows[] = {{tp[0], 0, 0.075, -deg90}, {tp[1] - deg90, 0, 0.3, kPi}, {tp[1] + tp[2], 0, 0.075, -deg90},
              {tp[3], -0.320, 0, deg90}, {tp[4], 0, 0, -deg90},        {tp[5], -0.080, 0, kPi}};
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  for (const auto& row : rows)
    pose = pose * Eigen::AngleAxisd(row.theta, Eigen::Vector3d::UnitZ()) *
           Eigen::Translation3d(row.a, 0, row.d) * Eigen::AngleAxisd(row.alpha, Eigen::Vector3d::UnitX());
  return pose * Eigen::Vector3d(0, 0, 0.07465);
}

TEST(RobotModel, PutsTheToolPointWhereTheReferenceFiguresSay) {
  const RobotModel model = lrmate_model();
  const struct {
    std::vector<double> tp_deg;
    Eigen::Vector3d tcp_mm;
  } table[] = {
      {{0, 0, 0, 0, 0, 0}, {549.65, 0, 375}},
      {{0, 0, 0, 0, -90, 0}, {395, 0, 220.35}},
      {{30, 20, -10, 40, -50, 60}, {547.2167, 228.0050, 193.5655}},
      {{-40.1, 50, -70, 0, -20, 40.1}, {370.7855, -312.2304, -236.8638}},
  };
  for (const auto& row : table) {
    const Eigen::Vector3d tcp = model.forward(radians(row.tp_deg)).translation() * 1e3;
    EXPECT_LT((tcp - row.tcp_mm).norm(), 1e-4) << "the figures have four decimals [mm]";
  }
}

TEST(RobotModel, AgreesWithDenavitHartenberg) {
  const unsigned seed = 7;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  std::uniform_real_distribution<double> angle(-2.0, 2.0);
  const RobotModel model = lrmate_model();
  for (int i = 0; i < 1000; ++i) {
    std::vector<double> q(6);
    for (double& v : q) v = angle(random);
    EXPECT_LT((model.forward(q).translation() - dh_tool_point(q)).norm(),
              2e-12);  // rounding at 1 m, and rpy of the file
  }
}

TEST(RobotModel, GivesTheNominalPathOfCircleB) {
  const std::string path = BALLBAR_SHARED_DIR "/data/oracles/circle_B_table1.csv";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no oracle " << path;
  std::ifstream file(path);
  std::string line;
  std::getline(file, line);
  const RobotModel model = lrmate_model();
  int rows = 0;
  while (std::getline(file, line)) {
    std::replace(line.begin(), line.end(), ',', ' ');
    std::istringstream words(line);
    double degrees = 0;
    std::vector<double> q(6);
    Eigen::Vector3d tcp_mm;
    words >> degrees;
    for (double& v : q) words >> v;
    for (int i = 0; i < 3; ++i) words >> tcp_mm(i);
    ASSERT_TRUE(words) << line;
    EXPECT_LT((model.forward(radians(q)).translation() * 1e3 - tcp_mm).norm(), 2e-6) << "row " << line;
    ++rows;
  }
  EXPECT_EQ(rows, 72);
}

TEST(RobotModel, TheConventionsDifferByTheCouplingOfJ2AndJ3) {
  const RobotModel fanuc = lrmate_model(JointConvention::kFanuc);
  const RobotModel serial = lrmate_model(JointConvention::kSerial);
  const std::vector<double> tp = radians({10, 20, -30, 40, -50, 60});
  std::vector<double> chain = tp;
  chain[2] += chain[1];
  EXPECT_EQ(fanuc.forward(tp).matrix(), serial.forward(chain).matrix());
}

TEST(RobotModel, KnowsTheLimitsOfTheUrdf) {
  const RobotModel model = lrmate_model();
  ASSERT_EQ(model.joints(), 6);
  EXPECT_NEAR(to_deg(model.limits()[1].lower), -60.0, 0.01);
  EXPECT_NEAR(to_deg(model.limits()[1].upper), 140.0, 0.01);
  EXPECT_EQ(model.limits()[0].name, "joint_1");
}

TEST(RobotModel, MeasuresFromAnyFixedBaseOfTheTree) {
  const std::vector<double> q = radians({10, 20, -30, 40, -50, 60});
  const RobotModel world = lrmate_model();
  const RobotModel floor(lrmate(), "base_link", "tcp", JointConvention::kFanuc);
  const Eigen::Vector3d difference = floor.forward(q).translation() - world.forward(q).translation();
  EXPECT_LT((difference - Eigen::Vector3d(0, 0, 0.330)).norm(), 1e-12);
}

/// What the model says of a URDF; "no error" where it takes it.
std::string complaint(const std::string& urdf, const std::string& base, const std::string& tip,
                      JointConvention convention = JointConvention::kSerial) {
  try {
    RobotModel(urdf, base, tip, convention);
  } catch (const Error& error) {
    EXPECT_EQ(error.cause(), Cause::kInput);
    EXPECT_EQ(std::string(error.what()).find('\n'), std::string::npos) << "an error is one line";
    return error.what();
  }
  return "no error";
}

std::string replaced(std::string text, const std::string& from, const std::string& to) {
  const std::size_t at = text.find(from);
  EXPECT_NE(at, std::string::npos) << from;
  return text.replace(at, from.size(), to);
}

TEST(RobotModel, SaysWhatIsWrongWithAUrdf) {
  const auto says = [](const std::string& message, const std::string& part) {
    return message.find(part) != std::string::npos
               ? testing::AssertionSuccess()
               : testing::AssertionFailure() << message << " lacks " << part;
  };
  EXPECT_EQ(complaint(lrmate(), "base", "tcp"), "no error");
  EXPECT_TRUE(says(complaint("<robot", "base", "tcp"), "cannot be read"));
  EXPECT_TRUE(says(complaint(lrmate(), "nowhere", "tcp"), "no link 'nowhere'"));
  EXPECT_TRUE(says(complaint(lrmate(), "base", "flansch"), "no link 'flansch'"));
#ifndef __SANITIZE_ADDRESS__  // urdfdom never gives such a ring's memory back
  const std::string ring =
      "<robot name='r'><link name='base'/><link name='a'/><link name='b'/>"
      "<joint name='j1' type='fixed'><parent link='a'/><child link='b'/></joint>"
      "<joint name='j2' type='fixed'><parent link='b'/><child link='a'/></joint></robot>";
  EXPECT_TRUE(says(complaint(ring, "base", "b"), "form a ring"));
#endif
  EXPECT_TRUE(says(complaint(lrmate(), "flange", "tcp"), "no joint moves"));
  EXPECT_TRUE(says(complaint(lrmate(), "tcp", "base"), "moves with joint"));
  EXPECT_TRUE(says(complaint(replaced(lrmate(), "<link name=\"link_4\"/>", ""), "base", "tcp"), "link_4"));
  EXPECT_TRUE(says(complaint(replaced(lrmate(), "lower=\"-1.0471975512\"", "lower=\"nan\""), "base", "tcp"),
                   "joint_2"));
  EXPECT_TRUE(says(complaint(replaced(lrmate(), "lower=\"-1.0471975512\"", "lower=\"1e999\""), "base", "tcp"),
                   "joint_2"));
  EXPECT_TRUE(says(complaint(replaced(lrmate(), "lower=\"-1.0471975512\"", "lower=\"2.5\""), "base", "tcp"),
                   "joint_2"));
  EXPECT_TRUE(
      says(complaint(replaced(lrmate(), "<axis xyz=\"0 -1 0\"/>", "<axis xyz=\"0 0 0\"/>"), "base", "tcp"),
           "joint_3"));
  EXPECT_TRUE(says(complaint(replaced(lrmate(), "type=\"revolute\"", "type=\"prismatic\""), "base", "tcp"),
                   "joint_1"));
  EXPECT_TRUE(
      says(complaint(replaced(lrmate(), "<mass value=\"5.5\"/>", "<mass value=\"-5.5\"/>"), "base", "tcp"),
           "link_2"));
  for (const char* mass :
       {"<mass value=\"nan\"/>", "<mass value=\"1e999\"/>", "<mass value=\"5,5\"/>", "<mass/>", ""})
    EXPECT_TRUE(says(complaint(replaced(lrmate(), "<mass value=\"5.5\"/>", mass), "base", "tcp"), "link_2"))
        << "a link must not lose its mass in silence: " << mass;
}

TEST(RobotModel, RefusesAConventionThatDoesNotFit) {
  const std::string fanuc_like = lrmate();
  EXPECT_EQ(complaint(fanuc_like, "base", "tcp", JointConvention::kFanuc), "no error");
  const std::string same_sense = replaced(lrmate(), "<axis xyz=\"0 -1 0\"/>", "<axis xyz=\"0 1 0\"/>");
  EXPECT_NE(complaint(same_sense, "base", "tcp", JointConvention::kFanuc).find("'joint_2' and 'joint_3'"),
            std::string::npos);
  EXPECT_EQ(complaint(same_sense, "base", "tcp", JointConvention::kSerial), "no error");
  EXPECT_NE(complaint(lrmate(), "base", "link_2", JointConvention::kFanuc).find("at least 3"),
            std::string::npos);
}

TEST(RobotModel, TurnsItsAnglesIntoTheChainsAndBack) {
  const RobotModel model = lrmate_model();
  std::vector<double> q = radians({10, 20, -30, 40, -50, 60});
  model.to_chain(q);
  EXPECT_NEAR(q[2], radians({-10})[0], 1e-15);
  model.from_chain(q);
  EXPECT_NEAR(q[2], radians({-30})[0], 1e-15);
}

TEST(RobotModel, TheJacobianIsTheSlopeOfForwardInTheRobotsOwnAngles) {
  const RobotModel model = lrmate_model();
  const std::vector<double> q = radians({10, 40, -60, 20, -50, 60});
  const Jacobian jacobian = model.jacobian(q);
  const double h = 1e-5;
  for (std::size_t i = 0; i < 6; ++i) {
    std::vector<double> more = q, less = q;
    more[i] += h;
    less[i] -= h;
    const Eigen::Isometry3d a = model.forward(less), b = model.forward(more);
    const Eigen::Vector3d linear = (b.translation() - a.translation()) / (2 * h);
    const Eigen::AngleAxisd turn(Eigen::Matrix3d(b.linear() * a.linear().transpose()));
    const Eigen::Vector3d angular = turn.angle() * turn.axis() / (2 * h);
    EXPECT_LT((jacobian.col(static_cast<int>(i)).head<3>() - linear).norm(), 1e-9) << "joint " << i + 1;
    EXPECT_LT((jacobian.col(static_cast<int>(i)).tail<3>() - angular).norm(), 1e-6) << "joint " << i + 1;
  }
}

TEST(RobotModel, HangsAPayloadOnlyOnWhatMovesWithTheToolPoint) {
  const RobotModel model = lrmate_model();
  const Body payload = model.payload(0.438, {0, 0, 0.050}, "tool0");
  EXPECT_EQ(payload.joint, 6);
  // The flange lies 80 mm and the mass 130 mm in front of the wrist; the table's last frame sits on the
  // flange.
  EXPECT_NEAR(payload.com.norm(), 0.050, 1e-12);
  EXPECT_THROW(model.payload(0.438, {0, 0, 0.050}, "link_5"), Error);
  EXPECT_THROW(model.payload(0.438, {0, 0, 0.050}, "no_such_link"), Error);
}

TEST(RobotModel, RefusesWhatIsNoJointVector) {
  const RobotModel model = lrmate_model();
  EXPECT_THROW(model.forward(std::vector<double>(5, 0.0)), std::invalid_argument);
  EXPECT_THROW(model.forward(std::vector<double>(6, std::nan(""))), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
