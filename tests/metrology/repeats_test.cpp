#include "metrology/repeats.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace ballbar {
namespace {

constexpr double kTurn = 2.0 * std::numbers::pi;

std::vector<Harmonic> harmonics(const std::vector<std::pair<double, double>>& values) {
  std::vector<Harmonic> all;
  for (const auto& [cos, sin] : values) all.push_back({static_cast<int>(all.size()) + 1, cos, sin, 0, 0, 0});
  return all;
}

TEST(RepeatedHarmonics, HaveMeanAndCovarianceOfTheOrdersThatAllRunsHold) {
  const auto repeated = repeat_harmonics({harmonics({{9, 9}, {0, 1}}), harmonics({{9, 9}, {3, 4}, {7, 7}}),
                                          harmonics({{9, 9}, {2, 1}}), harmonics({{9, 9}, {3, 6}})});
  ASSERT_EQ(repeated.size(), 2U);
  EXPECT_EQ(repeated[1].order, 2);
  EXPECT_EQ(repeated[1].sample.mean, Eigen::Vector2d(2, 3));
  EXPECT_NEAR((*repeated[1].sample.covariance)(0, 0), 6.0 / 3, 1e-15);
  EXPECT_NEAR((*repeated[1].sample.covariance)(0, 1), 8.0 / 3, 1e-15);
  EXPECT_NEAR((*repeated[1].sample.covariance)(1, 1), 18.0 / 3, 1e-15);
  EXPECT_TRUE(repeat_harmonics({}).empty());
  EXPECT_FALSE(repeat_harmonics({harmonics({{1, 2}})})[0].sample.covariance) << "one run does not scatter";
}

TEST(RepeatedHarmonics, RefuseOrdersOutOfSequence) {
  std::vector<Harmonic> holed = harmonics({{1, 1}, {2, 2}});
  holed[1].order = 3;
  EXPECT_THROW(repeat_harmonics({holed}), std::invalid_argument);
  const auto two = repeat_harmonics({harmonics({{1, 1}, {2, 2}})});
  EXPECT_THROW(drift_of(two[0], two[1]), std::invalid_argument);
}

/// d(angle) sampled unevenly over one turn, counter-clockwise or clockwise.
template <typename Function>
RadialTrace trace(Function d, unsigned seed, bool clockwise, int samples = 3000) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> jitter(-0.4, 0.4);
  RadialTrace run;
  for (int i = 0; i < samples; ++i) {
    run.angle.push_back(kTurn * (i + 0.5 + jitter(random)) / samples);
    run.deviation.push_back(d(run.angle.back()));
  }
  if (clockwise) {
    std::reverse(run.angle.begin(), run.angle.end());
    std::reverse(run.deviation.begin(), run.deviation.end());
  }
  return run;
}

TEST(RadialPath, HasThePathThatWasDrivenWhicheverWay) {
  // Three runs about one path, off by -1, 0 and +1 times w(angle): sd = w, so RT_r = 3 max w.
  const auto path = [](double a) { return 50e-6 * std::cos(2 * a) + 20e-6 * std::cos(a); };
  const auto w = [](double a) { return 1e-6 * (2.0 + std::sin(a)); };
  for (const bool clockwise : {false, true}) {
    std::vector<RadialTrace> runs;
    for (const int k : {-1, 0, 1})
      runs.push_back(trace([&](double a) { return path(a) + k * w(a); }, 11U + k, clockwise));
    const auto found = radial_path(runs);
    ASSERT_TRUE(found);
    EXPECT_EQ(found->runs, 3);
    ASSERT_EQ(found->angle.size(), 360U);
    for (std::size_t i = 0; i < found->angle.size(); ++i) {
      EXPECT_NEAR(found->mean[i], path(found->angle[i]), 1e-9);
      EXPECT_NEAR(found->sd[i], w(found->angle[i]), 1e-9);
    }
    EXPECT_NEAR(found->accuracy, 70e-6, 0.02e-6);
    EXPECT_NEAR(std::cos(found->accuracy_angle), 1.0, 1e-3);
    EXPECT_NEAR(found->accuracy_centred, 50e-6, 0.02e-6) << "the ball's set-up is no error of the robot";
    EXPECT_NEAR(found->repeatability.value(), 9e-6, 0.01e-6);
    EXPECT_NEAR(found->repeatability_angle, kTurn / 4, 0.05);
  }
}

TEST(RadialPath, OfOneRunHasAnAccuracyAndNoRepeatability) {
  const auto found = radial_path({trace([](double) { return -30e-6; }, 1, false)}, 90);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->angle.size(), 90U);
  EXPECT_NEAR(found->accuracy, 30e-6, 1e-15);
  EXPECT_TRUE(found->sd.empty());
  EXPECT_FALSE(found->repeatability);
}

TEST(RadialPath, LeavesOutWhatARunDoesNotHave) {
  RadialTrace whole = trace([](double) { return 1e-6; }, 1, false);
  RadialTrace holed, half;
  for (std::size_t i = 0; i < whole.angle.size(); ++i) {
    const double a = whole.angle[i];
    if (a < 2.0 || a > 2.2) {
      holed.angle.push_back(a);
      holed.deviation.push_back(3e-6);
    }
    if (a > 1.0 && a < 4.0) {
      half.angle.push_back(i % 7 == 0 ? std::numeric_limits<double>::quiet_NaN() : a);
      half.deviation.push_back(3e-6);
    }
  }
  const auto found = radial_path({whole, holed, half});
  ASSERT_TRUE(found);
  EXPECT_LT(found->angle.size(), 360U);
  EXPECT_GT(found->angle.size(), 320U);
  for (const double a : found->angle) {
    EXPECT_TRUE(a > 1.0 && a < 4.0) << a;
    EXPECT_FALSE(a > 2.01 && a < 2.19) << a;
  }
  EXPECT_FALSE(radial_path({})) << "no run";
  EXPECT_FALSE(radial_path({whole, RadialTrace{}})) << "an empty one";
  EXPECT_FALSE(radial_path({RadialTrace{{0, 0.01}, {0, 0}}, RadialTrace{{3, 3.01}, {0, 0}}}))
      << "no common arc";
  EXPECT_THROW(radial_path({RadialTrace{{0, 1}, {0}}}), std::invalid_argument);
  EXPECT_THROW(radial_path({RadialTrace{{0, 1}, {0, std::nan("")}}}), std::invalid_argument);
  EXPECT_THROW(radial_path({whole}, 0), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
