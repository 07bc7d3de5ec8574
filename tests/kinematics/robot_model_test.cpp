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

namespace ballbar {
namespace {

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

const std::string& lrmate() {
  static const std::string text = text_of(BALLBAR_SOURCE_DIR "/scripts/robots/lrmate200ic.urdf");
  return text;
}

RobotModel lrmate_model(JointConvention convention = JointConvention::kFanuc) {
  return RobotModel(lrmate(), "base", "tcp", convention);
}

std::vector<double> radians(std::vector<double> degrees) {
  for (double& d : degrees) d *= kRadPerDeg;
  return degrees;
}

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

TEST(RobotModel, SaysWhatIsWrongWithAUrdf) {
  const auto message = [](const std::string& urdf, const std::string& base,
                          const std::string& tip) -> std::string {
    try {
      RobotModel(urdf, base, tip, JointConvention::kSerial);
    } catch (const Error& error) {
      return error.what();
    }
    return "no error";
  };
  EXPECT_NE(message("<robot", "base", "tcp").find("cannot be read"), std::string::npos);
  EXPECT_NE(message(lrmate(), "nowhere", "tcp").find("no link 'nowhere'"), std::string::npos);
  EXPECT_NE(message(lrmate(), "base", "flansch").find("no link 'flansch'"), std::string::npos);
  EXPECT_NE(message(lrmate(), "flange", "tcp").find("no joint moves"), std::string::npos);
  EXPECT_NE(message(lrmate(), "tcp", "base").find("moves with joint"), std::string::npos);
}

TEST(RobotModel, RefusesWhatIsNoJointVector) {
  const RobotModel model = lrmate_model();
  EXPECT_THROW(model.forward(std::vector<double>(5, 0.0)), std::invalid_argument);
  EXPECT_THROW(model.forward(std::vector<double>(6, std::nan(""))), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
