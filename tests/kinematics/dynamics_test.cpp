// Torques against potential energy, the Lagrangian of a two-link arm, and KDL.

#include "kinematics/dynamics.hpp"

#include <gtest/gtest.h>

#include <kdl/chainidsolver_recursive_newton_euler.hpp>

#include "kinematics/inverse.hpp"
#include "kinematics/robots.hpp"

namespace ballbar {
namespace {

std::vector<Body> with_payload(const RobotModel& model, double mass) {
  std::vector<Body> bodies = model.bodies();
  bodies.push_back(model.payload(mass, {0, 0, 0.050}, "tool0"));
  return bodies;
}

/// Each link's own forward kinematics, and the masses as the file has them.
double potential_energy(const std::vector<double>& chain, double payload) {
  const auto height = [&](const std::string& link, std::size_t joints, const Eigen::Vector3d& com) {
    const RobotModel to_link(test::lrmate(), "base", link, JointConvention::kSerial);
    return (to_link.forward(
                std::vector<double>(chain.begin(), chain.begin() + static_cast<std::ptrdiff_t>(joints))) *
            com)
        .z();
  };
  return kGravity * (5.5 * height("link_2", 2, {0, 0, 0.15}) + 6.0 * height("link_3", 3, {0.08, 0, 0.06}) +
                     1.2 * height("link_5", 5, {0.03, 0, 0}) + payload * height("tool0", 6, {0, 0, 0.050}));
}

TEST(Torques, AtRestAreTheSlopeOfThePotentialEnergy) {
  const RobotModel model = test::lrmate_model(JointConvention::kSerial);
  std::mt19937_64 random(5);
  SCOPED_TRACE("random 5");
  for (int k = 0; k < 5; ++k) {
    const std::vector<double> q = test::random_angles(random, 6, 2.0);
    const JointVector torques = gravity_torques(model.chain(), with_payload(model, 3.0), q);
    for (std::size_t i = 0; i < 6; ++i) {
      const double h = 1e-5;
      std::vector<double> more = q, less = q;
      more[i] += h;
      less[i] -= h;
      const double slope = (potential_energy(more, 3.0) - potential_energy(less, 3.0)) / (2 * h);
      EXPECT_NEAR(torques(static_cast<int>(i)), slope, 1e-7) << "joint " << i + 1;
    }
  }
}

TEST(Torques, FollowTheLagrangianOfATwoLinkArm) {
  // Two links in the XZ plane, angles from the horizontal, + lifts (axis -Y).
  const std::string urdf = R"(<robot name="two"><link name="base"/>
    <link name="l1"><inertial><origin xyz="0.2 0 0"/><mass value="3"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.05" iyz="0" izz="0.05"/></inertial></link>
    <link name="l2"><inertial><origin xyz="0.15 0 0"/><mass value="2"/>
      <inertia ixx="0.01" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link><link name="tcp"/>
    <joint name="j1" type="continuous"><parent link="base"/><child link="l1"/><axis xyz="0 -1 0"/></joint>
    <joint name="j2" type="continuous"><parent link="l1"/><child link="l2"/><origin xyz="0.4 0 0"/><axis xyz="0 -1 0"/></joint>
    <joint name="jt" type="fixed"><parent link="l2"/><child link="tcp"/><origin xyz="0.3 0 0"/></joint></robot>)";
  const RobotModel model(urdf, "base", "tcp", JointConvention::kSerial);
  const double m1 = 3, m2 = 2, r1 = 0.2, l1 = 0.4, r2 = 0.15, i1 = 0.05, i2 = 0.02, g = kGravity;
  std::mt19937_64 random(6);
  SCOPED_TRACE("random 6");
  for (int k = 0; k < 50; ++k) {
    const std::vector<double> q = test::random_angles(random, 2, kPi);
    const std::vector<double> v = test::random_angles(random, 2, 5.0);
    const std::vector<double> w = test::random_angles(random, 2, 20.0);
    const double c2 = std::cos(q[1]), s2 = std::sin(q[1]);
    const double m22 = m2 * r2 * r2 + i2;
    const double m12 = m22 + m2 * l1 * r2 * c2;
    const double m11 = m1 * r1 * r1 + i1 + m2 * l1 * l1 + 2 * m2 * l1 * r2 * c2 + m22;
    const double h = m2 * l1 * r2 * s2;
    const double tau1 = m11 * w[0] + m12 * w[1] - h * (2 * v[0] * v[1] + v[1] * v[1]) +
                        g * ((m1 * r1 + m2 * l1) * std::cos(q[0]) + m2 * r2 * std::cos(q[0] + q[1]));
    const double tau2 = m12 * w[0] + m22 * w[1] + h * v[0] * v[0] + g * m2 * r2 * std::cos(q[0] + q[1]);
    const JointVector torques = joint_torques(model.chain(), model.bodies(), q, v, w);
    EXPECT_NEAR(torques(0), tau1, 1e-11);
    EXPECT_NEAR(torques(1), tau2, 1e-11);
  }
}

TEST(Torques, AgreeWithKdlInMotion) {
  std::mt19937_64 random(8);
  for (unsigned seed = 1; seed <= 4; ++seed) {
    SCOPED_TRACE("crooked robot, seed " + std::to_string(seed) + ", random 8");
    const std::string urdf = test::crooked_robot(seed, 6, seed % 2 ? 0 : 2);
    const RobotModel model(urdf, "l0", "tip", JointConvention::kSerial);
    ASSERT_EQ(model.bodies().size(), 6U);
    const KDL::Chain chain = test::kdl_chain(urdf, "l0", "tip");
    KDL::ChainIdSolver_RNE solver(chain, KDL::Vector(0, 0, -kGravity));
    for (int k = 0; k < 20; ++k) {
      const std::vector<double> q = test::random_angles(random, 6, kPi);
      const std::vector<double> v = test::random_angles(random, 6, 3.0);
      const std::vector<double> w = test::random_angles(random, 6, 10.0);
      KDL::JntArray expected(6);
      ASSERT_GE(solver.CartToJnt(test::to_kdl(q), test::to_kdl(v), test::to_kdl(w),
                                 KDL::Wrenches(chain.getNrOfSegments(), KDL::Wrench::Zero()), expected),
                0);
      const JointVector torques = joint_torques(model.chain(), model.bodies(), q, v, w);
      EXPECT_LT((torques - expected.data).cwiseAbs().maxCoeff(), 1e-9 * expected.data.cwiseAbs().maxCoeff());
    }
  }
}

TEST(Torques, OfJ2OnThePapersCirclesNeverChangeSign) {  // physics-gap.md 2: -27 to -38 Nm
  const RobotModel model = test::lrmate_model();
  double least = 0.0, largest = -1e9;
  for (const double y : {-0.320, 0.320})
    for (int degrees = 0; degrees < 360; degrees += 10) {
      const double t = degrees * kRadPerDeg;
      const IkResult at =
          inverse(model, tool_pose({0.380 + 0.1 * std::cos(t), y + 0.1 * std::sin(t), -0.251}, {kPi, 0, 0}));
      ASSERT_EQ(at.status, IkStatus::kOk);
      std::vector<double> q = at.q;
      model.to_chain(q);
      const JointVector torques = gravity_torques(model.chain(), with_payload(model, 0.438), q);
      least = std::min(least, torques(1));
      largest = std::max(largest, torques(1));
      // The paper's tool points straight down: nothing turns about the vertical, and nothing hangs beside J6.
      EXPECT_NEAR(torques(0), 0.0, 1e-9);
      EXPECT_NEAR(torques(5), 0.0, 1e-9);
    }
  EXPECT_GT(least, -38.5);
  EXPECT_LT(least, -36.0);
  EXPECT_LT(largest, -26.5);
  EXPECT_GT(largest, -29.0);
}

TEST(Torques, RefuseABodyThatHangsNowhere) {
  const RobotModel model = test::lrmate_model();
  std::vector<Body> bodies = model.bodies();
  const std::vector<double> zero(6, 0.0);
  bodies.front().joint = 7;
  EXPECT_THROW(gravity_torques(model.chain(), bodies, zero), std::invalid_argument);
  bodies.front().joint = 0;
  EXPECT_THROW(gravity_torques(model.chain(), bodies, zero), std::invalid_argument);
  EXPECT_THROW(joint_torques(model.chain(), model.bodies(), zero, std::vector<double>(5), zero),
               std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
