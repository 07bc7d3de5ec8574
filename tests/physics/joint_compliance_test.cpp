// Compliance against torques by hand, and against slopes of potential energy.

#include <gtest/gtest.h>

#include "kinematics/dynamics.hpp"
#include "physics/physics_test.hpp"

namespace ballbar {
namespace {

using test::effect;

EffectSpec compliance(int joint, double value) {
  return effect("joint_compliance", joint, {{"compliance_rad_per_nm", value}});
}

TEST(JointCompliance, AnArmThatIsHeldUpHangsByItsWeightAndPayload) {
  const AsBuilt arm = test::arm_with({compliance(1, 4e-5)});
  for (const double angle : {-1.0, 0.0, 0.5, 2.0}) {
    for (const double payload : {0.0, 3.0}) {
      const Motion still = test::single(5, 100, [&](double) { return angle; });
      const Eigen::MatrixXd link = arm.link_angles(still, {.payload = payload});
      // 2 kg at 0.3 m; the payload hangs 50 mm along z of tool0, which is upright at angle 0.
      const double torque =
          9.80665 * (2 * 0.3 * std::cos(angle) + payload * (0.4 * std::cos(angle) - 0.05 * std::sin(angle)));
      EXPECT_NEAR(link(0, 2) - angle, -4e-5 * torque, 1e-15) << angle << " rad, " << payload << " kg";
    }
  }
}

TEST(JointCompliance, BendsUnderInertiaToo) {
  // Upright axis, no gravity: I = 2 x 0.3^2 + 0.02 [kg m^2] at 1.4 rad/s^2.
  const AsBuilt arm = test::arm_with({compliance(1, 1e-3)}, "0 0 1");
  const Motion motion = test::single(400, 250, [](double t) { return 0.7 * t * t; });
  const Eigen::MatrixXd link = arm.link_angles(motion, {});
  for (int k = 0; k < 400; ++k)
    EXPECT_NEAR(link(0, k) - motion.q(0, k), -1e-3 * 0.2 * 1.4, 1e-10) << "sample " << k;
}

TEST(JointCompliance, OfEachJointOfTheLrMateIsTheSlopeOfItsPotentialEnergy) {
  // Masses as in the URDF file; each link's place by its own forward kinematics.
  const auto height = [](const std::string& link, std::size_t joints, const Eigen::Vector3d& com,
                         const std::vector<double>& q) {
    const RobotModel to_link(test::lrmate(), "base", link, JointConvention::kSerial);
    const std::vector<double> some(q.begin(), q.begin() + static_cast<std::ptrdiff_t>(joints));
    return (to_link.forward(some) * com).z();
  };
  const auto energy = [&](const std::vector<double>& q) {
    return kGravity *
           (5.5 * height("link_2", 2, {0, 0, 0.15}, q) + 6.0 * height("link_3", 3, {0.08, 0, 0.06}, q) +
            1.2 * height("link_5", 5, {0.03, 0, 0}, q) + 3.0 * height("tool0", 6, {0, 0, 0.050}, q));
  };
  const std::vector<double> q = test::radians({-40, 20, -30, 15, -70, 25});
  Motion still{Eigen::VectorXd::LinSpaced(5, 0.0, 0.4), Eigen::MatrixXd(6, 5)};
  still.q.colwise() = Eigen::Map<const Eigen::VectorXd>(q.data(), 6);
  for (int joint = 1; joint <= 6; ++joint) {
    const AsBuilt robot = test::lrmate_with({compliance(joint, 4e-5)});
    const Eigen::VectorXd bent = robot.link_angles(still, {.payload = 3.0}).col(2) - still.q.col(2);
    std::vector<double> more = q, less = q;
    more[static_cast<std::size_t>(joint - 1)] += 1e-5;
    less[static_cast<std::size_t>(joint - 1)] -= 1e-5;
    const double slope = (energy(more) - energy(less)) / 2e-5;
    for (int j = 1; j <= 6; ++j)
      EXPECT_NEAR(bent(j - 1), j == joint ? -4e-5 * slope : 0.0, 1e-11) << "joint " << j;
  }
}

}  // namespace
}  // namespace ballbar
