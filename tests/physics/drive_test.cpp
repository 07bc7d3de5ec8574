// Torques along a motion against those worked out at each sample.

#include "physics/drive.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <string>

#include "physics/physics_test.hpp"

namespace ballbar {
namespace {

struct Case {
  std::string name;
  std::function<double(double)> angle;  // [rad] of the first joint; the others follow with other factors
  double allowed;                       // of each joint's largest torque
};

Motion motion_of(const Case& one, double rate, int n) {
  Motion motion{Eigen::VectorXd(n), Eigen::MatrixXd(6, n)};
  for (int k = 0; k < n; ++k) {
    motion.time(k) = k / rate;
    for (int j = 0; j < 6; ++j) motion.q(j, k) = 0.2 * j + (1.0 - 0.25 * j) * one.angle(motion.time(k));
  }
  return motion;
}

std::span<const double> column(const Eigen::MatrixXd& m, Eigen::Index k) {
  return {m.col(k).data(), static_cast<std::size_t>(m.rows())};
}

TEST(Loads, GiveTheTorquesOfEverySample) {
  const RobotModel model = test::lrmate_model(JointConvention::kFanuc);
  const std::vector<Case> cases{
      {"a circle", [](double t) { return 0.3 * std::sin(0.55 * t); }, 5e-4},
      {"a corner", [](double t) { return t < 3.0 ? 0.1 * t : 0.3 - 0.2 * (t - 3.0); }, 5e-4},
      {"a stop", [](double t) { return t < 3.0 ? 0.2 * std::cos(t) : 0.2 * std::cos(3.0); }, 5e-4},
      {"rounded readings", [](double t) { return 1e-4 * std::round(3e3 * std::sin(0.55 * t)); }, 5e-4},
      {"standing", [](double) { return 0.4; }, 1e-12}};
  for (const Case& one : cases)
    for (const double rate : {35.0, 125.0}) {
      const Motion motion = motion_of(one, rate, 400);
      Loads loads(motion, model.chain(), model.bodies());
      const Derivatives by = derivatives(motion);
      Eigen::MatrixXd exact(6, 400);
      for (Eigen::Index k = 0; k < 400; ++k)
        exact.col(k) = joint_torques(model.chain(), model.bodies(), column(motion.q, k), column(by.speed, k),
                                     column(by.acceleration, k));
      const double whole = exact.cwiseAbs().maxCoeff();
      for (Eigen::Index j = 0; j < 6; ++j) {
        const double scale = std::max(exact.row(j).cwiseAbs().maxCoeff(), 0.01 * whole);
        EXPECT_LE((loads.torque().row(j) - exact.row(j)).cwiseAbs().maxCoeff(), one.allowed * scale)
            << one.name << " at " << rate << " Hz, J" << j + 1;
      }
    }
}

TEST(Loads, HoldForTheSamePathAtTheSameSpeedWithTheSamePayloadOnly) {
  const RobotModel model = test::lrmate_model(JointConvention::kFanuc);
  const Motion motion = motion_of({"", [](double t) { return 0.3 * std::sin(0.55 * t); }, 0.0}, 35.0, 100);
  std::vector<Body> loaded = model.bodies();
  loaded.push_back(model.payload(3.0, {0, 0, 0.05}, "tool0"));
  std::vector<Body> heavier = model.bodies();
  heavier.push_back(model.payload(3.1, {0, 0, 0.05}, "tool0"));
  const Loads loads(motion, model.chain(), loaded);
  Motion later = motion, slower = motion, moved = motion;
  later.time.array() += 0.012;
  slower.time *= 3.0;
  moved.q.row(1).array() += 1e-3;
  EXPECT_TRUE(loads.hold_for(motion, model.chain(), loaded));
  EXPECT_TRUE(loads.hold_for(later, model.chain(), loaded)) << "a clock that is off";
  EXPECT_FALSE(loads.hold_for(slower, model.chain(), loaded)) << "the same path at a third of the speed";
  EXPECT_FALSE(loads.hold_for(moved, model.chain(), loaded));
  EXPECT_FALSE(loads.hold_for(motion, model.chain(), heavier));
  EXPECT_FALSE(loads.hold_for(motion, model.chain(), model.bodies()));
  ChainDeviation zero;
  zero.links.resize(6);
  zero.links[2].zero_offset = 1e-3;
  EXPECT_FALSE(loads.hold_for(motion, model.chain().with(zero), loaded));
}

TEST(Loads, GiveTheInertiaOfWhatAJointTurns) {
  // 2 kg 0.3 m from the axis and 0.02 kg m^2 about their own centre, whatever the pose (physics_test.hpp).
  const AsBuilt arm = test::arm_with({});
  const Motion motion = test::single(400, 125, [](double t) { return std::sin(t); });
  Loads loads(motion, arm.model().chain(), arm.model().bodies());
  const Eigen::VectorXd inertia = loads.inertia(1);
  EXPECT_LT((inertia.array() - (2.0 * 0.3 * 0.3 + 0.02)).abs().maxCoeff(), 1e-9);
}

}  // namespace
}  // namespace ballbar
