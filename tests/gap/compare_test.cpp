// Measured against predicted, where what was measured is made by hand: a robot that goes astray in a known
// way, a ball in a known place, and a shape that the model does not know.

#include "gap/compare.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <cmath>
#include <numbers>
#include <random>

#include "core/units.hpp"

namespace ballbar {
namespace {

using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kTurn = 2.0 * std::numbers::pi;

CircleSpec tilted() {
  CircleSpec circle;
  circle.centre = {0.38, -0.32, -0.25};
  circle.normal = {0.0, -0.6, 0.8};
  circle.first_axis = {1.0, 0.0, 0.0};
  circle.radius = 0.1;
  circle.arc_sweep = kTurn;
  return circle;
}

/// What is true, in the plane's frame.
struct World {
  double sweep = kTurn;
  Vector3d ball{0.0, 0.0, 0.0};                                           // [m] from the programmed centre
  Vector3d (*astray)(double) = [](double) { return Vector3d(0, 0, 0); };  // [m] known to the model, by angle
  double (*shape)(double) = [](double) { return 0.0; };                   // [m] not known to the model
  double noise = 0.0;                                                     // [m]
};

struct Recording {
  VectorXd angle, deviation;
  Eigen::Matrix3Xd points;  // as the model predicts them
};

Recording record(const World& world) {
  const Vector3d e1(1, 0, 0), e2(0, 0.8, 0.6), normal(0, -0.6, 0.8), centre(0.38, -0.32, -0.25);
  std::mt19937_64 rng(11);
  std::normal_distribution<double> noise(0.0, 1.0);
  const int n = 1800;
  Recording r{VectorXd(n), VectorXd(n), Eigen::Matrix3Xd(3, n)};
  for (int i = 0; i < n; ++i) {
    const double t = world.sweep * i / n;
    const Vector3d local = Vector3d(0.1 * std::cos(t), 0.1 * std::sin(t), 0.0) + world.astray(t);
    r.angle[i] = t;
    r.deviation[i] = (local - world.ball).norm() - 0.1 + world.shape(t) + world.noise * noise(rng);
    r.points.col(i) = centre + local.x() * e1 + local.y() * e2 + local.z() * normal;
  }
  return r;
}

PointsAt still(const Eigen::Matrix3Xd& points) {
  return [&points](double) { return points; };
}

CircleComparison compare(const World& world) {
  const Recording r = record(world);
  return compare_circle(tilted(), r.angle, r.deviation, still(r.points), false).value();
}

Vector3d bent(double t) {
  return {300e-6 * std::cos(3 * t), 200e-6 + 1e-3 * std::sin(2 * t), -2e-3 * std::cos(t)};
}

TEST(CompareCircle, NothingIsLeftWhereTheModelKnowsAll) {
  World world;
  world.astray = bent;
  world.ball = {150e-6, -400e-6, 0.0};
  const CircleComparison found = compare(world);
  EXPECT_NEAR(found.gap.rms, 0.0, 1e-12);
  EXPECT_NEAR(found.gap.mean.value, 0.0, 1e-12);
  EXPECT_NEAR(found.gap.largest, 0.0, 1e-12);
  for (std::size_t i = 1; i < found.gap.harmonics.size(); ++i)
    EXPECT_NEAR(std::hypot(found.gap.harmonics[i].cos, found.gap.harmonics[i].sin), 0.0, 1e-12) << i;
}

// However far off the ball stands: plain subtraction of first harmonics would leave e^2/4R.
TEST(CompareCircle, TheBallIsFoundWhereItStands) {
  const Vector3d e1(1, 0, 0), e2(0, 0.8, 0.6), centre(0.38, -0.32, -0.25);
  for (const double mm : {0.05, 0.5, 5.0}) {
    World world;
    world.ball = {1e-3 * mm * 0.6, -1e-3 * mm * 0.8, 0.0};
    const CircleComparison found = compare(world);
    EXPECT_NEAR(found.gap.rms, 0.0, 1e-12) << mm;
    EXPECT_LT((found.ball - (centre + world.ball.x() * e1 + world.ball.y() * e2)).norm(), 1e-12) << mm;
    // As in a CircleResult: the bar reads |rho u + e|, so e is against the ball.
    EXPECT_NEAR(found.gap.harmonics[0].cos, -world.ball.x(), 1e-12);
    EXPECT_NEAR(found.gap.harmonics[0].sin, -world.ball.y(), 1e-12);
  }
}

// A robot that as built goes 2 mm aside and 11 mm too low, and a person who sets the ball there.
TEST(CompareCircle, ABallSetUpForTheRobotAsBuiltIsNotEccentric) {
  World world;
  world.astray = [](double) { return Vector3d(2e-3, 0.0, -11e-3); };
  world.ball = {2e-3, 0.0, -11e-3};
  const CircleComparison found = compare(world);
  EXPECT_NEAR(found.gap.rms, 0.0, 1e-12);
  EXPECT_NEAR(found.gap.harmonics[0].cos, 0.0, 1e-12);
}

TEST(CompareCircle, WhatTheModelDoesNotKnowIsTheGap) {
  World world;
  world.astray = bent;
  world.ball = {20e-6, 30e-6, 0.0};
  world.shape = [](double t) { return 4e-6 + 10e-6 * std::cos(2 * t) - 3e-6 * std::sin(5 * t); };
  const CircleComparison found = compare(world);
  // A bent path mixes orders a little: 1 mm of 100 mm.
  EXPECT_NEAR(to_um(found.gap.mean.value), 4.0, 0.1);
  EXPECT_NEAR(to_um(found.gap.harmonics[1].cos), 10.0, 0.1);
  EXPECT_NEAR(to_um(found.gap.harmonics[1].sin), 0.0, 0.1);
  EXPECT_NEAR(to_um(found.gap.harmonics[4].sin), -3.0, 0.1);
  EXPECT_NEAR(to_um(found.gap.rms), std::sqrt((100.0 + 9.0) / 2.0), 0.1);
}

TEST(CompareCircle, TheLargestPlaceIsTheStepNotTheNoise) {
  World world;
  world.noise = 1e-6;
  world.shape = [](double t) { return std::abs(t - 4.0) < 3.0 * kRadPerDeg ? -8e-6 : 0.0; };
  const CircleComparison found = compare(world);
  EXPECT_NEAR(found.gap.largest_angle, 4.0, 4.0 * kRadPerDeg);
  EXPECT_NEAR(to_um(found.gap.largest), -8.0, 1.5);  // a degree holds five samples
}

// Against brute force: the best of many balls on ever finer grids has the same sum of squares, and no better
// one.
TEST(CompareCircle, NoOtherBallFitsBetter) {
  World world;
  world.sweep = 4.0;  // a partial arc: centre and mean are not orthogonal
  world.astray = bent;
  world.ball = {400e-6, -250e-6, 0.0};
  world.shape = [](double t) { return 20e-6 * std::cos(2 * t) + 5e-6 * std::sin(7 * t); };
  const Recording r = record(world);
  const std::optional<CircleComparison> found =
      compare_circle(tilted(), r.angle, r.deviation, still(r.points), false);
  ASSERT_TRUE(found.has_value());
  const auto rms_with = [&](const Vector3d& ball) {
    const VectorXd gap =
        r.deviation.array() + 0.1 - (r.points.colwise() - ball).colwise().norm().transpose().array();
    return std::sqrt((gap.array() - gap.mean()).square().mean());
  };
  EXPECT_NEAR(rms_with(found->ball), found->gap.rms, 1e-13);
  const Vector3d e1(1, 0, 0), e2(0, 0.8, 0.6);
  for (const double step : {1e-3, 1e-4, 1e-5, 1e-6, 1e-7})
    for (const int i : {-2, -1, 0, 1, 2})
      for (const int j : {-2, -1, 0, 1, 2})
        EXPECT_GE(rms_with(found->ball + step * (i * e1 + j * e2)), found->gap.rms * (1.0 - 1e-9));
}

// The bar's clock is off: its samples were taken later than they say, along a path that the model knows.
TEST(CompareCircle, AShiftOfTheClocksIsFoundWhereThePathHasAShape) {
  constexpr double kRate = 0.55;  // [rad/s]
  for (const double ms : {-13.2, 0.0, 24.2}) {
    World world;
    world.ball = {30e-6, -20e-6, 0.0};
    world.astray = bent;
    const Recording truth = record(world);
    const Vector3d e1(1, 0, 0), e2(0, 0.8, 0.6), normal(0, -0.6, 0.8), centre(0.38, -0.32, -0.25);
    const auto path = [&](const VectorXd& angle) {
      Eigen::Matrix3Xd points(3, angle.size());
      for (Eigen::Index i = 0; i < angle.size(); ++i) {
        const Vector3d p = Vector3d(0.1 * std::cos(angle[i]), 0.1 * std::sin(angle[i]), 0.0) + bent(angle[i]);
        points.col(i) = centre + p.x() * e1 + p.y() * e2 + p.z() * normal;
      }
      return points;
    };
    // What the model believes of the moments that the bar names.
    const VectorXd said = truth.angle.array() - kRate * ms * 1e-3;
    const PointsAt points = [&](double shift) { return path(said.array() + kRate * shift); };
    const CircleComparison found = compare_circle(tilted(), said, truth.deviation, points, true).value();
    ASSERT_TRUE(found.gap.time_shift.has_value());
    EXPECT_NEAR(found.gap.time_shift->value * 1e3, ms, 0.02);
    EXPECT_LT(found.gap.time_shift->sd.value(), 0.1e-3);
    EXPECT_LT(to_um(found.gap.rms), 0.02);
    if (ms != 0.0) {
      EXPECT_GT(to_um(compare_circle(tilted(), said, truth.deviation, points, false)->gap.rms), 5.0);
    }
  }
}

TEST(CompareCircle, AShiftThatNothingShowsStaysUnknown) {
  World world;
  world.shape = [](double t) { return 40e-6 * std::cos(2 * t); };
  const Recording r = record(world);
  const PointsAt points = [&](double shift) {
    World later;
    const Recording there = record(later);
    Eigen::Matrix3Xd turned(3, there.points.cols());
    const Eigen::Matrix3d turn = Eigen::AngleAxisd(0.55 * shift, Vector3d(0, -0.6, 0.8)).toRotationMatrix();
    const Vector3d centre(0.38, -0.32, -0.25);
    for (Eigen::Index i = 0; i < turned.cols(); ++i)
      turned.col(i) = centre + turn * (there.points.col(i) - centre);
    return turned;
  };
  const CircleComparison found = compare_circle(tilted(), r.angle, r.deviation, points, true).value();
  EXPECT_NEAR(found.gap.time_shift->value, 0.0, 1e-9);
  EXPECT_NEAR(found.gap.time_shift->sd.value(), 15e-3, 1e-4);
}

TEST(CompareCircle, AnArcTooShortForACentreGivesNothing) {
  World world;
  world.sweep = 0.5;
  const Recording r = record(world);
  EXPECT_FALSE(compare_circle(tilted(), r.angle, r.deviation, still(r.points), false).has_value());
  EXPECT_THROW(compare_circle(tilted(), r.angle, r.deviation.head(5), still(r.points), false),
               std::invalid_argument);
}

LineResult line_of(double (*deviation)(double)) {
  LineResult line;
  for (int i = 0; i <= 20; ++i) line.points.push_back({0.047 * i, deviation(0.047 * i), {}, {}});
  return line;
}

TEST(CompareLine, TheAlignmentOfTheOpticsIsNoGap) {
  LineResult line = line_of([](double x) { return 1e-3 * x * x + 7e-6 - 40e-6 * x; });
  VectorXd predicted(21);
  for (int i = 0; i < 21; ++i) predicted[i] = 1e-3 * (0.047 * i) * (0.047 * i);
  compare_line(line, predicted);
  ASSERT_TRUE(line.gap.has_value());
  EXPECT_NEAR(line.gap->rms, 0.0, 1e-15);
  for (const LinePoint& p : line.points) EXPECT_NEAR(p.predicted.value(), p.deviation, 1e-15);
}

TEST(CompareLine, ABumpIsFoundAtItsPlace) {
  LineResult line = line_of([](double x) { return std::abs(x - 0.47) < 0.01 ? -9e-6 : 0.0; });
  compare_line(line, VectorXd::Zero(21));
  ASSERT_TRUE(line.gap.has_value());
  EXPECT_NEAR(line.gap->largest_position, 0.47, 1e-12);
  EXPECT_NEAR(to_um(line.gap->largest), -9.0 * 20.0 / 21.0, 1e-9);  // in the middle the slope takes nothing
  EXPECT_NEAR(to_um(line.gap->rms), 9.0 * std::sqrt(20.0) / 21.0, 1e-9);
}

TEST(CompareLine, PointsThatAreNotPredictedAreLeftOut) {
  LineResult line = line_of([](double x) { return 5e-6 * x; });
  VectorXd predicted = VectorXd::Zero(21);
  predicted.tail(18).setConstant(std::nan(""));
  compare_line(line, predicted);
  EXPECT_TRUE(line.gap.has_value());
  EXPECT_FALSE(line.points[3].predicted.has_value());
  predicted.setConstant(std::nan(""));
  LineResult none = line_of([](double) { return 0.0; });
  compare_line(none, predicted);
  EXPECT_FALSE(none.gap.has_value());
}

}  // namespace
}  // namespace ballbar
