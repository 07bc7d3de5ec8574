// Corrections of the joints' zeros in the controller's convention, against draws that go through it one by
// one.

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <random>

#include "gap/explain.hpp"
#include "gap/paper_robot.hpp"
#include "numerics/whitening.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

TEST(Mastering, OfAFanucCountsTheCovarianceOfJ2AndJ3) {
  const RobotModel robot = test::lrmate();
  constexpr unsigned kSeed = 20261122;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937 random(kSeed);
  std::normal_distribution<double> normal;
  MatrixXd root = MatrixXd::NullaryExpr(6, 6, [&] { return 1e-4 * normal(random); });
  root.row(2) = root.row(1) + 0.1 * root.row(2);  // J2 and J3 of the chain go together, as circles leave them
  const MatrixXd covariance = root * root.transpose();
  const VectorXd zero = VectorXd::NullaryExpr(6, [&] { return 1e-3 * normal(random); });

  constexpr int kDraws = 20000;
  VectorXd sum = VectorXd::Zero(6), square = VectorXd::Zero(6);
  for (int i = 0; i < kDraws; ++i) {
    VectorXd q = zero + root * VectorXd::NullaryExpr(6, [&] { return normal(random); });
    robot.from_chain({q.data(), 6});
    sum += q;
    square += q.cwiseAbs2();
  }
  const VectorXd mean = sum / kDraws;
  const VectorXd sd = (square / kDraws - mean.cwiseAbs2()).cwiseSqrt();
  const std::vector<NamedParameter> found = mastering_of(robot, zero, covariance);
  ASSERT_EQ(found.size(), 6u);
  for (Index j = 0; j < 6; ++j) {
    SCOPED_TRACE(found[static_cast<std::size_t>(j)].name);
    EXPECT_NEAR(found[static_cast<std::size_t>(j)].value * test::kDeg, mean[j],
                4.0 * sd[j] / std::sqrt(kDraws));
    EXPECT_NEAR(found[static_cast<std::size_t>(j)].sd * test::kDeg / sd[j], 1.0, 0.03);
  }
  EXPECT_LT(found[2].sd, 0.3 * found[1].sd) << "what J2 and J3 share does not stand in the controller's J3";
}

TEST(CosineTransform, GivesBackValuesThatHoldNoHighFrequency) {
  constexpr Index kPlaces = 333;
  const CosineTransform transform(kPlaces, 0.8, 100.0);
  VectorXd values(kPlaces);
  for (Index i = 0; i < kPlaces; ++i) {
    const double x = (static_cast<double>(i) + 0.5) / kPlaces;
    values[i] = 2.0 + std::cos(std::numbers::pi * 3.0 * x) - 0.5 * std::cos(std::numbers::pi * 40.0 * x);
  }
  EXPECT_LT((transform.inverse(transform(values)) - values).cwiseAbs().maxCoeff(), 1e-10);
  EXPECT_THROW(transform.inverse(VectorXd::Zero(3)), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
