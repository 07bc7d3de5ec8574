#include "metrology/circle.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>
#include <string>

#include "core/units.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kCircleRadius = 0.1;
constexpr double kPicometre = 1e-12;  // 1e-6 um

VectorXd angles(double from_deg, double sweep_deg, int n) {
  return VectorXd::LinSpaced(n + 1, from_deg, from_deg + sweep_deg).head(n) * kRadPerDeg;
}

/// What a bar reads whose ball is off by e, where the robot moves on rho(angle) about the programmed centre.
VectorXd bar_readings(const VectorXd& angle, const VectorXd& rho, const Vector2d& e) {
  VectorXd deviation(angle.size());
  for (Index i = 0; i < angle.size(); ++i)
    deviation[i] = (rho[i] * Vector2d(std::cos(angle[i]), std::sin(angle[i])) + e).norm() - kCircleRadius;
  return deviation;
}

struct BallOffCase {
  double eccentricity_mm, from_deg, sweep_deg;
};

class BallOff : public testing::TestWithParam<BallOffCase> {};

TEST_P(BallOff, APerfectCircleHasNothingButItsEccentricity) {
  const auto [eccentricity_mm, from, sweep] = GetParam();
  for (const double towards_deg : {0.0, 37.0, 200.0}) {
    const Vector2d e = eccentricity_mm * kMetresPerMm *
                       Vector2d(std::cos(towards_deg * kRadPerDeg), std::sin(towards_deg * kRadPerDeg));
    const VectorXd angle = angles(from, sweep, 900);
    const auto circle =
        analyse_circle(angle, bar_readings(angle, VectorXd::Constant(900, kCircleRadius), e), kCircleRadius);
    ASSERT_TRUE(circle) << towards_deg;
    EXPECT_NEAR(circle->harmonics[0].cos, e.x(), kPicometre);
    EXPECT_NEAR(circle->harmonics[0].sin, e.y(), kPicometre);
    EXPECT_NEAR(circle->mean_radius_deviation.value, 0.0, kPicometre);
    EXPECT_LT(circle->noise, kPicometre);
    for (std::size_t k = 1; k < circle->harmonics.size(); ++k) {
      EXPECT_NEAR(circle->harmonics[k].cos, 0.0, kPicometre) << "order " << k + 1;
      EXPECT_NEAR(circle->harmonics[k].sin, 0.0, kPicometre) << "order " << k + 1;
    }
  }
}

// The offsets of metrology.md 2, up to half the radius; full turns and the arcs of machines with three
// planes.
INSTANTIATE_TEST_SUITE_P(Offsets, BallOff,
                         testing::Values(BallOffCase{0.05, 0, 360}, BallOffCase{0.5, 0, 360},
                                         BallOffCase{5, 0, 360}, BallOffCase{31.9, 0, 360},
                                         BallOffCase{50, 0, 360}, BallOffCase{0.05, -20, 220},
                                         BallOffCase{0.5, -20, 220}, BallOffCase{5, -20, 220},
                                         BallOffCase{31.9, -20, 220}, BallOffCase{50, -20, 220},
                                         BallOffCase{0.5, 100, 150}, BallOffCase{31.9, 100, 150}));

TEST(Circle, WithoutTheExactTreatmentAnEccentricBallWouldLookOval) {
  // The trap itself, so that the test above is known to test something: e^2 / 4R of ovality in the plain
  // harmonics.
  const VectorXd angle = angles(0, 360, 900);
  const VectorXd deviation = bar_readings(angle, VectorXd::Constant(900, kCircleRadius), Vector2d(5e-3, 0.0));
  double plain = 0.0;
  for (Index i = 0; i < 900; ++i) plain += deviation[i] * std::cos(2.0 * angle[i]) / 450.0;
  EXPECT_NEAR(std::abs(plain), 62.5e-6, 0.2e-6);
}

TEST(Circle, KeepsTheShapeOfTheMotionWhateverTheOffsetOfTheBall) {
  const VectorXd angle = angles(0, 360, 900);
  const VectorXd rho = kCircleRadius - 20e-6 + 100e-6 * (2.0 * angle.array()).cos() -
                       60e-6 * (2.0 * angle.array()).sin() + 7e-6 * (5.0 * angle.array()).sin();
  for (const double offset : {0.0, 1e-4, 5e-3, 4e-2}) {
    const Vector2d e(0.6 * offset, -0.8 * offset);
    const auto circle = analyse_circle(angle, bar_readings(angle, rho, e), kCircleRadius);
    ASSERT_TRUE(circle);
    EXPECT_NEAR(circle->harmonics[0].cos, e.x(), kPicometre) << offset;
    EXPECT_NEAR(circle->harmonics[0].sin, e.y(), kPicometre) << offset;
    EXPECT_NEAR(circle->mean_radius_deviation.value, -20e-6, kPicometre) << offset;
    EXPECT_NEAR(circle->harmonics[1].cos, 100e-6, kPicometre) << offset;
    EXPECT_NEAR(circle->harmonics[1].sin, -60e-6, kPicometre) << offset;
    EXPECT_NEAR(circle->harmonics[4].sin, 7e-6, kPicometre) << offset;
  }
}

TEST(Circle, PlottedAboutAnOffCentreIsRoundAboutItsLeastSquaresCentre) {
  // Here the angle is the direction of the bar: points of a true circle of 99.9 mm about (0.3, -0.2) mm.
  const Vector2d centre(0.3e-3, -0.2e-3);
  const double true_radius = 0.0999;
  VectorXd angle(700);
  VectorXd deviation(700);
  for (Index i = 0; i < 700; ++i) {
    const double turn = 2.0 * kPi * static_cast<double>(i) / 700.0;
    const Vector2d point = centre + true_radius * Vector2d(std::cos(turn), std::sin(turn));
    angle[i] = std::atan2(point.y(), point.x());
    deviation[i] = point.norm() - kCircleRadius;
  }
  const auto circle = analyse_circle(angle, deviation, kCircleRadius);
  ASSERT_TRUE(circle);
  EXPECT_NEAR(circle->eccentricity_x, centre.x(), kPicometre);
  EXPECT_NEAR(circle->eccentricity_y, centre.y(), kPicometre);
  EXPECT_NEAR(circle->radial_max, -0.1e-3, kPicometre);
  EXPECT_NEAR(circle->radial_min, -0.1e-3, kPicometre);
  EXPECT_NEAR(circle->circular_deviation, 0.0, kPicometre);
  EXPECT_NEAR(circle->circular_deviation_mz, 0.0, kPicometre);
}

TEST(Circle, OfPureOvalityDeviatesByTwiceItsAmplitude) {
  const VectorXd angle = angles(0, 360, 720);
  const auto circle = analyse_circle(angle, 50e-6 * (2.0 * angle.array() - 1.0).cos(), kCircleRadius);
  ASSERT_TRUE(circle);
  EXPECT_NEAR(circle->circular_deviation, 100e-6, 0.01e-6);
  EXPECT_NEAR(circle->circular_deviation, circle->radial_max - circle->radial_min, kPicometre);
  EXPECT_LE(circle->circular_deviation_mz, circle->circular_deviation);
  EXPECT_NEAR(ovality(*circle)->value, 50e-6, kPicometre);
  EXPECT_NEAR(ovality_axis(*circle)->value, 0.5, 1e-9);
}

TEST(Ovality, HasItsAxisBetweenZeroAndPiWhereTheTraceIsLongest) {
  const VectorXd angle = angles(0, 360, 720);
  for (int tenths = 0; tenths <= 31; ++tenths) {
    const double axis = tenths / 10.0;
    const auto circle = analyse_circle(angle, 10e-6 * (2.0 * (angle.array() - axis)).cos(), kCircleRadius);
    const double found = ovality_axis(*circle)->value;
    EXPECT_GE(found, 0.0);
    EXPECT_LT(found, kPi);
    EXPECT_NEAR(std::sin(found - axis), 0.0, 1e-9) << axis;  // 0 and pi are the same axis
  }
}

TEST(Ovality, ItsStandardDeviationsAreTheScatterOfRepeatedRuns) {
  const unsigned seed = 99;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 1e-6);
  const VectorXd angle = angles(0, 240, 400);
  const int repeats = 400;
  const double amplitude = 5e-6;
  double scatter = 0.0, claimed = 0.0, axis_scatter = 0.0, axis_claimed = 0.0, off_scatter = 0.0,
         off_claimed = 0.0;
  for (int r = 0; r < repeats; ++r) {
    const VectorXd deviation = amplitude * (2.0 * angle.array() - 1.4).cos() +
                               VectorXd::NullaryExpr(400, [&] { return normal(random); }).array();
    const auto circle = analyse_circle(angle, deviation, kCircleRadius, 2);
    ASSERT_TRUE(circle && ovality(*circle));
    scatter += std::pow(ovality(*circle)->value - amplitude, 2);
    claimed += std::pow(*ovality(*circle)->sd, 2);
    axis_scatter += std::pow(ovality_axis(*circle)->value - 0.7, 2);
    axis_claimed += std::pow(*ovality_axis(*circle)->sd, 2);
    off_scatter += (std::pow(circle->harmonics[0].cos, 2) + std::pow(circle->harmonics[0].sin, 2)) / 2.0;
    off_claimed += std::pow(circle->eccentricity_sd, 2);
  }
  // 400 runs give a standard deviation to 3.5 %; the estimate of the correlation adds a little.
  EXPECT_NEAR(std::sqrt(scatter / claimed), 1.0, 0.15) << "seed " << seed;
  EXPECT_NEAR(std::sqrt(axis_scatter / axis_claimed), 1.0, 0.15) << "seed " << seed;
  EXPECT_NEAR(std::sqrt(off_scatter / off_claimed), 1.0, 0.15) << "seed " << seed;
}

TEST(Ovality, OfNothingHasAnAxisOfWhichNothingIsKnown) {
  CircleResult circle;
  circle.harmonics = {{1, 0, 0, 1e-12, 1e-12, 0}, {2, 0, 0, 1e-12, 4e-12, 0}};
  EXPECT_EQ(ovality(circle)->value, 0.0);
  EXPECT_GT(*ovality(circle)->sd, 0.0);
  EXPECT_DOUBLE_EQ(*ovality_axis(circle)->sd, kPi / std::sqrt(12.0));
  EXPECT_DOUBLE_EQ(*eccentricity_direction(circle).sd, kPi / std::sqrt(3.0));
}

TEST(Ovality, IsAbsentWhereTheArcDidNotCarryIt) {
  const VectorXd angle = angles(0, 130, 500);
  const auto circle = analyse_circle(angle, VectorXd::Zero(500), kCircleRadius);
  ASSERT_TRUE(circle);
  EXPECT_EQ(circle->harmonics.size(), 1U);
  EXPECT_FALSE(ovality(*circle));
  EXPECT_FALSE(ovality_axis(*circle));
}

TEST(Eccentricity, IsGivenByAmountAndDirection) {
  CircleResult circle;
  circle.eccentricity_x = -3e-6;
  circle.eccentricity_y = -4e-6;
  circle.eccentricity_sd = 1e-6;
  EXPECT_NEAR(eccentricity(circle).value, 5e-6, 1e-18);
  EXPECT_EQ(eccentricity(circle).sd, 1e-6);
  EXPECT_NEAR(eccentricity_direction(circle).value, kPi + std::atan2(4.0, 3.0), 1e-12);
  EXPECT_NEAR(*eccentricity_direction(circle).sd, 0.2, 1e-12);
}

TEST(Circle, IsNotFoundWhereTheSamplesDetermineNone) {
  EXPECT_FALSE(analyse_circle(VectorXd(0), VectorXd(0), kCircleRadius));
  EXPECT_FALSE(analyse_circle(angles(0, 360, 3), VectorXd::Zero(3), kCircleRadius));
  EXPECT_TRUE(analyse_circle(angles(0, 360, 4), VectorXd::Zero(4), kCircleRadius));
  EXPECT_FALSE(analyse_circle(angles(0, 60, 500), VectorXd::Zero(500), kCircleRadius))
      << "a sixth of a turn carries no centre";
  EXPECT_FALSE(analyse_circle(VectorXd::Constant(50, 0.3), VectorXd::Zero(50), kCircleRadius))
      << "a robot that stood still";
  EXPECT_FALSE(analyse_circle(angles(0, 360, 50), VectorXd::Constant(50, -kCircleRadius), kCircleRadius))
      << "a bar of no length";
}

TEST(Circle, OfWildReadingsIsEitherFoundFiniteOrNotFound) {
  for (unsigned seed = 1; seed <= 200; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-0.99, 20.0);
    const auto n = static_cast<int>(4 + seed);
    const VectorXd deviation = VectorXd::NullaryExpr(n, [&] { return kCircleRadius * uniform(random); });
    const auto circle = analyse_circle(angles(0, 90 + 1.4 * seed, n), deviation, kCircleRadius);
    if (!circle) continue;
    EXPECT_TRUE(std::isfinite(circle->circular_deviation)) << "seed " << seed;
    EXPECT_LE(circle->circular_deviation_mz, circle->circular_deviation + kPicometre) << "seed " << seed;
    for (const Harmonic& h : circle->harmonics)
      EXPECT_TRUE(std::isfinite(h.cos + h.sin + h.var_cos)) << "seed " << seed;
  }
}

TEST(Circle, RefusesWhatIsNotFiniteOrDoesNotFit) {
  const VectorXd good = angles(0, 360, 20);
  VectorXd bad = VectorXd::Zero(20);
  for (const double value :
       {std::numeric_limits<double>::quiet_NaN(), std::numeric_limits<double>::infinity()}) {
    bad[7] = value;
    EXPECT_THROW(analyse_circle(good, bad, kCircleRadius), std::invalid_argument);
    EXPECT_THROW(analyse_circle(bad, good, kCircleRadius), std::invalid_argument);
  }
  EXPECT_THROW(analyse_circle(good, VectorXd::Zero(19), kCircleRadius), std::invalid_argument);
  EXPECT_THROW(analyse_circle(good, VectorXd::Zero(20), 0.0), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
