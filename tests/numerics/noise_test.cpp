// The noise that was put in comes out, whatever shape it rides on.

#include "numerics/noise.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

namespace ballbar {
namespace {

Eigen::VectorXd noisy(double sd, const std::function<double(int)>& shape) {
  std::mt19937_64 random(5);
  std::normal_distribution<double> white(0.0, sd);
  Eigen::VectorXd values(3000);
  for (int i = 0; i < values.size(); ++i) values[i] = shape(i) + white(random);
  return values;
}

TEST(SampleNoise, FindsWhiteNoiseUnderSlowShapesStepsAndSpikes) {
  SCOPED_TRACE("seed 5");
  // 5 %: three standard deviations of the median of 3000 differences
  EXPECT_NEAR(sample_noise(noisy(0.7, [](int) { return 0.0; })), 0.7, 0.035);
  EXPECT_NEAR(sample_noise(noisy(0.7, [](int i) { return 200.0 * std::sin(0.004 * i); })), 0.7, 0.035);
  EXPECT_NEAR(sample_noise(noisy(0.7, [](int i) { return i / 500 % 2 ? 30.0 : 0.0; })), 0.7, 0.035);
  EXPECT_NEAR(sample_noise(noisy(0.7, [](int i) { return i % 100 == 0 ? 50.0 : 0.0; })), 0.7, 0.08);
}

TEST(SampleNoise, IsZeroWhereThereIsNone) {
  EXPECT_EQ(sample_noise(Eigen::VectorXd::LinSpaced(100, 0.0, 1.0)) < 1e-15, true);
  EXPECT_EQ(sample_noise(Eigen::VectorXd::Zero(2)), 0.0);
}

}  // namespace
}  // namespace ballbar
