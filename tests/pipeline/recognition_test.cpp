// JOINTS without marks against the configured circles: a planar arm, an LR Mate, and a day's work of a KUKA
// that drives no circle at all.

#include "pipeline/recognition.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

#include "core/units.hpp"
#include "kinematics/inverse.hpp"
#include "support/planar_cell.hpp"

namespace ballbar {
namespace {

using test::PlanarCircle;

std::string text_of(const std::string& path) {
  std::ifstream file(path);
  std::ostringstream text;
  text << file.rdbuf();
  return text.str();
}

std::vector<RecognisedCircle> play(Recogniser& recogniser, const ballbar::Run& run) {
  std::vector<RecognisedCircle> found;
  const auto joints = static_cast<std::size_t>(run.joints);
  for (std::size_t i = 0; i < run.joint_time.size(); ++i)
    recogniser.take(run.started_us + std::llround(run.joint_time[i] * 1e6),
                    std::span(run.joint_position).subspan(i * joints, joints), found);
  recogniser.end_path(found);
  return found;
}

TEST(Recognition, TheMarksOfAPlanarArmAreNotMissed) {
  const RobotModel model(test::kPlanarUrdf, "base", "tcp", JointConvention::kSerial);
  for (const double sweep : {90.0, 220.0, 360.0})
    for (const int direction : {1, -1}) {
      PlanarCircle circle;
      circle.arc_start_deg = -30.0;
      circle.arc_sweep_deg = sweep;
      circle.overshoot_deg = 20.0;
      circle.direction = direction;
      RobotSpec robot;
      TestSpec line;
      line.kind = TestKind::kLine;
      robot.tests = {line, test::planar_test(circle)};
      const std::unique_ptr<Recogniser> recogniser = make_recogniser(robot, model);
      const ballbar::Run run = test::planar_run(circle);
      const std::vector<RecognisedCircle> found = play(*recogniser, run);
      ASSERT_EQ(found.size(), 1u);
      EXPECT_EQ(found[0].test, 1u) << "counted among all tests of the robot";
      EXPECT_EQ(found[0].direction, direction);
      EXPECT_NEAR(found[0].feed, circle.feed, 1e-5);
      EXPECT_NEAR(static_cast<double>(found[0].begin_us - run.started_us) * 1e-6, run.joint_time.front(),
                  1e-4);
      EXPECT_NEAR(static_cast<double>(found[0].end_us - run.started_us) * 1e-6, run.joint_time.back(), 1e-4);
    }
}

TEST(Recognition, WithoutCirclesThereIsNoRecogniser) {
  const RobotModel model(test::kPlanarUrdf, "base", "tcp", JointConvention::kSerial);
  RobotSpec robot;
  EXPECT_EQ(make_recogniser(robot, model), nullptr);
  robot.tests.emplace_back().kind = TestKind::kLine;
  EXPECT_EQ(make_recogniser(robot, model), nullptr);
}

TEST(Recognition, JointsThatAreNotTheChainsEndThePath) {
  const RobotModel model(test::kPlanarUrdf, "base", "tcp", JointConvention::kSerial);
  const PlanarCircle circle;
  RobotSpec robot;
  robot.tests = {test::planar_test(circle)};
  for (const std::vector<double>& stranger :
       {std::vector<double>{0.0}, {0.0, 0.0, 0.0}, {0.0, std::nan("")}}) {
    const std::unique_ptr<Recogniser> recogniser = make_recogniser(robot, model);
    ballbar::Run run = test::planar_run(circle);
    std::vector<RecognisedCircle> found;
    for (std::size_t i = 0; i < run.joint_time.size(); ++i) {
      if (i == run.joint_time.size() / 2) recogniser->take(run.started_us + 1, stranger, found);
      recogniser->take(run.started_us + std::llround(run.joint_time[i] * 1e6),
                       std::span(run.joint_position).subspan(2 * i, 2), found);
    }
    EXPECT_TRUE(found.empty());
  }
}

// The LR Mate with its tool down, by inverse kinematics, joints as on the teach pendant.
TEST(Recognition, AnLrMateIsKnownByItsTool) {
  const RobotModel model(text_of(BALLBAR_SOURCE_DIR "/scripts/robots/lrmate200ic.urdf"), "base", "tcp",
                         JointConvention::kFanuc);
  RobotSpec robot;
  TestSpec& test = robot.tests.emplace_back();
  test.circle.centre = {0.38, -0.32, -0.251};
  test.circle.arc_sweep = 2 * kPi;
  for (const double turned_deg : {0.0, 5.0}) {
    test.tool_rpy = Vec3{kPi, turned_deg * kRadPerDeg, 0.0};
    const std::unique_ptr<Recogniser> recogniser = make_recogniser(robot, model);
    std::vector<RecognisedCircle> found;
    std::vector<double> q;
    for (int i = 0; i <= 720; ++i) {
      const double a = i * 0.5 * kRadPerDeg;
      const Vec3 at{0.38 + 0.1 * std::cos(a), -0.32 + 0.1 * std::sin(a), -0.251};
      const Eigen::Isometry3d pose = tool_pose(at, {kPi, 0.0, 0.0});
      const IkResult solved = q.empty() ? inverse(model, pose) : inverse_near(model, pose, q);
      ASSERT_EQ(solved.status, IkStatus::kOk);
      q = solved.q;
      recogniser->take(i * 16'000, q, found);
    }
    recogniser->end_path(found);
    EXPECT_EQ(found.size(), turned_deg == 0.0 ? 1u : 0u);
  }
}

struct Trajectory {
  std::vector<double> time;            ///< [s]
  std::vector<std::vector<double>> q;  ///< [rad] six each
};

/// Columns <what>1_deg .. <what>6_deg; the joints that have no such column as the motors say.
Trajectory kuka(const std::string& file, const std::string& what) {
  std::ifstream csv(BALLBAR_SHARED_DIR "/data/kuka_kr300/" + file);
  std::string line, cell;
  std::getline(csv, line);
  std::vector<std::string> names;
  for (std::istringstream header(line); std::getline(header, cell, ',');) names.push_back(cell);
  const auto column = [&](const std::string& name) {
    return static_cast<std::size_t>(std::find(names.begin(), names.end(), name) - names.begin());
  };
  Trajectory path;
  while (std::getline(csv, line)) {
    std::vector<double> row;
    for (std::istringstream cells(line); std::getline(cells, cell, ',');) row.push_back(std::stod(cell));
    path.time.push_back(row.at(0));
    std::vector<double>& q = path.q.emplace_back();
    for (int joint = 1; joint <= 6; ++joint) {
      const std::size_t own = column(what + std::to_string(joint) + "_deg");
      const std::size_t motor = column("motor" + std::to_string(joint) + "_deg");
      q.push_back(row.at(own < row.size() ? own : motor) * kRadPerDeg);
    }
  }
  return path;
}

// Real movements of a real robot, with circles configured wherever it passes, in the planes that it moves in.
TEST(Recognition, AKukaAtWorkDrivesNoneOfTheCirclesAlongItsWay) {
  if (!std::filesystem::exists(BALLBAR_SHARED_DIR "/data/kuka_kr300/traj_A.csv"))
    GTEST_SKIP() << "no recordings at " BALLBAR_SHARED_DIR "/data/kuka_kr300";
  const RobotModel model(text_of(BALLBAR_SOURCE_DIR "/scripts/robots/kr300r2500ultra.urdf"), "base", "tcp",
                         JointConvention::kSerial);
  for (const char* file : {"traj_A.csv", "traj_B.csv", "traj_C.csv"})
    for (const char* what : {"motor", "link", "command"}) {
      SCOPED_TRACE(std::string(file) + " " + what);
      const Trajectory path = kuka(file, what);
      ASSERT_GT(path.time.size(), 2000u);
      std::vector<Eigen::Vector3d> points;
      for (const std::vector<double>& q : path.q) points.push_back(model.forward(q).translation());
      RobotSpec robot;
      const auto add = [&robot](const Eigen::Vector3d& centre, const Eigen::Vector3d& normal,
                                const Eigen::Vector3d& first, double radius) {
        for (const double sweep_deg : {90.0, 220.0, 360.0}) {
          TestSpec& test = robot.tests.emplace_back();
          test.circle.centre = {centre.x(), centre.y(), centre.z()};
          test.circle.normal = {normal.x(), normal.y(), normal.z()};
          test.circle.first_axis = {first.x(), first.y(), first.z()};
          test.circle.radius = radius;
          test.circle.arc_sweep = sweep_deg * kRadPerDeg;
        }
      };
      for (std::size_t i = 250; i + 250 < points.size(); i += 250) {
        const Eigen::Vector3d ahead = points[i + 125] - points[i];
        const Eigen::Vector3d behind = points[i - 125] - points[i];
        const Eigen::Vector3d normal = ahead.cross(behind);
        if (normal.norm() < 1e-6) continue;
        for (const double radius : {0.05, 0.1, 0.3, 0.6}) {
          // about a point of the path, and through three points of it, or touching it
          add(points[i], Eigen::Vector3d::UnitZ(), Eigen::Vector3d::UnitX(), radius);
          add(points[i], normal.normalized(), ahead.normalized(), radius);
          const Eigen::Vector3d inward = normal.cross(ahead).normalized();
          add(points[i] + radius * inward, normal.normalized(), -inward, radius);
          add(points[i] - radius * inward, normal.normalized(), inward, radius);
        }
        const Eigen::Vector3d to_centre =
            (ahead.squaredNorm() * behind - behind.squaredNorm() * ahead).cross(ahead.cross(behind)) /
            (2.0 * normal.squaredNorm());
        if (to_centre.norm() < 0.05 || to_centre.norm() > 0.6) continue;
        add(points[i] + to_centre, normal.normalized(), -to_centre.normalized(), to_centre.norm());
      }
      ASSERT_GT(robot.tests.size(), 200u);
      const std::unique_ptr<Recogniser> recogniser = make_recogniser(robot, model);
      std::vector<RecognisedCircle> found;
      for (std::size_t i = 0; i < path.q.size(); ++i)
        recogniser->take(std::llround(path.time[i] * 1e6), path.q[i], found);
      recogniser->end_path(found);
      for (const RecognisedCircle& circle : found)
        ADD_FAILURE() << "radius " << robot.tests[circle.test].circle.radius << " sweep "
                      << to_deg(robot.tests[circle.test].circle.arc_sweep) << " at "
                      << static_cast<double>(circle.begin_us) * 1e-6 << " s";
    }
}

}  // namespace
}  // namespace ballbar
