// Evenly spaced samples become numbers of unit variance, on laps and on arcs.

#include "numerics/whitening.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <random>

#include "numerics/noise_spectrum.hpp"
#include "numerics/repeat_laps.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kAll = std::numeric_limits<double>::infinity();

TEST(CosineTransform, KeepsLengthsAndAnglesWhenAllHarmonicsAreKept) {
  for (const Index n : {1, 2, 3, 4, 5, 7, 8, 30, 97, 400, 401}) {
    SCOPED_TRACE("samples " + std::to_string(n));
    const MatrixXd q = CosineTransform(n, 1.0, kAll)(MatrixXd::Identity(n, n));
    ASSERT_EQ(q.rows(), n);
    EXPECT_LT((q * q.transpose() - MatrixXd::Identity(n, n)).lpNorm<Eigen::Infinity>(), 1e-12);
  }
}

TEST(CosineTransform, EqualsTheSumsOfTheTextbook) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (const Index n : {2, 9, 12, 244, 400, 1001}) {
    SCOPED_TRACE("seed 3, samples " + std::to_string(n));
    MatrixXd values(n, 2);
    for (double& v : values.reshaped()) v = normal(random);
    const CosineTransform transform(n, 1.0, 180.0);
    const MatrixXd found = transform(values);
    for (Index k = 0; k < found.rows(); ++k) {
      Eigen::RowVector2d sum = Eigen::RowVector2d::Zero();
      for (Index i = 0; i < n; ++i)
        sum += values.row(i) *
               std::cos(std::numbers::pi * static_cast<double>(k * (2 * i + 1)) / static_cast<double>(2 * n));
      EXPECT_LT((found.row(k) - sum * std::sqrt((k == 0 ? 1.0 : 2.0) / static_cast<double>(n))).norm(), 1e-11)
          << k;
      EXPECT_EQ(transform.frequency()[k], static_cast<double>(k) / 2.0);
    }
  }
}

/// What no function of these tests can be: a record with a step in its slope, ripple and a drift.
double record(double x) {
  return 200.0 * std::sin(4 * std::numbers::pi * x + 0.3) + 5.0 * std::cos(2 * std::numbers::pi * 56.3 * x) +
         30.0 * x + 8.0 * std::abs(x - 0.4);
}

TEST(CosineTransform, OfUnevenPlacesIsThatOfEvenOnes) {
  // As a bar's readings lie on a lap: nearly even, the first one anywhere, slow laps with many of them.
  for (const Index n : {860, 900, 1700, 2800, 5000}) {
    SCOPED_TRACE("seed 4, readings " + std::to_string(n));
    std::mt19937 random(4);
    std::uniform_real_distribution<double> jitter(-0.2, 0.2);
    VectorXd x(n), y(n);
    for (Index i = 0; i < n; ++i) {
      x[i] = (static_cast<double>(i) + 0.5 + jitter(random)) / static_cast<double>(n);
      y[i] = record(x[i]);
    }
    const CosineTransform fine(4000, 1.0, 180.0), coarse(400, 1.0, 180.0);
    VectorXd even(4000);
    for (Index i = 0; i < 4000; ++i) even[i] = record((static_cast<double>(i) + 0.5) / 4000.0);
    const VectorXd truth = std::sqrt(0.1) * fine(even);
    // 400 places: a unit of a value is 20 of a coefficient.
    EXPECT_LT((coarse.fit(x, y) - truth).head(300).lpNorm<Eigen::Infinity>() / 20.0, 0.01);
  }
}

TEST(CosineTransform, RefusesPlacesThatCannotCarryIt) {
  const CosineTransform transform(400, 1.0, 180.0);
  const VectorXd few = VectorXd::LinSpaced(790, 0.0, 1.0);
  EXPECT_THROW(transform.fit(few, few), std::invalid_argument);
  VectorXd x = VectorXd::LinSpaced(1000, 0.0, 1.0);
  EXPECT_THROW(transform.fit(x, few), std::invalid_argument);
  std::swap(x[4], x[5]);
  EXPECT_THROW(transform.fit(x, x), std::invalid_argument);
  x = VectorXd::LinSpaced(1000, 0.0, 1.1);
  EXPECT_THROW(transform.fit(x, x), std::invalid_argument);
}

TEST(CosineTransform, CountsInCyclesPerTurnOnAnArcToo) {
  EXPECT_EQ(CosineTransform(400, 1.0, 180.0).frequency().size(), 361);
  // 0.29 * 100 rounds to less than 29.
  EXPECT_EQ(CosineTransform(200, 0.29, 100.0).frequency().size(), 1 + 2 * 29);
  const CosineTransform arc(244, 244.0 / 400.0, 180.0);  // the same step, 219.6 degrees
  EXPECT_EQ(arc.frequency().size(), 1 + 219);
  EXPECT_NEAR(arc.frequency()[2], 400.0 / 244.0, 1e-14);
  EXPECT_LE(arc.frequency().maxCoeff(), 180.0);
  EXPECT_EQ(CosineTransform(7, 1.0, 0.0).frequency().size(), 1) << "the mean alone";
}

TEST(Whitening, GivesFreshLapsUnitVarianceUnderTheSpectrumOfOtherLaps) {
  // 34 recordings tell the spectrum; 34 others are whitened by it.
  struct Row {
    RepeatLaps noise;
    Index samples;
    int laps;
    const char* what;
  };
  for (const Row& row :
       {Row{{0.7, 0.7, 0.97}, 400, 2, "as in physics-gap.md 6"},
        Row{{0.7e-6, 1.4e-6, 0.9}, 400, 3, "metres, quicker"}, Row{{0.7, 0.0, 0.0}, 401, 2, "white"},
        Row{{3.5, 3.5, 0.97}, 244, 5, "five times as much, on arcs"}}) {
    SCOPED_TRACE(std::string(row.what) + ", seed 11");
    std::mt19937_64 random(11);
    const CosineTransform transform(row.samples, static_cast<double>(row.samples) / 400.0, 180.0);
    std::vector<RepeatScatter> scatter;
    for (int i = 0; i < 34; ++i)
      scatter.push_back(
          repeat_scatter(transform.frequency(), transform(row.noise.draw(random, row.samples, row.laps))));
    const NoiseSpectrumFit fit = fit_noise_spectrum(scatter);
    ASSERT_EQ(fit.status, FitStatus::kOk);
    for (const double z : fit.band_z) EXPECT_LT(std::abs(z), 5.0);

    const VectorXd one_lap = fit.spectrum.variance(transform.frequency());
    const MatrixXd laps = row.noise.draw(random, row.samples, 34 * row.laps);
    MatrixXd means(row.samples, 34);
    for (Index i = 0; i < 34; ++i) means.col(i) = laps.middleCols(i * row.laps, row.laps).rowwise().mean();
    const MatrixXd single = whiten(transform, laps, one_lap);
    const MatrixXd mean = whiten(transform, means, one_lap / row.laps);
    // Four standard deviations of a chi2 in either sample, and 4 % for a spectrum of three parameters.
    const auto allowed = [](const MatrixXd& m) {
      return 0.04 + 4.0 * std::sqrt(2.0 / static_cast<double>(m.size())) * std::sqrt(2.0);
    };
    for (const auto& [first, count] : {std::pair<Index, Index>{1, 8}, {9, 16}, {25, 56}, {81, 130}}) {
      const MatrixXd a = single.middleRows(first, count), b = mean.middleRows(first, count);
      EXPECT_NEAR(a.squaredNorm() / static_cast<double>(a.size()), 1.0, allowed(a)) << first;
      EXPECT_NEAR(b.squaredNorm() / static_cast<double>(b.size()), 1.0, allowed(b)) << first;
      const MatrixXd next = mean.middleRows(first + 1, count);
      EXPECT_NEAR(b.cwiseProduct(next).mean(), 0.0, allowed(b)) << "neighbours are uncorrelated";
    }
  }
}

TEST(Whitening, RefusesWhatMakesNoSense) {
  EXPECT_THROW(CosineTransform(0, 1.0, 10.0), std::invalid_argument);
  EXPECT_THROW(CosineTransform(10, 0.0, 10.0), std::invalid_argument);
  EXPECT_THROW(CosineTransform(10, std::nan(""), 10.0), std::invalid_argument);
  EXPECT_THROW(CosineTransform(10, 1.0, -1.0), std::invalid_argument);
  const CosineTransform transform(10, 1.0, 2.0);
  EXPECT_THROW(transform(VectorXd::Zero(9)), std::invalid_argument);
  EXPECT_THROW(whiten(transform, VectorXd::Zero(10), VectorXd::Ones(4)), std::invalid_argument);
  EXPECT_THROW(whiten(transform, VectorXd::Zero(10), VectorXd::Zero(5)), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
