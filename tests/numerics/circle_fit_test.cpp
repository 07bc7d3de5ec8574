#include "numerics/circle_fit.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "numerics/nist_circles.hpp"

namespace ballbar {
namespace {

using Eigen::Matrix2Xd;
using Eigen::Vector2d;

constexpr unsigned kSeed = 20230711;

/// n points on an arc [rad] of a circle, with radial noise.
Matrix2Xd arc(int n, double sweep, const Vector2d& centre, double radius, double noise,
              std::mt19937& random) {
  std::normal_distribution<double> normal(0.0, 1.0);
  Matrix2Xd points(2, n);
  for (int i = 0; i < n; ++i) {
    const double angle = sweep * i / n;
    points.col(i) = centre + (radius + noise * normal(random)) * Vector2d(std::cos(angle), std::sin(angle));
  }
  return points;
}

TEST(CircleFit, AgreesWithAllThirtyReferencePairsOfNistToAPicometre) {
  if (!std::filesystem::exists(test::shared_data()))
    GTEST_SKIP() << "no shared data at " << BALLBAR_SHARED_DIR;
  for (int number = 1; number <= test::kNistSets; ++number) {
    const test::NistCircle nist = test::read_nist_circle(number);
    const CircleFit fit = fit_circle(nist.points);
    ASSERT_EQ(fit.status, FitStatus::kOk) << nist.name;
    // 1e-9 mm is asked for; the references print 17 digits of up to 824 mm.
    EXPECT_LT((fit.centre - nist.centre).norm(), 1e-9) << nist.name;
    EXPECT_NEAR(fit.radius, nist.radius, 1e-9) << nist.name;
  }
}

TEST(CircleFit, GoesThroughThreePointsExactlyAndClaimsNoNoise) {
  Matrix2Xd points(2, 3);
  points << 1, -1, 0,  //
      0, 0, 1;
  const CircleFit fit = fit_circle(points);
  ASSERT_EQ(fit.status, FitStatus::kOk);
  EXPECT_NEAR(fit.centre.norm(), 0.0, 1e-15);
  EXPECT_NEAR(fit.radius, 1.0, 1e-15);
  EXPECT_EQ(fit.residual_sd, 0.0);
}

TEST(CircleFit, ItsStandardDeviationsAreThoseOfAThousandRepeatedMeasurements) {
  for (const double sweep : {6.28, 3.14, 1.5}) {
    std::mt19937 random(kSeed);
    const int repeats = 1000;
    Eigen::Matrix3d scatter = Eigen::Matrix3d::Zero();
    Eigen::Matrix3d claimed = Eigen::Matrix3d::Zero();
    const Eigen::Vector3d truth(3.0, -2.0, 0.1);
    for (int i = 0; i < repeats; ++i) {
      const CircleFit fit = fit_circle(arc(60, sweep, truth.head<2>(), truth[2], 1e-6, random));
      ASSERT_EQ(fit.status, FitStatus::kOk);
      Eigen::Vector3d error(fit.centre.x(), fit.centre.y(), fit.radius);
      error -= truth;
      scatter += error * error.transpose() / repeats;
      claimed += fit.covariance / repeats;
    }
    // A variance of 1000 draws is good to 4.5 %; four times that.
    for (int k = 0; k < 3; ++k)
      EXPECT_NEAR(scatter(k, k) / claimed(k, k), 1.0, 0.18)
          << "seed " << kSeed << ", sweep " << sweep << ", unknown " << k;
  }
}

TEST(CircleFit, SaysSoWhereThePointsDetermineNoCircle) {
  EXPECT_EQ(fit_circle(Matrix2Xd::Random(2, 2)).status, FitStatus::kTooFewPoints);
  EXPECT_EQ(fit_circle(Matrix2Xd::Ones(2, 9)).status, FitStatus::kIllConditioned);
  Matrix2Xd line(2, 9);
  for (int i = 0; i < 9; ++i) line.col(i) << 0.1 * i, 3.0 - 0.7 * i;
  EXPECT_EQ(fit_circle(line).status, FitStatus::kIllConditioned);
}

TEST(CircleFit, RefusesACoordinateThatIsNotFinite) {
  Matrix2Xd points = Matrix2Xd::Random(2, 9);
  points(1, 4) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(fit_circle(points), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
