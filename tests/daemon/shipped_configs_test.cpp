// The ready configurations in scripts/robots: they load, and their tests can be driven. Inverse kinematics by
// Newton steps with difference quotients, from a posture given here, so that nothing but forward kinematics
// is believed.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <Eigen/SVD>
#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "core/units.hpp"
#include "daemon/config.hpp"
#include "kinematics/robot_model.hpp"

namespace ballbar {
namespace {

namespace fs = std::filesystem;
const fs::path kFolder = BALLBAR_SOURCE_DIR "/scripts/robots";

using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

/// A posture near the tests of each robot, elbow up, tool about straight down [deg].
const std::map<std::string, Vector6d>& start_postures() {
  static const std::map<std::string, Vector6d> postures = {
      {"lrmate200ic", {0, 55, -70, 0, -20, 0}},   {"lrmate200id", {0, 40, -30, 0, -60, 0}},
      {"lrmate200id7l", {0, 40, -30, 0, -60, 0}}, {"ur10", {180, -60, 100, -130, -90, 0}},
      {"irb120", {0, 40, 10, 0, 40, 0}},          {"kr300r2500ultra", {0, -60, 90, 0, 60, 0}},
  };
  return postures;
}

/// One configured robot with its kinematics.
struct Shipped {
  RobotSpec robot;
  RobotModel model;
};

Shipped load(const fs::path& toml) {
  const Config config = load_config(toml.string());
  const RobotSpec& robot = config.robots.at(0);
  return {robot, RobotModel(read_text(robot.urdf_path), robot.base, robot.tip, robot.joint_convention)};
}

std::vector<fs::path> files(const std::string& extension) {
  std::vector<fs::path> found;
  for (const fs::directory_entry& entry : fs::directory_iterator(kFolder))
    if (entry.path().extension() == extension) found.push_back(entry.path());
  std::sort(found.begin(), found.end());
  return found;
}

Eigen::Vector3d vector(const Vec3& v) { return {v[0], v[1], v[2]}; }

Eigen::Isometry3d forward(const RobotModel& model, const Vector6d& q) {
  return model.forward(std::span<const double>(q.data(), 6));
}

/// From one pose to another: metres and the rotation vector in the base frame.
Vector6d difference(const Eigen::Isometry3d& from, const Eigen::Isometry3d& to) {
  const Eigen::AngleAxisd turn(Eigen::Matrix3d(to.linear() * from.linear().transpose()));
  Vector6d d;
  d << to.translation() - from.translation(), turn.angle() * turn.axis();
  return d;
}

Matrix6d jacobian(const RobotModel& model, const Vector6d& q) {
  const double h = 1e-6;
  Matrix6d j;
  for (int i = 0; i < 6; ++i)
    j.col(i) =
        difference(forward(model, q - h * Vector6d::Unit(i)), forward(model, q + h * Vector6d::Unit(i))) /
        (2 * h);
  return j;
}

/// Newton steps of at most 0.1 rad a joint. @return distance that is left
double approach(const RobotModel& model, const Eigen::Isometry3d& target, Vector6d& q) {
  for (int step = 0; step < 200; ++step) {
    const Vector6d error = difference(forward(model, q), target);
    if (error.norm() < 1e-10) break;
    const Vector6d dq = jacobian(model, q).fullPivLu().solve(error);
    q += dq * std::min(1.0, 0.1 / dq.cwiseAbs().maxCoeff());
  }
  return difference(forward(model, q), target).norm();
}

/// Points of a test, 1 degree or a hundredth of the line apart, with the way between them [m].
std::vector<Eigen::Vector3d> path_of(const TestSpec& test, double& step_m) {
  std::vector<Eigen::Vector3d> path;
  if (test.kind == TestKind::kLine) {
    const Eigen::Vector3d a = vector(test.line.start), b = vector(test.line.end);
    for (int i = 0; i <= 100; ++i) path.push_back(a + (b - a) * i / 100.0);
  } else {
    const CircleSpec& c = test.circle;
    const Eigen::Vector3d e1 = vector(c.first_axis), e2 = vector(c.normal).cross(e1);
    for (int i = 0; i <= 360; ++i)
      path.push_back(vector(c.centre) +
                     c.radius * (std::cos(i * kRadPerDeg) * e1 + std::sin(i * kRadPerDeg) * e2));
  }
  step_m = (path[1] - path[0]).norm();
  return path;
}

/// Angle to the nearest limit of the chain over all joints; negative = outside [rad].
double room(const RobotModel& model, Vector6d q) {
  model.to_chain(std::span<double>(q.data(), 6));
  double least = 1e9;
  for (int i = 0; i < 6; ++i) {
    const JointLimit& limit = model.limits()[static_cast<std::size_t>(i)];
    least = std::min({least, q(i) - limit.lower, limit.upper - q(i)});
  }
  return least;
}

/// How far from a singularity: smallest singular value, with lengths in units of the distance from the base.
double dexterity(const RobotModel& model, const Vector6d& q) {
  Matrix6d j = jacobian(model, q);
  j.topRows<3>() /= forward(model, q).translation().norm();
  return j.jacobiSvd().singularValues()(5);
}

TEST(ShippedConfigs, LoadAndNameARobotThatIsThere) {
  const std::vector<fs::path> tomls = files(".toml");
  EXPECT_EQ(tomls.size(), start_postures().size());
  std::set<std::string> names;
  for (const fs::path& toml : tomls) {
    SCOPED_TRACE(toml.filename().string());
    const Shipped shipped = load(toml);
    EXPECT_EQ(fs::path(shipped.robot.urdf_path).stem(), toml.stem());
    EXPECT_EQ(shipped.model.joints(), 6);
    EXPECT_EQ(shipped.robot.gear_ratio.size(), 6u);
    EXPECT_TRUE(names.insert(shipped.robot.name).second) << "robots must go into one configuration together";
    std::vector<std::string> tests;
    for (const TestSpec& test : shipped.robot.tests) tests.push_back(test.name);
    EXPECT_EQ(tests, (std::vector<std::string>{"A", "B", "Y"}));
    const bool fanuc = toml.stem().string().starts_with("lrmate");
    EXPECT_EQ(shipped.robot.joint_convention, fanuc ? JointConvention::kFanuc : JointConvention::kSerial);
  }
  for (const fs::path& urdf : files(".urdf"))
    EXPECT_TRUE(fs::exists(fs::path(urdf).replace_extension(".toml"))) << urdf << " has no configuration";
}

TEST(ShippedConfigs, HaveTestsThatTheRobotCanDrive) {
  for (const auto& [name, posture_deg] : start_postures()) {
    const Shipped shipped = load(kFolder / (name + ".toml"));
    const RobotModel& model = shipped.model;
    for (const TestSpec& test : shipped.robot.tests) {
      SCOPED_TRACE(name + " " + test.name);
      double step_m = 0.0;
      const std::vector<Eigen::Vector3d> path = path_of(test, step_m);
      const Eigen::Vector3d rpy = vector(test.tool_rpy.value());
      Eigen::Isometry3d target(Eigen::AngleAxisd(rpy.z(), Eigen::Vector3d::UnitZ()) *
                               Eigen::AngleAxisd(rpy.y(), Eigen::Vector3d::UnitY()) *
                               Eigen::AngleAxisd(rpy.x(), Eigen::Vector3d::UnitX()));
      EXPECT_LT((target.linear().col(2) + Eigen::Vector3d::UnitZ()).norm(), 1e-12)
          << "the tool points straight down";
      Vector6d q = posture_deg * kRadPerDeg;
      target.translation() = path[0];
      approach(model, target, q);
      double least_room = 1e9, least_dexterity = 1e9, most_speed = 0.0;
      for (const Eigen::Vector3d& point : path) {
        target.translation() = point;
        const Vector6d before = q;
        ASSERT_LT(approach(model, target, q), 1e-9) << "no joint angles for " << point.transpose() << " m";
        least_room = std::min(least_room, room(model, q));
        least_dexterity = std::min(least_dexterity, dexterity(model, q));
        for (int i = 0; i < 6; ++i)
          most_speed = std::max(most_speed, std::abs(q(i) - before(i)) * test.feed / step_m /
                                                model.limits()[static_cast<std::size_t>(i)].velocity);
      }
      EXPECT_GT(to_deg(least_room), 5.0) << "[deg] to the nearest joint limit";
      // The tests of the LR Mate 200iC are the paper's: its line Y comes to 0.051, where the wrist is nearly
      // straight.
      EXPECT_GT(least_dexterity, name == "lrmate200ic" ? 0.05 : 0.1) << "away from singularities";
      EXPECT_LT(most_speed, 0.5) << "of the joints' greatest speed";
    }
  }
}

}  // namespace
}  // namespace ballbar
