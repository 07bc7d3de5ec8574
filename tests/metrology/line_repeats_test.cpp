#include "metrology/line_repeats.hpp"

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>

namespace ballbar {
namespace {

constexpr double kUm = 1e-6;

/// Points in steps of 0.1 m, deviations in micrometres.
std::vector<LinePoint> run_of(const std::vector<double>& um, std::size_t first = 0) {
  std::vector<LinePoint> points;
  for (std::size_t i = 0; i < um.size(); ++i)
    points.push_back({0.1 * static_cast<double>(first + i), um[i] * kUm, std::nullopt});
  return points;
}

/// A generator that shares nothing with the code: smooth curve, constant, slope, scatter.
LineRuns runs_of(std::mt19937& random, int runs, int points, double constant, double slope, double bow,
                 double run_scatter, double point_scatter) {
  std::normal_distribution<double> normal;
  LineRuns all;
  for (int j = 0; j < runs; ++j) {
    const double shift = run_scatter * normal(random);
    std::vector<double> um;
    for (int i = 0; i < points; ++i) {
      const double along = i / (points - 1.0) - 0.5;  // -0.5 .. 0.5
      um.push_back(constant + slope * along + bow * along * along + shift + point_scatter * normal(random));
    }
    all.push_back(run_of(um));
  }
  return all;
}

TEST(BidirectionalFigures, AreThoseOfATableThatOneCanDoByHand) {
  // Three points, two runs a way. Means (1, 4, 1) and (-1, -2, -3); sd of two values = difference / sqrt 2.
  // (forward + backward) / 2 = (0, 1, -1): line 0.0, slope -5 um/m about 0.1 m: (0.5, 0, -0.5).
  const LineRuns forward{run_of({0, 4, 2}), run_of({2, 4, 0})};
  const LineRuns backward{run_of({-1, -3, -3}), run_of({-1, -1, -3})};
  const auto found = bidirectional_figures(forward, backward);
  ASSERT_TRUE(found);
  ASSERT_EQ(found->points.size(), 3U);
  const double s = std::sqrt(2.0);
  struct Row {
    double forward, backward, forward_sd, backward_sd, reversal, repeatability;
  };
  const std::array<Row, 3> rows{Row{0.5, -1.5, s, 0, 2, 4 * s}, Row{4, -2, 0, s, 6, 2 * s + 6},
                                Row{1.5, -2.5, s, 0, 4, 2 * s + 4}};
  for (std::size_t i = 0; i < 3; ++i) {
    const BidirectionalPoint& p = found->points[i];
    EXPECT_NEAR(p.position, 0.1 * static_cast<double>(i), 1e-12);
    EXPECT_NEAR(p.forward, rows[i].forward * kUm, 1e-15);
    EXPECT_NEAR(p.backward, rows[i].backward * kUm, 1e-15);
    EXPECT_NEAR(p.forward_sd, rows[i].forward_sd * kUm, 1e-15);
    EXPECT_NEAR(p.backward_sd, rows[i].backward_sd * kUm, 1e-15);
    EXPECT_NEAR(p.reversal, rows[i].reversal * kUm, 1e-15);
    EXPECT_NEAR(p.repeatability, rows[i].repeatability * kUm, 1e-15);
  }
  EXPECT_NEAR(found->reference_slope, -5 * kUm, 1e-15);
  EXPECT_NEAR(found->reversal, 6 * kUm, 1e-15);
  EXPECT_NEAR(found->reversal_mean, 4 * kUm, 1e-15);
  EXPECT_NEAR(found->forward_repeatability, 4 * s * kUm, 1e-15);
  EXPECT_NEAR(found->backward_repeatability, 4 * s * kUm, 1e-15);
  EXPECT_NEAR(found->repeatability, (6 + 2 * s) * kUm, 1e-15);
  EXPECT_NEAR(found->forward_systematic_deviation, 3.5 * kUm, 1e-15);
  EXPECT_NEAR(found->backward_systematic_deviation, 1.0 * kUm, 1e-15);
  EXPECT_NEAR(found->systematic_deviation, 6.5 * kUm, 1e-15);
  EXPECT_NEAR(found->mean_bidirectional_deviation, 1.5 * kUm, 1e-15) << "(-0.5, 1, -0.5)";
  EXPECT_NEAR(found->forward_accuracy, (1.5 + 2 * s - (0.5 - 2 * s)) * kUm, 1e-15);
  EXPECT_NEAR(found->backward_accuracy, (-2 + 2 * s - (-2 - 2 * s)) * kUm, 1e-15);
  EXPECT_NEAR(found->accuracy, (1.5 + 2 * s - (-2 - 2 * s)) * kUm, 1e-15);
}

TEST(BidirectionalFigures, DoNotFeelTheZeroAndTheSlopeOfTheOptics) {
  std::mt19937 random(3);
  LineRuns forward = runs_of(random, 5, 21, 10, 30, 40, 1.0, 0.5);
  LineRuns backward = runs_of(random, 5, 21, -10, 20, 35, 1.0, 0.5);
  const auto before = bidirectional_figures(forward, backward);
  for (LineRuns* runs : {&forward, &backward})
    for (std::vector<LinePoint>& run : *runs)
      for (LinePoint& p : run) p.deviation += 500 * kUm - 700 * kUm * p.position;
  const auto after = bidirectional_figures(forward, backward);
  ASSERT_TRUE(before && after);
  EXPECT_NEAR(after->reference_slope - before->reference_slope, -700 * kUm, 1e-13);
  EXPECT_NEAR(after->accuracy, before->accuracy, 1e-14);
  EXPECT_NEAR(after->systematic_deviation, before->systematic_deviation, 1e-14);
  EXPECT_NEAR(after->mean_bidirectional_deviation, before->mean_bidirectional_deviation, 1e-14);
  EXPECT_NEAR(after->repeatability, before->repeatability, 1e-14);
  EXPECT_GE(after->accuracy, after->systematic_deviation);
  EXPECT_GE(after->systematic_deviation, after->mean_bidirectional_deviation);
}

TEST(BidirectionalFigures, AreOfThePointsThatWereMeasuredTwiceBothWays) {
  const LineRuns forward{run_of({1, 2, 3, 4, 5}), run_of({1, 2, 3, 4, 5})};
  const LineRuns backward{run_of({1, 2, 3, 4}, 1), run_of({2, 3, 4}, 2)};
  const auto found = bidirectional_figures(forward, backward);
  ASSERT_TRUE(found);
  EXPECT_EQ(found->points.size(), 3U);
  EXPECT_NEAR(found->points.front().position, 0.2, 1e-12);
  EXPECT_FALSE(bidirectional_figures(forward, {backward[1]})) << "one run does not scatter";
  EXPECT_FALSE(bidirectional_figures(forward, {}));
  EXPECT_FALSE(bidirectional_figures({}, {}));
  EXPECT_THROW(bidirectional_figures({run_of({1, std::nan(""), 2})}, backward), std::invalid_argument);
}

TEST(BundleDifference, IsTakenApartIntoConstantSlopeAndShape) {
  struct Case {
    const char* name;
    double constant, slope, bow;  // um, of forward - backward over the whole line
  };
  for (const Case& c : {Case{"constant", 12, 0, 0}, Case{"slope", 0, -180, 0}, Case{"bow", 0, 0, 60},
                        Case{"all", 5, 30, 20}}) {
    SCOPED_TRACE(c.name);
    std::mt19937 random(1);
    const LineRuns forward = runs_of(random, 3, 51, 7 + c.constant, 90 + c.slope, 300 + c.bow, 0, 0);
    const LineRuns backward = runs_of(random, 3, 51, 7, 90, 300, 0, 0);
    const auto found = difference_of(forward, backward);
    ASSERT_TRUE(found);
    // The same from sums over the points: 1, t and t^2 on -0.5..0.5, t^2 = its mean + what is left.
    double mean_square = 0.0, t2 = 0.0, t4 = 0.0;
    for (int i = 0; i < 51; ++i) {
      const double t = i / 50.0 - 0.5, d = c.constant + c.slope * t + c.bow * t * t;
      mean_square += d * d / 51, t2 += t * t / 51, t4 += t * t * t * t / 51;
    }
    const double constant = c.constant + c.bow * t2, shape = std::abs(c.bow) * std::sqrt(t4 - t2 * t2);
    EXPECT_EQ(found->points, 51);
    EXPECT_NEAR(found->constant.value, constant * kUm, 1e-14);
    EXPECT_NEAR(found->slope.value, c.slope * kUm / 5.0, 1e-14) << "the line is 5 m long";
    EXPECT_NEAR(found->shape, shape * kUm, 1e-13);
    EXPECT_NEAR(found->constant_share, constant * constant / mean_square, 1e-9);
    EXPECT_NEAR(found->slope_share, c.slope * c.slope * t2 / mean_square, 1e-9);
    EXPECT_NEAR(found->shape_share, shape * shape / mean_square, 1e-9);
    EXPECT_NEAR(found->constant_share + found->slope_share + found->shape_share, 1.0, 1e-12);
    EXPECT_NEAR(found->shape_by_chance.value(), 0.0, 1e-13);
  }
}

TEST(BundleDifference, HasStandardDeviationsThatCoverTheTruth) {
  // Runs shift as a whole (1 um) and point by point (0.3 um); nothing separates the bundles.
  int constant_hits = 0, slope_hits = 0;
  double constant_variance = 0.0, constant_estimated = 0.0, shape = 0.0, by_chance = 0.0;
  const int cases = 1000;
  for (unsigned seed = 1; seed <= cases; ++seed) {
    std::mt19937 random(seed);
    const LineRuns forward = runs_of(random, 5, 21, 0, 0, 50, 1.0, 0.3);
    const LineRuns backward = runs_of(random, 5, 21, 0, 0, 50, 1.0, 0.3);
    const auto found = difference_of(forward, backward);
    ASSERT_TRUE(found && found->constant.sd && found->slope.sd);
    // Student's t with 8 degrees of freedom: 2.306 for 95 %.
    constant_hits += std::abs(found->constant.value) < 2.306 * *found->constant.sd;
    slope_hits += std::abs(found->slope.value) < 2.306 * *found->slope.sd;
    constant_variance += found->constant.value * found->constant.value / cases;
    constant_estimated += *found->constant.sd * *found->constant.sd / cases;
    shape += found->shape * found->shape / cases;
    by_chance += *found->shape_by_chance * *found->shape_by_chance / cases;
  }
  EXPECT_NEAR(constant_hits, 950, 28) << "four binomial standard deviations";
  EXPECT_NEAR(slope_hits, 950, 28);
  EXPECT_NEAR(constant_variance / constant_estimated, 1.0, 0.2);
  EXPECT_NEAR(shape / by_chance, 1.0, 0.05);
}

TEST(BundleDifference, SaysSoWhereItCannotTell) {
  EXPECT_FALSE(difference_of({run_of({1, 2, 3})}, {run_of({1, 2})}));
  EXPECT_FALSE(difference_of({run_of({1, 2, 3})}, {}));
  const auto single = difference_of({run_of({1, 2, 4})}, {run_of({1, 2, 3})});
  ASSERT_TRUE(single);
  EXPECT_FALSE(single->constant.sd) << "one run does not scatter";
  EXPECT_FALSE(single->shape_by_chance);
  const auto holed =
      difference_of({run_of({1, 2, 4, 5}), run_of({1, 2, 4})}, {run_of({1, 2, 3, 4}), run_of({1, 2, 3, 4})});
  ASSERT_TRUE(holed);
  EXPECT_EQ(holed->points, 4);
  EXPECT_FALSE(holed->slope.sd) << "a run lacks a point";
  const auto same = difference_of({run_of({1, 2, 4})}, {run_of({1, 2, 4})});
  EXPECT_EQ(same->constant_share + same->slope_share + same->shape_share, 0.0);
}

TEST(StopPoses, InOneDirectionAreThoseOfATableThatOneCanDoByHand) {
  // All readings: 0 at the ends, (3, 5, 4) in the middle forward, (-4, -4, -4) backward; line: y = 0.
  const LineRuns forward{run_of({0, 3, 0}), run_of({0, 5, 0}), run_of({0, 4, 0})};
  const LineRuns backward{run_of({0, -4, 0}), run_of({0, -4, 0}), run_of({0, -4, 0})};
  const std::vector<StopPose> poses = stop_poses(forward, backward);
  ASSERT_EQ(poses.size(), 6U);
  EXPECT_EQ(poses[1].direction, 1);
  EXPECT_EQ(poses[1].runs, 3);
  EXPECT_NEAR(poses[1].position, 0.1, 1e-12);
  EXPECT_NEAR(poses[1].accuracy, 4 * kUm, 1e-15);
  // Distances 1, 1, 0: mean 2/3, sd sqrt(1/3).
  EXPECT_NEAR(poses[1].repeatability.value(), (2.0 / 3.0 + 3 * std::sqrt(1.0 / 3.0)) * kUm, 1e-15);
  EXPECT_EQ(poses[4].direction, -1);
  EXPECT_NEAR(poses[4].accuracy, 4 * kUm, 1e-15);
  EXPECT_NEAR(poses[4].repeatability.value(), 0.0, 1e-15);
  EXPECT_NEAR(poses[5].accuracy, 0.0, 1e-15);
}

TEST(StopPoses, InTwoDirectionsAreDistancesInThePlane) {
  // About the lines: (3, 4), (-3, 4), (3, -4), (-3, -4) in the middle: each 5 from their mean, which is 0.
  const LineRuns x{run_of({0, 3, 0}), run_of({0, -3, 0}), run_of({0, 3, 0}), run_of({0, -3, 0})};
  const LineRuns z{run_of({0, 4, 0}), run_of({0, 4, 0}), run_of({0, -4, 0}), run_of({0, -4, 0})};
  const std::vector<StopPose> poses = stop_poses(x, {}, z, {});
  ASSERT_EQ(poses.size(), 3U);
  EXPECT_NEAR(poses[1].accuracy, 0.0, 1e-15);
  EXPECT_NEAR(poses[1].repeatability.value(), 5 * kUm, 1e-15);
  EXPECT_THROW(stop_poses(x, {}, {z[0]}, {}), std::invalid_argument);
}

TEST(StopPoses, AreOfTheRunsThatStoppedThere) {
  const LineRuns forward{run_of({1, 2, 1, 2}), run_of({2, 1}, 1)};
  const std::vector<StopPose> poses = stop_poses(forward, {});
  ASSERT_EQ(poses.size(), 4U);
  EXPECT_EQ(poses[0].runs, 1);
  EXPECT_FALSE(poses[0].repeatability);
  EXPECT_EQ(poses[1].runs, 2);
  EXPECT_TRUE(stop_poses({run_of({1, 2})}, {}).empty());
  EXPECT_TRUE(stop_poses({}, {}).empty());
}

}  // namespace
}  // namespace ballbar
