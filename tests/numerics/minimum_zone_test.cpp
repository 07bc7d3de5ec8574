#include "numerics/minimum_zone.hpp"

#include <gtest/gtest.h>

#include <Eigen/LU>

#include <algorithm>
#include <cmath>
#include <limits>
#include <nlohmann/json.hpp>
#include <random>

#include "numerics/circle_fit.hpp"
#include "numerics/nist_circles.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix2Xd;
using Eigen::Vector2d;
using Eigen::VectorXd;

double width_about(const Matrix2Xd& points, const Vector2d& centre) {
  const VectorXd distance = (points.colwise() - centre).colwise().norm();
  return distance.maxCoeff() - distance.minCoeff();
}

/// The twin: every minimum touches two points outside and two inside, so its centre lies where the
/// perpendicular bisectors of two pairs cross. All crossings in the square that minimum_zone_circle() answers
/// for are tried: O(n^5).
double brute_force_zone(const Matrix2Xd& points) {
  const CircleFit circle = fit_circle(points);
  double best = width_about(points, circle.centre);
  const Index n = points.cols();
  for (Index a = 0; a < n; ++a)
    for (Index b = a + 1; b < n; ++b)
      for (Index c = a; c < n; ++c)
        for (Index d = c + 1; d < n; ++d) {
          Eigen::Matrix2d normals;
          normals << (points.col(b) - points.col(a)).transpose(), (points.col(d) - points.col(c)).transpose();
          if (std::abs(normals.determinant()) < 1e-12) continue;
          const Vector2d offsets(points.col(b).squaredNorm() - points.col(a).squaredNorm(),
                                 points.col(d).squaredNorm() - points.col(c).squaredNorm());
          const Vector2d centre = normals.inverse() * offsets / 2.0;
          if ((centre - circle.centre).cwiseAbs().maxCoeff() > 4.0 * circle.radius) continue;
          best = std::min(best, width_about(points, centre));
        }
  return best;
}

/// The twin: the best slope is that of a line through two points. O(n^3).
double brute_force_strip(const VectorXd& x, const VectorXd& y) {
  double best = std::numeric_limits<double>::infinity();
  for (Index i = 0; i < x.size(); ++i)
    for (Index j = 0; j < x.size(); ++j) {
      if (x[i] == x[j]) continue;
      const VectorXd deviation = y - (y[j] - y[i]) / (x[j] - x[i]) * x;
      best = std::min(best, deviation.maxCoeff() - deviation.minCoeff());
    }
  return best;
}

TEST(MinimumZoneCircle, HasTheRoundnessOfTheOracleForAllThirtyNistSets) {
  if (!std::filesystem::exists(test::shared_data()))
    GTEST_SKIP() << "no shared data at " << BALLBAR_SHARED_DIR;
  std::ifstream file(test::shared_data() / "oracles" / "nist_circle2d_lsc_mzc.json");
  const nlohmann::json oracle = nlohmann::json::parse(file);
  for (int number = 1; number <= test::kNistSets; ++number) {
    const test::NistCircle nist = test::read_nist_circle(number);
    const MinimumZoneCircle zone = minimum_zone_circle(nist.points);
    ASSERT_EQ(zone.status, FitStatus::kOk) << nist.name;
    EXPECT_NEAR(zone.width, oracle.at(nist.name).at("RONt_MZC").get<double>(), 1e-9) << nist.name;
    EXPECT_NEAR(zone.width, width_about(nist.points, zone.centre), 1e-12) << nist.name;
    const Vector2d least_squares = fit_circle(nist.points).centre;
    const double by_least_squares = width_about(nist.points, least_squares);
    EXPECT_NEAR(by_least_squares, oracle.at(nist.name).at("RONt_LSC").get<double>(), 1e-9) << nist.name;
    EXPECT_LE(zone.width, by_least_squares + 1e-12) << nist.name;
  }
}

TEST(MinimumZoneCircle, EqualsItsBruteForceTwinOnRoundPartialAndWildPoints) {
  struct Kind {
    const char* name;
    double sweep, noise;
  };
  for (const Kind& kind : {Kind{"round", 6.28, 0.01}, Kind{"rough", 6.28, 0.3}, Kind{"wild", 6.28, 0.9},
                           Kind{"half", 3.14, 0.02}, Kind{"short", 1.0, 0.01}})
    for (unsigned seed = 1; seed <= 60; ++seed) {
      std::mt19937 random(seed);
      std::uniform_real_distribution<double> uniform(-1.0, 1.0);
      const int n = 5 + static_cast<int>(seed % 8);
      Matrix2Xd points(2, n);
      for (int i = 0; i < n; ++i) {
        const double angle = kind.sweep * (i + 0.4 * uniform(random)) / n;
        points.col(i) = (1.0 + kind.noise * uniform(random)) * Vector2d(std::cos(angle), std::sin(angle));
      }
      if (fit_circle(points).status != FitStatus::kOk) continue;
      const MinimumZoneCircle zone = minimum_zone_circle(points);
      EXPECT_NEAR(zone.width, brute_force_zone(points), 1e-9)
          << kind.name << ", seed " << seed << ", n " << n;
    }
}

TEST(MinimumZoneCircle, OfThousandsOfSamplesTouchesFourTimesInAlternation) {
  const unsigned seed = 77;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 1.0);
  const int n = 2800;
  Matrix2Xd points(2, n);
  for (int i = 0; i < n; ++i) {
    const double angle = 2.0 * EIGEN_PI * i / n;
    const double radius =
        0.1 + 185e-6 * std::cos(2 * angle) + 20e-6 * std::sin(3 * angle) + 0.5e-6 * normal(random);
    points.col(i) = radius * Vector2d(std::cos(angle), std::sin(angle));
  }
  const MinimumZoneCircle zone = minimum_zone_circle(points);
  ASSERT_EQ(zone.status, FitStatus::kOk);
  std::string touches;  // by angle: o outer, i inner
  for (int i = 0; i < n; ++i) {
    const double distance = (points.col(i) - zone.centre).norm();
    if (zone.outer_radius - distance < 1e-14) touches += 'o';
    if (distance - zone.inner_radius < 1e-14) touches += 'i';
  }
  EXPECT_TRUE(touches == "oioi" || touches == "ioio") << touches << ", seed " << seed;
}

TEST(MinimumZoneCircle, OfAPerfectCircleIsZeroWide) {
  Matrix2Xd points(2, 100);
  for (int i = 0; i < 100; ++i) points.col(i) << 5.0 + std::cos(0.06 * i), std::sin(0.06 * i);
  const MinimumZoneCircle zone = minimum_zone_circle(points);
  EXPECT_NEAR(zone.width, 0.0, 1e-14);
}

TEST(MinimumZoneCircle, CopesWithPointsMeasuredTwiceInTheSameDirection) {
  // Two turns over the same angles, 0.02 apart: no centre can lower the width below that, and many reach it.
  Matrix2Xd points(2, 72);
  for (int i = 0; i < 72; ++i) {
    const double angle = 2.0 * EIGEN_PI * (i % 36) / 36;
    points.col(i) = (i < 36 ? 1.0 : 1.02) * Vector2d(std::cos(angle), std::sin(angle));
  }
  const MinimumZoneCircle zone = minimum_zone_circle(points);
  ASSERT_EQ(zone.status, FitStatus::kOk);
  EXPECT_NEAR(zone.width, 0.02, 1e-12);
}

TEST(MinimumZoneCircle, SaysSoWhereThereIsNoCircle) {
  EXPECT_EQ(minimum_zone_circle(Matrix2Xd::Random(2, 2)).status, FitStatus::kTooFewPoints);
  EXPECT_EQ(minimum_zone_circle(Matrix2Xd::Ones(2, 5)).status, FitStatus::kIllConditioned);
  EXPECT_THROW(minimum_zone_circle(Matrix2Xd::Constant(2, 5, std::numeric_limits<double>::infinity())),
               std::invalid_argument);
}

TEST(MinimumZoneLine, EqualsItsBruteForceTwin) {
  for (unsigned seed = 1; seed <= 300; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const int n = 2 + static_cast<int>(seed % 23);
    const bool on_grid = seed % 2 == 0;  // several readings at each place
    VectorXd x(n);
    VectorXd y(n);
    for (int i = 0; i < n; ++i) {
      const int place = i / 3;
      x[i] = on_grid ? place : uniform(random);
      y[i] = 3.0 * x[i] + uniform(random);
    }
    if (x.minCoeff() == x.maxCoeff()) continue;
    const MinimumZoneLine zone = minimum_zone_line(x, y);
    ASSERT_EQ(zone.status, FitStatus::kOk) << "seed " << seed;
    EXPECT_NEAR(zone.width, brute_force_strip(x, y), 1e-12) << "seed " << seed;
    const VectorXd off = (y - zone.slope * x).array() - zone.intercept;
    EXPECT_NEAR(off.maxCoeff(), zone.width / 2, 1e-12) << "seed " << seed;
    EXPECT_NEAR(off.minCoeff(), -zone.width / 2, 1e-12) << "seed " << seed;
  }
}

TEST(MinimumZoneLine, SaysSoWhereThereIsNoLine) {
  EXPECT_EQ(minimum_zone_line(VectorXd::Zero(1), VectorXd::Zero(1)).status, FitStatus::kTooFewPoints);
  EXPECT_EQ(minimum_zone_line(VectorXd::Ones(4), VectorXd::Random(4)).status, FitStatus::kIllConditioned);
  EXPECT_THROW(minimum_zone_line(VectorXd::Zero(3), VectorXd::Zero(4)), std::invalid_argument);
  EXPECT_THROW(minimum_zone_line(VectorXd::Constant(3, std::nan("")), VectorXd::Zero(3)),
               std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
