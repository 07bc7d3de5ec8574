#include "numerics/harmonics.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <limits>
#include <random>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using LongMatrix = Eigen::Matrix<long double, Eigen::Dynamic, Eigen::Dynamic>;
using LongVector = Eigen::Matrix<long double, Eigen::Dynamic, 1>;

VectorXd uneven_angles(int n, double sweep, std::mt19937& random) {
  std::uniform_real_distribution<double> uniform(0.0, 1.0);
  VectorXd angle(n);
  for (int i = 0; i < n; ++i) angle[i] = sweep * (i + 0.9 * uniform(random)) / n;
  return angle;
}

VectorXd noise(Index n, double sd, std::mt19937& random) {
  std::normal_distribution<double> normal(0.0, sd);
  return VectorXd::NullaryExpr(n, [&] { return normal(random); });
}

/// The twin: the columns as they are written, squared up, in long double.
LongMatrix dense_columns(const VectorXd& angle, int order) {
  LongMatrix columns(angle.size(), Index{2} * order + 1);
  columns.col(0).setOnes();
  for (Index i = 0; i < angle.size(); ++i)
    for (Index k = 1; k <= order; ++k) {
      columns(i, 2 * k - 1) = std::cos(k * static_cast<long double>(angle[i]));
      columns(i, 2 * k) = std::sin(k * static_cast<long double>(angle[i]));
    }
  return columns;
}

LongMatrix dense_inverse(const VectorXd& angle, int order) {
  const LongMatrix columns = dense_columns(angle, order);
  return (columns.transpose() * columns).fullPivLu().inverse();
}

/// The twin of the choice of order: from the largest down, the first that the rule of the header allows.
int highest_allowed_order(const VectorXd& angle, int max_order) {
  const Index n = angle.size();
  for (int order = max_order; order > 0; --order) {
    if (2 * order + 1 > n - 1) continue;
    const LongMatrix columns = dense_columns(angle, order);
    const Eigen::FullPivLU<LongMatrix> lu(columns.transpose() * columns);
    if (!lu.isInvertible()) continue;
    const LongVector variance = lu.inverse().diagonal();
    bool allowed = variance[0] <= 25.0L / n;
    for (Index k = 1; k < variance.size(); ++k) allowed = allowed && variance[k] <= 50.0L / n;
    if (allowed) return order;
  }
  return 0;
}

TEST(Harmonics, AreFoundExactlyOnUnevenAnglesWithoutNoise) {
  std::mt19937 random(1);
  const VectorXd angle = uneven_angles(300, 6.28, random);
  const VectorXd value =
      -7.0 + 3.0 * angle.array().cos() - 2.0 * (5.0 * angle.array()).sin() + (30.0 * angle.array()).cos();
  const HarmonicFit fit = fit_harmonics(angle, value, 30);
  ASSERT_EQ(fit.status, FitStatus::kOk);
  ASSERT_EQ(fit.order, 30);
  EXPECT_NEAR(fit.mean(), -7.0, 1e-13);
  EXPECT_NEAR(fit.cos(1), 3.0, 1e-13);
  EXPECT_NEAR(fit.sin(5), -2.0, 1e-13);
  EXPECT_NEAR(fit.cos(30), 1.0, 1e-13);
  EXPECT_NEAR(fit.cos(2), 0.0, 1e-13);
  EXPECT_LT(fit.residual.cwiseAbs().maxCoeff(), 1e-13);
}

TEST(Harmonics, EqualDenseNormalEquationsInLongDouble) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    std::mt19937 random(seed);
    const double sweep = 2.0 + 0.15 * seed;  // from a third of a turn to beyond one
    const VectorXd angle = uneven_angles(80, sweep, random);
    const VectorXd value = noise(80, 1.0, random);
    const HarmonicFit fit = fit_harmonics(angle, value, 8);
    const LongMatrix columns = dense_columns(angle, fit.order);
    const LongMatrix inverse = dense_inverse(angle, fit.order);
    const LongVector expected = inverse * (columns.transpose() * value.cast<long double>());
    EXPECT_LT((fit.coefficients - expected.cast<double>()).cwiseAbs().maxCoeff(), 1e-12) << "seed " << seed;
    const VectorXd residual = value - (columns * expected).cast<double>();
    const double variance = residual.squaredNorm() / (80 - 2 * fit.order - 1);
    EXPECT_NEAR(fit.residual_sd, std::sqrt(variance), 1e-12) << "seed " << seed;
    const MatrixXd covariance = variance * fit.inflation * inverse.cast<double>();
    EXPECT_LT((fit.covariance - covariance).cwiseAbs().maxCoeff(), 1e-12) << "seed " << seed;
  }
}

TEST(Harmonics, OfOrdersThatTheArcOrTheSamplingCannotCarryAreRefused) {
  std::mt19937 random(5);
  for (const int n : {6, 9, 20, 60, 400})
    for (int twentieths = 1; twentieths <= 42; ++twentieths) {
      const double turns = twentieths / 20.0;
      const VectorXd angle = uneven_angles(n, 2.0 * EIGEN_PI * turns, random);
      EXPECT_EQ(HarmonicBasis(angle, 12).order(), highest_allowed_order(angle, 12))
          << n << " samples on " << turns << " turns";
    }
}

TEST(Harmonics, OfAFullTurnAreAllCarriedAndOfAShortArcNone) {
  const auto order_on = [](double sweep_deg) {
    return HarmonicBasis(VectorXd::LinSpaced(2800, 0.0, sweep_deg * EIGEN_PI / 180.0), 30).order();
  };
  EXPECT_EQ(order_on(360.0), 30);
  EXPECT_EQ(order_on(60.0), 0);
  EXPECT_GE(order_on(220.0), 1);
  EXPECT_LT(order_on(220.0), 4);
}

TEST(Harmonics, NeverLeaveLessThanOneSampleToEstimateTheNoise) {
  const HarmonicFit fit = fit_harmonics(VectorXd::LinSpaced(8, 0.0, 5.5), VectorXd::Random(8), 30);
  EXPECT_EQ(fit.order, 3);  // 7 unknowns of 8 samples
  EXPECT_TRUE(fit.covariance.allFinite());
}

TEST(Harmonics, DoNotMindSeveralTurnsOrTheDirection) {
  std::mt19937 random(9);
  const VectorXd angle = uneven_angles(500, 25.0, random);
  const VectorXd value = 2.0 * (2.0 * angle.array()).cos() + 0.1 * noise(500, 1.0, random).array();
  const HarmonicFit there = fit_harmonics(angle, value, 5);
  const HarmonicFit back = fit_harmonics(angle.reverse(), value.reverse(), 5);
  EXPECT_NEAR(there.cos(2), 2.0, 0.03);
  EXPECT_LT((there.coefficients - back.coefficients).cwiseAbs().maxCoeff(), 1e-13);
}

struct NoiseCase {
  const char* name;
  double correlation;  // of neighbours, first-order autoregressive
  double low, high;    // allowed ratio of scatter to claim
};

void PrintTo(const NoiseCase& c, std::ostream* out) { *out << c.name; }

class HarmonicNoise : public testing::TestWithParam<NoiseCase> {};

TEST_P(HarmonicNoise, TheClaimedStandardDeviationsAreTheScatterOfRepeatedRuns) {
  const unsigned seed = 4711;
  std::mt19937 random(seed);
  const int repeats = 400;
  const VectorXd angle = uneven_angles(4000, 2.0 * EIGEN_PI, random);
  VectorXd scatter = VectorXd::Zero(7);
  VectorXd claimed = VectorXd::Zero(7);
  for (int r = 0; r < repeats; ++r) {
    VectorXd value = noise(4000, 1.0, random);
    for (int i = 1; i < 4000; ++i)
      value[i] = GetParam().correlation * value[i - 1] +
                 std::sqrt(1.0 - std::pow(GetParam().correlation, 2)) * value[i];
    const HarmonicFit fit = fit_harmonics(angle, value, 3);
    scatter += fit.coefficients.cwiseAbs2() / repeats;
    claimed += fit.covariance.diagonal() / repeats;
  }
  for (int k = 0; k < 7; ++k) {
    const double ratio = std::sqrt(scatter[k] / claimed[k]);
    EXPECT_GT(ratio, GetParam().low) << "coefficient " << k << ", seed " << seed;
    EXPECT_LT(ratio, GetParam().high) << "coefficient " << k << ", seed " << seed;
  }
}

// 400 runs give a standard deviation to 3.5 %; three times that, and what the estimate of the correlation
// adds.
INSTANTIATE_TEST_SUITE_P(Kinds, HarmonicNoise,
                         testing::Values(NoiseCase{"white", 0.0, 0.85, 1.1},
                                         NoiseCase{"slow", 0.9, 0.85, 1.2}),
                         [](const auto& param) { return param.param.name; });

TEST(Harmonics, OfCorrelatedNoiseWouldBeClaimedFourTimesTooSureWithoutTheInflation) {
  std::mt19937 random(3);
  VectorXd value = noise(20000, 1.0, random);
  EXPECT_LT(autocorrelation_inflation(value), 1.3);
  for (int i = 1; i < 20000; ++i) value[i] += 0.9 * value[i - 1];
  // An autoregression of 0.9 has a variance of its mean (1 + 0.9) / (1 - 0.9) = 19 times that of white noise.
  EXPECT_NEAR(autocorrelation_inflation(value), 19.0, 4.0);
  EXPECT_EQ(autocorrelation_inflation(VectorXd::Zero(10)), 1.0);
}

TEST(Harmonics, SaySoWhereThereAreTooFewSamples) {
  EXPECT_EQ(fit_harmonics(VectorXd(0), VectorXd(0), 3).status, FitStatus::kTooFewPoints);
  EXPECT_EQ(fit_harmonics(VectorXd::Zero(1), VectorXd::Zero(1), 3).status, FitStatus::kTooFewPoints);
  const HarmonicFit mean_only = fit_harmonics(VectorXd::Zero(2), Eigen::Vector2d(1.0, 3.0), 3);
  ASSERT_EQ(mean_only.status, FitStatus::kOk);
  EXPECT_EQ(mean_only.order, 0);
  EXPECT_NEAR(mean_only.mean(), 2.0, 1e-15);
}

TEST(Harmonics, RefuseWhatIsNotFiniteOrDoesNotFit) {
  const VectorXd good = VectorXd::LinSpaced(9, 0.0, 6.0);
  VectorXd bad = good;
  bad[3] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(fit_harmonics(bad, good, 2), std::invalid_argument);
  EXPECT_THROW(fit_harmonics(good, bad, 2), std::invalid_argument);
  EXPECT_THROW(fit_harmonics(good, VectorXd::Zero(8), 2), std::invalid_argument);
  EXPECT_THROW(fit_harmonics(good, good, -1), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
