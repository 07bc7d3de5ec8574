// Speeds and accelerations against motions whose derivatives are known.

#include "physics/derivatives.hpp"

#include <gtest/gtest.h>

#include <random>

#include "physics/physics_test.hpp"

namespace ballbar {
namespace {

TEST(Derivatives, AreExactForParabolasOnAnyTimeGrid) {
  std::mt19937_64 random(11);
  SCOPED_TRACE("random 11");
  std::uniform_real_distribution<double> step(0.001, 0.030);  // some windows hold dozens, some 5 samples
  for (const int n : {3, 4, 5, 200}) {
    Motion motion{Eigen::VectorXd(n), Eigen::MatrixXd(2, n)};
    double t = 100.0;
    for (int k = 0; k < n; ++k, t += step(random)) {
      motion.time(k) = t;
      const double u = t - 101.0;
      motion.q.col(k) << 0.3 - 0.2 * u + 0.7 * u * u, 1.5 + 0.4 * u;
    }
    const Derivatives got = derivatives(motion);
    for (int k = 0; k < n; ++k) {
      const double u = motion.time(k) - 101.0;
      EXPECT_NEAR(got.speed(0, k), -0.2 + 1.4 * u, 1e-10) << n << " samples, " << k;
      EXPECT_NEAR(got.speed(1, k), 0.4, 1e-10);
      EXPECT_NEAR(got.acceleration(0, k), 1.4, 1e-8);
      EXPECT_NEAR(got.acceleration(1, k), 0.0, 1e-8);
    }
  }
}

TEST(Derivatives, OfOneOrTwoSamplesAreWhatCanBeKnown) {
  EXPECT_EQ(derivatives({Eigen::VectorXd::Zero(1), Eigen::MatrixXd::Ones(2, 1)}).speed.norm(), 0.0);
  const Derivatives two = derivatives(test::single(2, 10, [](double t) { return 3.0 * t; }));
  EXPECT_NEAR(two.speed(0, 1), 3.0, 1e-12);
  EXPECT_EQ(two.acceleration(0, 1), 0.0);
}

TEST(Derivatives, OfAJointThatStandsAreZero) {
  const Derivatives got = derivatives(test::single(50, 125, [](double) { return 0.123456789; }));
  EXPECT_EQ(got.speed.norm(), 0.0);
  EXPECT_EQ(got.acceleration.norm(), 0.0);
}

TEST(Derivatives, OfASineLoseWhatTheWindowSays) {
  for (const double w : {0.5, 3.0, 10.0}) {
    const Derivatives got = derivatives(test::single(2000, 500, [&](double t) { return std::sin(w * t); }));
    const double loss = w * w * 0.08 * 0.08 / 40.0;
    for (int k = 100; k < 1900; ++k)
      EXPECT_NEAR(got.speed(0, k), w * std::cos(w * k / 500.0) * (1.0 - loss), w * (0.1 * loss + 1e-6));
  }
}

TEST(Derivatives, OfRoundedReadingsScatterAsStated) {
  const double step = 17.5e-6;
  std::mt19937_64 random(3);
  SCOPED_TRACE("random 3");
  std::uniform_real_distribution<double> place(
      0.0, step);  // dithered: rounding errors of neighbours are independent
  Motion motion = test::single(4000, 125, [](double t) { return 0.3 * std::sin(0.5 * t); });
  for (int k = 0; k < 4000; ++k) {
    const double dither = place(random);
    motion.q(0, k) = step * std::round((motion.q(0, k) + dither) / step) - dither;
  }
  const Derivatives got = derivatives(motion);
  double sum = 0.0;
  for (int k = 10; k < 3990; ++k)
    sum += std::pow(got.acceleration(0, k) + 0.075 * std::sin(0.5 * motion.time(k)), 2);
  const double stated = step / std::sqrt(12.0) * std::sqrt(720.0 / 11.0) / (0.08 * 0.08);
  EXPECT_NEAR(std::sqrt(sum / 3980), stated, 0.2 * stated);
}

}  // namespace
}  // namespace ballbar
