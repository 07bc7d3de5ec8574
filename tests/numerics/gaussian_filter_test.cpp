#include "numerics/gaussian_filter.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>
#include <random>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kTurn = 2.0 * std::numbers::pi;

VectorXd even(int n, double sweep = kTurn) { return VectorXd::LinSpaced(n + 1, 0.0, sweep).head(n); }

TEST(GaussianFilter, LetsHalfOfTheCutOffPassAndOthersByItsFormula) {
  for (const double cutoff : {15.0, 50.0, 150.0, 500.0})
    for (const int n : {3600, 8192, 20011}) {
      if (n < 8 * cutoff) continue;
      const VectorXd angle = even(n);
      for (const double order : {0.0, 1.0, 2.0, 15.0, 50.0, 150.0, 500.0, 900.0}) {
        const VectorXd wave = (order * angle.array() + 0.4).cos();
        const FilteredProfile filtered = gaussian_filter(angle, wave, cutoff);
        ASSERT_EQ(filtered.status, FitStatus::kOk);
        const double pass = std::pow(2.0, -std::pow(order / cutoff, 2));
        EXPECT_LT((filtered.value - pass * wave).cwiseAbs().maxCoeff(), 3e-4)
            << "order " << order << ", cut-off " << cutoff << ", n " << n;
      }
    }
}

/// The standard's weight function, sample by sample: O(n^2), with the period written out.
VectorXd by_definition(const VectorXd& angle, const VectorXd& value, double cutoff) {
  const double alpha = std::sqrt(std::log(2.0) / std::numbers::pi);
  const double wave = kTurn / cutoff;
  const Index n = angle.size();
  VectorXd filtered(n);
  for (Index i = 0; i < n; ++i) {
    double sum = 0.0, weights = 0.0;
    for (Index j = 0; j < n; ++j) {
      const double next = j + 1 < n ? angle[j + 1] : angle[0] + kTurn;
      const double before = j > 0 ? angle[j - 1] : angle[n - 1] - kTurn;
      const double apart = std::remainder(angle[j] - angle[i], kTurn);
      const double weight =
          (next - before) / 2.0 * std::exp(-std::numbers::pi * std::pow(apart / (alpha * wave), 2));
      sum += weight * value[j];
      weights += weight;
    }
    filtered[i] = sum / weights;
  }
  return filtered;
}

TEST(GaussianFilter, EqualsTheWeightFunctionSummedSampleBySampleOnUnevenAngles) {
  for (unsigned seed = 1; seed <= 5; ++seed) {
    std::mt19937 random(seed);
    std::uniform_real_distribution<double> uniform(-0.45, 0.45);
    const int n = 900;
    VectorXd angle = even(n);
    for (double& a : angle) a += uniform(random) * kTurn / n;
    if (angle[0] < 0.0) angle[0] = 0.0;
    VectorXd value(n);
    for (int i = 0; i < n; ++i)
      value[i] = 3.0 + std::cos(2 * angle[i]) + std::sin(9 * angle[i]) + uniform(random);
    for (const double cutoff : {15.0, 50.0}) {
      const FilteredProfile filtered = gaussian_filter(angle, value, cutoff);
      ASSERT_EQ(filtered.status, FitStatus::kOk);
      EXPECT_LT((filtered.value - by_definition(angle, value, cutoff)).cwiseAbs().maxCoeff(), 1e-3)
          << "seed " << seed << ", cut-off " << cutoff;
    }
  }
}

TEST(GaussianFilter, DoesNotCareAboutTurnSequenceOrDirection) {
  const VectorXd angle = even(1440);
  const VectorXd value = (3.0 * angle.array()).sin() + (40.0 * angle.array()).cos();
  const VectorXd filtered = gaussian_filter(angle, value, 15.0).value;
  const VectorXd turned = (angle.array() - 7.0 * kTurn).reverse();
  const VectorXd backwards = gaussian_filter(turned, value.reverse(), 15.0).value;
  EXPECT_LT((filtered - backwards.reverse()).cwiseAbs().maxCoeff(), 1e-9);
}

TEST(GaussianFilter, OnAPartialArcLeavesOutOneWavelengthAtEachEnd) {
  const double sweep = kTurn / 3.0;
  const VectorXd angle = even(1200, sweep).array() + 6.0;  // across the seam at a full turn
  const VectorXd wave = (30.0 * angle.array()).cos();
  const FilteredProfile filtered = gaussian_filter(angle, wave, 30.0);
  ASSERT_EQ(filtered.status, FitStatus::kOk);
  const double cut = kTurn / 30.0;
  int defined = 0;
  for (Index i = 0; i < angle.size(); ++i) {
    const double from_end = std::min(angle[i] - angle[0], angle[1199] - angle[i]);
    if (std::abs(from_end - cut) < 1e-9) continue;  // on the boundary either is right
    const bool inside = from_end > cut;
    EXPECT_EQ(static_cast<bool>(filtered.defined[static_cast<std::size_t>(i)]), inside) << i;
    EXPECT_EQ(std::isfinite(filtered.value[i]), inside) << i;
    if (!inside) continue;
    ++defined;
    EXPECT_NEAR(filtered.value[i], 0.5 * wave[i], 1e-4) << i;
  }
  EXPECT_NEAR(defined, 960, 2);
}

TEST(GaussianFilter, RefusesWhatItCannotCarry) {
  const VectorXd angle = even(100);
  EXPECT_EQ(gaussian_filter(angle, VectorXd::Zero(100), 14.0).status, FitStatus::kOk);
  EXPECT_EQ(gaussian_filter(angle, VectorXd::Zero(100), 15.0).status, FitStatus::kTooFewPoints);
  EXPECT_EQ(gaussian_filter(even(400, 0.5), VectorXd::Zero(400), 15.0).status, FitStatus::kTooFewPoints)
      << "an arc of less than two wavelengths";
  EXPECT_EQ(gaussian_filter(even(2), VectorXd::Zero(2), 1.0).status, FitStatus::kTooFewPoints);
  EXPECT_THROW(gaussian_filter(angle, VectorXd::Zero(99), 15.0), std::invalid_argument);
  EXPECT_THROW(gaussian_filter(angle, VectorXd::Zero(100), 0.0), std::invalid_argument);
  VectorXd bad = VectorXd::Zero(100);
  bad[3] = std::numeric_limits<double>::infinity();
  EXPECT_THROW(gaussian_filter(angle, bad, 15.0), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
