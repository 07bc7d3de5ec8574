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

TEST(RealDft, KeepsLengthsAndAnglesWhenAllHarmonicsAreKept) {
  for (const Index n : {1, 2, 3, 4, 5, 7, 8, 30, 97, 400, 401}) {
    SCOPED_TRACE("samples " + std::to_string(n));
    const MatrixXd q = RealDft(n, 1.0, kAll)(MatrixXd::Identity(n, n));
    ASSERT_EQ(q.rows(), n);
    EXPECT_LT((q * q.transpose() - MatrixXd::Identity(n, n)).lpNorm<Eigen::Infinity>(), 1e-12);
  }
}

TEST(RealDft, EqualsTheSumsOfTheTextbook) {
  std::mt19937 random(3);
  std::normal_distribution<double> normal;
  for (const Index n : {2, 9, 12, 244, 400, 3000}) {
    SCOPED_TRACE("seed 3, samples " + std::to_string(n));
    MatrixXd values(n, 2);
    for (double& v : values.reshaped()) v = normal(random);
    const RealDft dft(n, 1.0, 180.0);
    const MatrixXd found = dft(values);
    for (Index row = 0; row < found.rows(); ++row) {
      const Index k = (row + 1) / 2;
      Eigen::RowVector2d sum = Eigen::RowVector2d::Zero();
      for (Index i = 0; i < n; ++i) {
        const double angle = 2.0 * std::numbers::pi * static_cast<double>(k * i % n) / static_cast<double>(n);
        sum += values.row(i) * (row > 0 && row % 2 == 0 ? std::sin(angle) : std::cos(angle));
      }
      const double norm = k == 0 || 2 * k == n ? 1.0 : 2.0;
      EXPECT_LT((found.row(row) - sum * std::sqrt(norm / static_cast<double>(n))).norm(), 1e-11) << row;
      EXPECT_EQ(dft.frequency()[row], static_cast<double>(k));
    }
  }
}

TEST(RealDft, CountsInCyclesPerTurnOnAnArcToo) {
  EXPECT_EQ(RealDft(400, 1.0, 180.0).frequency().size(), 361);
  // 0.29 * 100 rounds to less than 29.
  EXPECT_EQ(RealDft(200, 0.29, 100.0).frequency().size(), 1 + 2 * 29);
  const RealDft arc(244, 244.0 / 400.0, 180.0);  // the same step, 219.6 degrees
  EXPECT_EQ(arc.frequency().size(), 1 + 2 * 109);
  EXPECT_NEAR(arc.frequency()[2], 400.0 / 244.0, 1e-14);
  EXPECT_LE(arc.frequency().maxCoeff(), 180.0);
  EXPECT_EQ(RealDft(7, 1.0, 0.0).frequency().size(), 1) << "the mean alone";
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
    const RealDft dft(row.samples, static_cast<double>(row.samples) / 400.0, 180.0);
    std::vector<RepeatScatter> scatter;
    for (int i = 0; i < 34; ++i)
      scatter.push_back(repeat_scatter(dft, row.noise.draw(random, row.samples, row.laps)));
    const NoiseSpectrumFit fit = fit_noise_spectrum(scatter);
    ASSERT_EQ(fit.status, FitStatus::kOk);
    for (const double z : fit.band_z) EXPECT_LT(std::abs(z), 5.0);

    const VectorXd one_lap = fit.spectrum.variance(dft.frequency());
    const MatrixXd laps = row.noise.draw(random, row.samples, 34 * row.laps);
    MatrixXd means(row.samples, 34);
    for (Index i = 0; i < 34; ++i) means.col(i) = laps.middleCols(i * row.laps, row.laps).rowwise().mean();
    const MatrixXd single = whiten(dft, laps, one_lap);
    const MatrixXd mean = whiten(dft, means, one_lap / row.laps);
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
  EXPECT_THROW(RealDft(0, 1.0, 10.0), std::invalid_argument);
  EXPECT_THROW(RealDft(10, 0.0, 10.0), std::invalid_argument);
  EXPECT_THROW(RealDft(10, std::nan(""), 10.0), std::invalid_argument);
  EXPECT_THROW(RealDft(10, 1.0, -1.0), std::invalid_argument);
  const RealDft dft(10, 1.0, 2.0);
  EXPECT_THROW(dft(VectorXd::Zero(9)), std::invalid_argument);
  EXPECT_THROW(whiten(dft, VectorXd::Zero(10), VectorXd::Ones(4)), std::invalid_argument);
  EXPECT_THROW(whiten(dft, VectorXd::Zero(10), VectorXd::Zero(5)), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
