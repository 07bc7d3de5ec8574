#include "metrology/circle_iso.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>

#include "core/units.hpp"
#include "metrology/circle.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kRadius = 0.1;
constexpr double kNanometre = 1e-9;

CircleSpec spec_of(double start_deg, double sweep_deg) {
  CircleSpec spec;
  spec.radius = kRadius;
  spec.arc_start = start_deg * kRadPerDeg;
  spec.arc_sweep = sweep_deg * kRadPerDeg;
  return spec;
}

/// What a bar reads whose ball is off by e, where the robot drives the radius kRadius + shape(angle).
template <typename Shape>
CircleTrace drive(const CircleSpec& spec, int direction, int n, const Vector2d& e, Shape shape) {
  CircleTrace trace;
  trace.direction = direction;
  trace.angle.resize(n);
  trace.deviation.resize(n);
  for (Index i = 0; i < n; ++i) {
    const double share = (static_cast<double>(i) + 0.25) / n;
    const double angle = spec.arc_start + spec.arc_sweep * (direction > 0 ? share : 1.0 - share);
    const Vector2d u(std::cos(angle), std::sin(angle));
    trace.angle[i] = angle;
    trace.deviation[i] = ((kRadius + shape(angle)) * u + e).norm() - kRadius;
  }
  return trace;
}

std::vector<std::string> names(const std::vector<NotDefined>& list) {
  std::vector<std::string> all;
  for (const NotDefined& each : list) all.push_back(each.figure);
  std::sort(all.begin(), all.end());
  return all;
}

TEST(CircleFigures, OfPureOvalityAreKnownByHandWhereverTheBallIs) {
  const CircleSpec spec = spec_of(0, 360);
  for (const double offset : {0.0, 0.05e-3, 1e-3}) {
    const Vector2d e(0.6 * offset, -0.8 * offset);
    const CircleTrace trace =
        drive(spec, 1, 3600, e, [](double a) { return 12e-6 + 50e-6 * std::cos(2.0 * a); });
    const auto figures = circle_figures(trace, spec);
    ASSERT_TRUE(figures);
    EXPECT_NEAR(*figures->circular_error_ls, 100e-6, 0.1e-6) << offset;
    EXPECT_NEAR(*figures->circular_error_mz, 100e-6, 0.1e-6) << offset;
    EXPECT_NEAR(*figures->radial_max_ls, 62e-6, 0.1e-6) << offset;
    EXPECT_NEAR(*figures->radial_min_ls, -38e-6, 0.1e-6) << offset;
    EXPECT_NEAR(figures->radius_deviation->value, 12e-6, 0.1e-6) << offset;
    EXPECT_NEAR(figures->lsc->rms, 50e-6 / std::sqrt(2.0), 0.1e-6) << offset;
    EXPECT_NEAR(figures->mic->radius, kRadius - 38e-6, 0.1e-6) << offset;
    EXPECT_NEAR(figures->mcc->radius, kRadius + 62e-6, 0.1e-6) << offset;
    EXPECT_NEAR(std::hypot(figures->lsc->centre_x - e.x(), figures->lsc->centre_y - e.y()), 0.0, 0.1e-6)
        << offset;
    EXPECT_TRUE(figures->not_defined.empty());
  }
}

TEST(CircleFigures, AboutTheSetUpCentreHoldTheOffsetOfTheBall) {
  const CircleSpec spec = spec_of(0, 360);
  const CircleTrace trace = drive(spec, -1, 3600, Vector2d(30e-6, 40e-6), [](double) { return 5e-6; });
  const auto figures = circle_figures(trace, spec);
  ASSERT_TRUE(figures);
  EXPECT_NEAR(figures->radial_max_setup, 55e-6, kNanometre);
  EXPECT_NEAR(figures->radial_min_setup, -45e-6, kNanometre);
  EXPECT_NEAR(*figures->circular_error_mz, 0.0, kNanometre);
}

TEST(CircleFigures, HoldTheRecordThatTheStandardWants) {
  CircleSpec spec = spec_of(-20, 220);
  spec.normal = {0, 1, 0};
  spec.first_axis = {0, 0, 1};
  CircleTrace trace = drive(spec, -1, 2200, Vector2d::Zero(), [](double) { return 0.0; });
  trace.feed = 0.05;
  trace.temperature = 21.5;
  const auto figures = circle_figures(trace, spec, {15.0});
  ASSERT_TRUE(figures);
  EXPECT_EQ(figures->direction, -1);
  EXPECT_EQ(figures->feed, 0.05);
  EXPECT_EQ(figures->temperature, 21.5);
  EXPECT_EQ(figures->normal, (Vec3{0, 1, 0}));
  EXPECT_EQ(figures->filter_upr, 15.0);
  EXPECT_EQ(figures->nominal_radius, kRadius);
  // The filter leaves out one wavelength of 24 deg at each end.
  EXPECT_NEAR(to_deg(figures->start_angle), 200 - 24, 0.2);
  EXPECT_NEAR(to_deg(figures->end_angle), -20 + 24, 0.2);
  EXPECT_NEAR(static_cast<double>(figures->samples), 2200 - 480, 4);
}

// 100 mm of steel at 25 degC are 5.85 um longer than at 20: 100 mm x 11.7 ppm/K x 5 K.
TEST(CircleFigures, R20IsTheRadiusWithoutItsWarmth) {
  const CircleSpec spec = spec_of(0, 360);
  std::mt19937 random(11);
  std::normal_distribution<double> noise(0.0, 0.5e-6);
  CircleTrace trace =
      drive(spec, 1, 3600, Vector2d(20e-6, 0.0), [&](double) { return 8e-6 + noise(random); });
  EXPECT_FALSE(circle_figures(trace, spec, {{}, 11.7e-6})->radius_20_deviation) << "no temperature";
  trace.temperature = 25.0;
  EXPECT_FALSE(circle_figures(trace, spec)->radius_20_deviation) << "no expansion";
  const auto warm = circle_figures(trace, spec, {{}, 11.7e-6});
  ASSERT_TRUE(warm->radius_20_deviation);
  EXPECT_NEAR(warm->radius_deviation->value - warm->radius_20_deviation->value, 5.85e-6, kNanometre);
  EXPECT_NEAR(*warm->radius_20_deviation->sd, 0.5e-6 / std::sqrt(3600.0), 1e-9);
  EXPECT_EQ(warm->expansion, 11.7e-6);
  trace.temperature = 20.0;
  const auto cool = circle_figures(trace, spec, {{}, 11.7e-6});
  EXPECT_NEAR(cool->radius_20_deviation->value, cool->radius_deviation->value, 1e-15);
  trace.temperature = 10.0;
  EXPECT_GT(circle_figures(trace, spec, {{}, 11.7e-6})->radius_20_deviation->value,
            cool->radius_20_deviation->value)
      << "a cold circle grows";
}

TEST(CircleFigures, AFilterTakesTheRippleAndLeavesTheShape) {
  const CircleSpec spec = spec_of(0, 360);
  const CircleTrace trace = drive(spec, 1, 3600, Vector2d(20e-6, 0.0), [](double a) {
    return 50e-6 * std::cos(2.0 * a) + 10e-6 * std::cos(90.0 * a);
  });
  EXPECT_NEAR(*circle_figures(trace, spec)->circular_error_ls, 120e-6, 0.5e-6);
  const double passed = 100e-6 * std::exp2(-4.0 / 225.0);
  EXPECT_NEAR(*circle_figures(trace, spec, {15.0})->circular_error_ls, passed, 0.1e-6);
}

TEST(CircleFigures, OnPartialArcsAreThoseThatAreDefinedAndTheOthersAreNamed) {
  struct Case {
    double sweep;
    std::vector<std::string> missing;
  };
  const std::vector<std::string> not_around{"mcc", "mic"};
  const std::vector<std::string> not_carried{
      "lsc", "mcc", "mic", "mzc", "radial_max_ls", "radial_min_ls", "radius_deviation"};
  for (const auto& [sweep, missing] :
       {Case{360, {}}, Case{220, {}}, Case{150, not_around}, Case{100, not_carried}, Case{90, not_carried}}) {
    const CircleSpec spec = spec_of(30, sweep);
    const CircleTrace trace = drive(spec, 1, 1500, Vector2d(10e-6, 5e-6), [](double a) {
      return 3e-6 + 10e-6 * std::cos(3.0 * a) + 0.5e-6 * std::sin(40.0 * a);
    });
    const auto figures = circle_figures(trace, spec);
    ASSERT_TRUE(figures) << sweep;
    EXPECT_EQ(names(figures->not_defined), missing) << sweep;
    for (const NotDefined& each : figures->not_defined) EXPECT_FALSE(each.reason.empty());
    EXPECT_EQ(figures->lsc.has_value(), sweep > 130) << sweep;
    EXPECT_EQ(figures->mic.has_value(), sweep > 180) << sweep;
    ASSERT_TRUE(figures->circular_error_mz) << sweep;
    EXPECT_LE(*figures->circular_error_mz, *figures->circular_error_ls);
    EXPECT_LE(*figures->circular_error_mz,
              figures->radial_max_setup - figures->radial_min_setup + kNanometre);
    EXPECT_NEAR(figures->radial_max_setup, trace.deviation.maxCoeff(), kNanometre);
  }
}

TEST(CircleFigures, GiveARadiusWhoseStandardDeviationIsTheScatterOfRepeatedRuns) {
  const CircleSpec spec = spec_of(0, 220);
  const unsigned seed = 12;
  std::mt19937 random(seed);
  std::normal_distribution<double> normal(0.0, 1e-6);
  double scatter = 0.0, claimed = 0.0;
  const int repeats = 300;
  for (int r = 0; r < repeats; ++r) {
    const CircleTrace trace = drive(spec, 1, 300, Vector2d::Zero(), [&](double) { return normal(random); });
    const auto figures = circle_figures(trace, spec);
    scatter += std::pow(figures->radius_deviation->value, 2);
    claimed += std::pow(*figures->radius_deviation->sd, 2);
  }
  EXPECT_NEAR(std::sqrt(scatter / claimed), 1.0, 0.15) << "seed " << seed;
}

TEST(CirclePair, OfADirectionDependentOvalIsKnownByHand) {
  // Radii 100 mm + 4 um + 30 um cos 2a counter-clockwise, - 2 um + 30 um cos 2a clockwise, each way + s 5 um
  // sin 2a.
  const CircleSpec spec = spec_of(0, 360);
  const Vector2d e(25e-6, -10e-6);
  const auto shape = [](int s) {
    return [s](double a) {
      return (s > 0 ? 4e-6 : -2e-6) + 30e-6 * std::cos(2.0 * a) + s * 5e-6 * std::sin(2.0 * a);
    };
  };
  const auto pair = join(drive(spec, 1, 3600, e, shape(1)), drive(spec, -1, 3500, e, shape(-1)), spec);
  ASSERT_TRUE(pair);
  const double amplitude = std::hypot(30e-6, 5e-6);
  EXPECT_NEAR(*pair->ccw.circular_error_ls, 2 * amplitude, 0.1e-6);
  EXPECT_NEAR(*pair->circular_error_b_ls, 6e-6 + 2 * amplitude, 0.1e-6);
  EXPECT_NEAR(*pair->circular_error_b, 6e-6 + 2 * amplitude, 0.1e-6);
  EXPECT_NEAR(pair->radial_error_d->value, 1e-6, 0.05e-6);
  EXPECT_NEAR(*pair->hysteresis, 16e-6, 0.05e-6);  // 6 um + 2 x 5 um, at 45 and 225 deg
  EXPECT_NEAR(std::remainder(to_deg(pair->hysteresis_angle) - 45.0, 180.0), 0.0, 2.0);
  EXPECT_NEAR(pair->positional_tolerance, 2 * (4e-6 + amplitude), 0.05e-6);  // the larger way's, outward
  EXPECT_EQ(pair->radial_max_setup, std::max(pair->ccw.radial_max_setup, pair->cw.radial_max_setup));
  EXPECT_TRUE(pair->not_defined.empty());
}

TEST(CirclePair, NeverReadsLessThanOneOfItsDirections) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-1.0, 1.0);
    const CircleSpec spec = spec_of(10, seed % 2 == 0 ? 360 : 200);
    const auto wild = [&](double) { return 20e-6 * uniform(random); };
    const auto pair =
        join(drive(spec, 1, 200, Vector2d::Zero(), wild), drive(spec, -1, 170, Vector2d::Zero(), wild), spec);
    ASSERT_TRUE(pair) << "seed " << seed;
    EXPECT_GE(*pair->circular_error_b, *pair->ccw.circular_error_mz - 1e-12) << "seed " << seed;
    EXPECT_GE(*pair->circular_error_b, *pair->cw.circular_error_mz - 1e-12) << "seed " << seed;
    EXPECT_LE(*pair->circular_error_b, *pair->circular_error_b_ls) << "seed " << seed;
    EXPECT_LE(*pair->hysteresis, *pair->circular_error_b_ls + 0.1e-6) << "seed " << seed;
  }
}

TEST(CirclePair, OnAQuarterHasHysteresisAboutTheSetUpCentreAndNoMeanRadius) {
  const CircleSpec spec = spec_of(0, 90);
  const auto trace = [&](int s) {
    return drive(spec, s, 600, Vector2d(10e-6, 0.0), [s](double a) { return s * 3e-6 * std::sin(2.0 * a); });
  };
  const auto pair = join(trace(1), trace(-1), spec);
  ASSERT_TRUE(pair);
  EXPECT_NEAR(*pair->hysteresis, 6e-6, 0.02e-6);
  EXPECT_NEAR(pair->positional_tolerance, 2.0 * std::max(pair->radial_max_setup, -pair->radial_min_setup),
              kNanometre);
  EXPECT_FALSE(pair->radial_error_d);
  EXPECT_EQ(names(pair->not_defined), std::vector<std::string>{"radial_error_d"});
}

TEST(CircleFigures, OfAStraightZigzagHaveNoCircularError) {
  CircleTrace trace;
  trace.direction = 1;
  trace.angle = VectorXd::LinSpaced(60, -0.5 * kRadPerDeg, 0.5 * kRadPerDeg);
  trace.deviation.resize(60);
  for (int i = 0; i < 60; ++i)  // 5 um to either side of a line across the bar
    trace.deviation[i] = (kRadius + (i % 2 == 0 ? 5e-6 : -5e-6)) / std::cos(trace.angle[i]) - kRadius;
  const auto figures = circle_figures(trace, spec_of(-0.5, 1));
  ASSERT_TRUE(figures);
  EXPECT_FALSE(figures->circular_error_mz);
  EXPECT_FALSE(figures->mzc);
  const auto named = [&](const std::string& figure) {
    return std::count_if(figures->not_defined.begin(), figures->not_defined.end(),
                         [&](const NotDefined& n) { return n.figure == figure; });
  };
  EXPECT_EQ(named("circular_error_mz"), 1);
  EXPECT_EQ(named("mzc"), 1);
}

TEST(CircleFigures, RefuseWhatIsNotACircle) {
  const CircleSpec spec = spec_of(0, 360);
  const CircleTrace good = drive(spec, 1, 100, Vector2d::Zero(), [](double) { return 0.0; });
  CircleTrace few = good;
  few.angle = VectorXd::Zero(3);
  few.deviation = VectorXd::Zero(3);
  EXPECT_FALSE(circle_figures(few, spec));
  EXPECT_FALSE(circle_figures(good, spec, {50.0})) << "100 samples do not carry 50 undulations";
  EXPECT_THROW(join(good, good, spec), std::invalid_argument);
  CircleTrace bad = good;
  bad.deviation[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(circle_figures(bad, spec), std::invalid_argument);
  bad.deviation[3] = -kRadius;
  EXPECT_THROW(circle_figures(bad, spec), std::invalid_argument);
  EXPECT_FALSE(carries_centre(good.angle.head(3)));
  EXPECT_TRUE(carries_centre(good.angle));
}

}  // namespace
}  // namespace ballbar
