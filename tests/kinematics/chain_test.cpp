// The DH table against KDL, its columns against finite differences, and the as-built robot against figures
// from elsewhere.

#include "kinematics/chain.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <functional>
#include <kdl/chainfksolverpos_recursive.hpp>
#include <kdl/chainjnttojacsolver.hpp>

#include "kinematics/robots.hpp"

namespace ballbar {
namespace {

struct Case {
  std::string name, urdf, base, tip;
};

std::vector<Case> robots() {
  std::vector<Case> all = {{"LR Mate", test::lrmate(), "base_link", "tcp"}};
  const std::string ur10 = BALLBAR_SHARED_DIR "/data/ipa_ur10/ur10.urdf";
  if (std::filesystem::exists(ur10)) all.push_back({"UR10", test::text_of(ur10), "base_link", "tool0"});
  for (unsigned seed = 1; seed <= 6; ++seed) {
    const int joints = 2 + static_cast<int>(seed);
    all.push_back({"crooked, seed " + std::to_string(seed),
                   test::crooked_robot(seed, joints, seed % 2 ? 0 : 1), "l0", "tip"});
  }
  return all;
}

TEST(Chain, AgreesWithKdlForAnyRobot) {
  std::mt19937_64 random(11);
  for (const Case& robot : robots()) {
    SCOPED_TRACE(robot.name + ", random 11");
    const RobotModel model(robot.urdf, robot.base, robot.tip, JointConvention::kSerial);
    const KDL::Chain chain = test::kdl_chain(robot.urdf, robot.base, robot.tip);
    KDL::ChainFkSolverPos_recursive forward(chain);
    KDL::ChainJntToJacSolver slope(chain);
    for (int k = 0; k < 100; ++k) {
      const std::vector<double> q = test::random_angles(random, model.joints(), kPi);
      KDL::Frame tip;
      ASSERT_GE(forward.JntToCart(test::to_kdl(q), tip), 0);
      const Eigen::Isometry3d pose = model.forward(q);
      for (int i = 0; i < 3; ++i) {
        EXPECT_NEAR(pose.translation()(i), tip.p(i), 1e-12);  // rounding at some metres
        for (int j = 0; j < 3; ++j) EXPECT_NEAR(pose.linear()(i, j), tip.M(i, j), 1e-12);
      }
      KDL::Jacobian jacobian(chain.getNrOfJoints());
      ASSERT_GE(slope.JntToJac(test::to_kdl(q), jacobian), 0);
      EXPECT_LT((model.jacobian(q) - jacobian.data).cwiseAbs().maxCoeff(), 1e-12);
    }
  }
}

TEST(Chain, HasTheTableOfTheLrMateAsItIsKnown) {  // physics-gap.md 2, from a public robot catalogue
  const RobotModel model = test::lrmate_model();
  const double alpha_deg[] = {0, -90, 0, -90, 90, -90};
  const double a_mm[] = {0, 75, 300, 75, 0, 0};
  const double d_mm[] = {0, 0, 0, 320, 0, 80};
  const double sign[] = {1, 1, -1, -1, -1, -1};  // FANUC's J3..J6 turn against the table's z
  ASSERT_EQ(model.chain().rows().size(), 6U);
  for (std::size_t i = 0; i < 6; ++i) {
    const DhRow& row = model.chain().rows()[i];
    SCOPED_TRACE("row " + std::to_string(i + 1));
    EXPECT_NEAR(to_deg(row.alpha), alpha_deg[i], 1e-10);
    EXPECT_NEAR(to_mm(row.a), a_mm[i], 1e-10);
    EXPECT_NEAR(to_mm(row.d), d_mm[i], 1e-10);
    EXPECT_NEAR(row.beta, 0.0, 1e-12);
    EXPECT_EQ(row.sign, sign[i]);
  }
}

TEST(Chain, GivesNearlyParallelAxesASecondTiltInsteadOfALengthOfMiles) {
  const RobotModel model(test::crooked_robot(2, 4, 1), "l0", "tip", JointConvention::kSerial);
  const DhRow& row = model.chain().rows()[1];
  EXPECT_GT(std::hypot(row.alpha, row.beta), 1e-5);
  EXPECT_LT(std::hypot(row.alpha, row.beta), 0.02);
  EXPECT_NE(row.beta, 0.0);
  for (const DhRow& each : model.chain().rows()) EXPECT_LT(std::abs(each.d), 10.0);
}

TEST(Chain, ParallelAxesOfAUr10GetZerosWhereItsMakerHasThem) {
  const std::string path = BALLBAR_SHARED_DIR "/data/ipa_ur10/ur10.urdf";
  if (!std::filesystem::exists(path)) GTEST_SKIP() << "no " << path;
  const RobotModel model(test::text_of(path), "base", "tool0", JointConvention::kSerial);
  const double d_mm[] = {127.3,   0,     0,
                         163.941, 115.7, 92.2};  // the maker's table; a is signed there, a length here
  const double a_mm[] = {0, 0, 612, 572.3, 0, 0};
  for (std::size_t i = 0; i < 6; ++i) {
    EXPECT_NEAR(to_mm(model.chain().rows()[i].d), d_mm[i], 1e-8) << "row " << i + 1;
    EXPECT_NEAR(to_mm(model.chain().rows()[i].a), a_mm[i], 1e-8) << "row " << i + 1;
  }
}

/// One small and one real deviation of every kind, so that columns are tried at a chain that is as built.
ChainDeviation some_deviation(std::mt19937_64& random, int joints) {
  std::uniform_real_distribution<double> any(-3e-3, 3e-3);
  ChainDeviation deviation;
  for (int i = 0; i < joints; ++i)
    deviation.links.push_back({any(random), any(random), any(random), any(random), any(random)});
  deviation.tool = {any(random), any(random), any(random)};
  return deviation;
}

TEST(Chain, ColumnsAreTheSlopesOfForwardByEveryParameter) {
  std::mt19937_64 random(23);
  for (const Case& robot : robots()) {
    const RobotModel model(robot.urdf, robot.base, robot.tip, JointConvention::kSerial);
    const int n = model.joints();
    for (int k = 0; k < 5; ++k) {
      SCOPED_TRACE(robot.name + ", random 23, posture " + std::to_string(k));
      const std::vector<double> q = test::random_angles(random, n, kPi);
      const ChainDeviation at =
          k == 0 ? ChainDeviation{std::vector<LinkDeviation>(static_cast<std::size_t>(n)), {0, 0, 0}}
                 : some_deviation(random, n);
      const PositionColumns columns = model.chain().with(at).position_columns(q);
      const auto slope = [&](const std::function<double&(ChainDeviation&)>& parameter) {
        const double h = 1e-5;  // truncation h^2 and rounding 1e-16/h both stay near 1e-11
        ChainDeviation more = at, less = at;
        parameter(more) += h;
        parameter(less) -= h;
        return Eigen::Vector3d((model.forward(q, more).translation() - model.forward(q, less).translation()) /
                               (2 * h));
      };
      const auto expect_same = [](const Eigen::Vector3d& column, const Eigen::Vector3d& by_difference) {
        EXPECT_LT((column - by_difference).norm(), 1e-8 * std::max(1e-1, by_difference.norm()));
      };
      for (int i = 0; i < n; ++i) {
        const auto link = static_cast<std::size_t>(i);
        SCOPED_TRACE("row " + std::to_string(i + 1));
        expect_same(columns.joint.col(i),
                    slope([&](auto& c) -> double& { return c.links[link].zero_offset; }));
        expect_same(columns.a.col(i), slope([&](auto& c) -> double& { return c.links[link].a; }));
        expect_same(columns.d.col(i), slope([&](auto& c) -> double& { return c.links[link].d; }));
        expect_same(columns.alpha.col(i), slope([&](auto& c) -> double& { return c.links[link].alpha; }));
        expect_same(columns.beta.col(i), slope([&](auto& c) -> double& { return c.links[link].beta; }));
      }
      for (int axis = 0; axis < 3; ++axis)
        expect_same(columns.tool.col(axis), slope([&](auto& c) -> double& { return c.tool(axis); }));
    }
  }
}

TEST(Chain, ALengthOfTheTableIsTheLengthInTheUrdf) {
  // The forearm 2 mm longer and the elbow 1 mm higher, once in the file and once as deviations of rows 4.
  std::string urdf = test::lrmate();
  urdf.replace(urdf.find("xyz=\"0.32 0 0\""), 14, "xyz=\"0.322 0 0\"");
  urdf.replace(urdf.find("xyz=\"0 0 0.075\""), 15, "xyz=\"0 0 0.076\"");
  const RobotModel longer(urdf, "base", "tcp", JointConvention::kFanuc);
  ChainDeviation deviation;
  deviation.links.resize(6);
  deviation.links[3].d = 0.002;
  deviation.links[3].a = 0.001;
  const std::vector<double> q = test::radians({10, 20, -30, 40, -50, 60});
  EXPECT_LT((longer.forward(q).matrix() - test::lrmate_model().forward(q, deviation).matrix()).norm(), 1e-14);
}

TEST(Chain, AToolOffsetLiesAlongTheAxesOfTheTip) {
  const RobotModel model = test::lrmate_model();
  const std::vector<double> q = test::radians({10, 20, -30, 40, -50, 60});
  const Eigen::Isometry3d nominal = model.forward(q);
  const Eigen::Vector3d offset(1e-3, -2e-3, 3e-3);
  const Eigen::Isometry3d moved = model.forward(q, {{}, offset});
  EXPECT_LT((moved.translation() - nominal * offset).norm(), 1e-15);
}

TEST(Chain, AxesOfTheJointsGoThroughWhereTheUrdfPutsThem) {
  const RobotModel model = test::lrmate_model();
  const std::vector<double> zero(6, 0.0);
  const std::vector<JointAxis> axes = model.chain().joint_axes(zero);
  const Eigen::Vector3d direction[] = {{0, 0, 1}, {0, 1, 0}, {0, -1, 0}, {-1, 0, 0}, {0, -1, 0}, {-1, 0, 0}};
  ASSERT_EQ(axes.size(), 6U);
  for (std::size_t i = 0; i < 6; ++i)
    EXPECT_LT((axes[i].direction - direction[i]).norm(), 1e-12) << "joint " << i + 1;
  EXPECT_LT((axes[1].origin - Eigen::Vector3d(0.075, 0, 0)).norm(), 1e-12);
  EXPECT_LT((axes[2].origin - Eigen::Vector3d(0.075, 0, 0.3)).norm(), 1e-12);
  EXPECT_NEAR(axes[3].origin.z(), 0.375, 1e-12);
  EXPECT_LT((axes[4].origin - Eigen::Vector3d(0.395, 0, 0.375)).norm(), 1e-12);
}

TEST(Chain, RefusesWhatDoesNotFit) {
  const Chain chain = test::lrmate_model().chain();
  EXPECT_THROW(chain.forward(std::vector<double>(5, 0.0)), std::invalid_argument);
  EXPECT_THROW(chain.jacobian(std::vector<double>(6, std::nan(""))), std::invalid_argument);
  ChainDeviation short_of_one;
  short_of_one.links.resize(5);
  EXPECT_THROW(chain.with(short_of_one), std::invalid_argument);
  EXPECT_THROW(Chain(Eigen::Isometry3d::Identity(), {}, Eigen::Isometry3d::Identity()),
               std::invalid_argument);
  EXPECT_THROW(Chain(Eigen::Isometry3d::Identity(), std::vector<DhRow>(kMaxChainJoints + 1),
                     Eigen::Isometry3d::Identity()),
               std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
