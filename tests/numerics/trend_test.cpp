// Level, slope and control charts, worked out by hand or from their definitions.

#include "numerics/trend.hpp"

#include <gtest/gtest.h>

#include <Eigen/Cholesky>
#include <cmath>
#include <random>
#include <stdexcept>
#include <vector>

namespace ballbar {
namespace {

using Values = std::vector<double>;

TEST(Trend, MediansByHand) {
  EXPECT_EQ(median(Values{7}), 7.0);
  EXPECT_EQ(median(Values{3, 1, 2}), 2.0);
  EXPECT_EQ(median(Values{4, 1, 3, 2}), 2.5);
  // |x - 3| = 2 1 0 1 97; a normal value is nearer than 0.6744898 standard deviations in half of all cases.
  EXPECT_NEAR(median_spread(Values{1, 2, 3, 4, 100}), 1.0 / 0.6744897501960817, 1e-12);
  EXPECT_THROW(median(Values{}), std::invalid_argument);
  EXPECT_THROW(median_spread(Values{}), std::invalid_argument);
}

TEST(Trend, ASlopeByHandDoesNotMindAnOutlier) {
  // Slopes of the ten pairs: 1 six times, then 25 33 49 97; so few points bound the slope by none of them.
  const auto fit = theil_sen(Values{0, 1, 2, 3, 4}, Values{5, 6, 7, 8, 105});
  ASSERT_TRUE(fit);
  EXPECT_EQ(fit->slope, 1.0);
  EXPECT_EQ(fit->intercept, 5.0);
  EXPECT_EQ(fit->low, 1.0);
  EXPECT_EQ(fit->high, 97.0);
}

TEST(Trend, ASlopeNeedsFivePointsAtMoreThanOnePlace) {
  EXPECT_FALSE(theil_sen(Values{0, 1, 2, 3}, Values{0, 1, 2, 3}));
  EXPECT_FALSE(theil_sen(Values{2, 2, 2, 2, 2}, Values{0, 1, 2, 3, 4}));
  EXPECT_EQ(theil_sen(Values{0, 0, 1, 1, 1}, Values{3, 3, 5, 5, 5})->slope, 2.0) << "pairs of one x left out";
  EXPECT_THROW(theil_sen(Values{0, 1}, Values{0}), std::invalid_argument);
}

TEST(Trend, AWeightedMeanHasTheVarianceOfItsWeights) {
  EXPECT_EQ(ewma(Values{5, 7}, 1.0, 2.0, 1.0), (std::pair{7.0, 3.0})) << "only the last counts";
  const Values values{3.0, -1.0, 4.0, 1.5, 9.0};
  const double mean = 2.0, sd = 1.3, w = 0.2;
  double level = mean, variance = 0.0;
  for (std::size_t i = 0; i < values.size(); ++i) {
    const double weight = w * std::pow(1.0 - w, static_cast<double>(values.size() - 1 - i));
    level += weight * (values[i] - mean);
    variance += weight * weight * sd * sd;
  }
  const auto [found, distance] = ewma(values, mean, sd, w);
  EXPECT_NEAR(found, level, 1e-12);
  EXPECT_NEAR(distance, (level - mean) / std::sqrt(variance), 1e-12);
  EXPECT_EQ(ewma(Values{}, mean, sd, w), (std::pair{mean, 0.0}));
  for (const double wrong : {0.0, 1.5}) EXPECT_THROW(ewma(values, mean, sd, wrong), std::invalid_argument);
}

TEST(Trend, CumulativeSumsByHand) {
  // (x - 10) / 2 = 1 2 -1 -2: up 0.5 2 0.5 0, down 0 0 0.5 2.
  const Values values{12, 14, 8, 6};
  const double up[] = {0.5, 2.0, 0.5, 0.0}, down[] = {0.0, 0.0, 0.5, 2.0};
  for (std::size_t n = 1; n <= values.size(); ++n)
    EXPECT_EQ(cusum(std::span(values).first(n), 10.0, 2.0, 0.5), (std::pair{up[n - 1], down[n - 1]})) << n;
}

TEST(Trend, TheVectorSumByHandIsShortenedAtEachStep) {
  const std::vector<Eigen::Vector2d> pushed{{5.0, 1.0}, {1.0, 1.0}, {1.0, 1.0}};
  const Eigen::Vector2d mean(1.0, 1.0);
  const Eigen::Matrix2d covariance = 4.0 * Eigen::Matrix2d::Identity();  // 4 beside the mean is 2 of them
  const double length[] = {1.5, 1.0, 0.5};
  for (std::size_t n = 1; n <= pushed.size(); ++n)
    EXPECT_NEAR(vector_cusum(std::span(pushed).first(n), mean, covariance, 0.5), length[n - 1], 1e-12);
  EXPECT_EQ(vector_cusum(std::span(pushed).last(2), mean, covariance, 0.5), 0.0);
}

TEST(Trend, TheVectorSumIsThatOfWhitenedVectors) {
  constexpr unsigned kSeed = 11;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937_64 random(kSeed);
  std::normal_distribution<double> normal(0.7, 1.0);
  Eigen::Matrix2d covariance;
  covariance << 4.0, 1.5, 1.5, 1.0;
  const Eigen::Matrix2d root = covariance.llt().matrixL();
  std::vector<Eigen::Vector2d> white, vectors;
  for (int i = 0; i < 30; ++i) {
    white.emplace_back(normal(random), normal(random));
    vectors.push_back(root * white.back());
  }
  const double length = vector_cusum(white, Eigen::Vector2d::Zero(), Eigen::Matrix2d::Identity(), 0.5);
  EXPECT_GT(length, 5.0);
  EXPECT_NEAR(vector_cusum(vectors, Eigen::Vector2d::Zero(), covariance, 0.5), length, 1e-9);
}

}  // namespace
}  // namespace ballbar
