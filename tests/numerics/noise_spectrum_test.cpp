// The spectrum that the repeats were drawn from comes out, with honest standard deviations.

#include "numerics/noise_spectrum.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

#include "numerics/repeat_laps.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Coefficients drawn straight from a spectrum: no transform between truth and fit.
RepeatScatter draw(std::mt19937_64& random, const NoiseSpectrum& truth, const VectorXd& frequency, int laps) {
  std::normal_distribution<double> normal;
  RepeatScatter scatter{frequency, VectorXd::Zero(frequency.size()), laps - 1};
  for (Index i = 0; i < frequency.size(); ++i) {
    VectorXd lap(laps);
    for (double& v : lap) v = 12.0 + std::sqrt(truth.variance(frequency[i])) * normal(random);
    scatter.energy[i] = (lap.array() - lap.mean()).square().sum();
  }
  return scatter;
}

/// Of laps in the middles of equal parts of the arc.
RepeatScatter scatter_of(const CosineTransform& transform, const MatrixXd& laps) {
  return repeat_scatter(transform.frequency(), transform(laps));
}

VectorXd lap_frequency() { return CosineTransform(400, 1.0, 180.0).frequency(); }

/// Whittle's minus log likelihood, written out.
double minus_log_likelihood(const std::vector<RepeatScatter>& all, double a, double b, double h0) {
  double sum = 0.0;
  for (const RepeatScatter& r : all)
    for (Index i = 0; i < r.frequency.size(); ++i) {
      const double s = a + b / (1.0 + std::pow(r.frequency[i] / h0, 2));
      sum += 0.5 * (r.dof * std::log(s) + r.energy[i] / s);
    }
  return sum;
}

TEST(NoiseSpectrum, ComesOutWithHonestStandardDeviations) {
  const NoiseSpectrum truth{0.5, 20.0, 3.0};
  const int cases = 200;
  Vector3d sum = Vector3d::Zero(), squares = Vector3d::Zero();
  for (unsigned seed = 1; seed <= cases; ++seed) {
    std::mt19937_64 random(seed);
    std::vector<RepeatScatter> all;
    for (const int laps : {2, 2, 3, 5}) all.push_back(draw(random, truth, lap_frequency(), laps));
    const NoiseSpectrumFit fit = fit_noise_spectrum(all);
    ASSERT_EQ(fit.status, FitStatus::kOk) << "seed " << seed;
    const NoiseSpectrum& s = fit.spectrum;
    const Vector3d error(std::log(s.white / truth.white), std::log(s.slow / truth.slow),
                         std::log(s.corner / truth.corner));
    const Vector3d z = error.cwiseQuotient(fit.log_sd());
    sum += z;
    squares += z.cwiseAbs2();
  }
  for (int i = 0; i < 3; ++i) {
    // Mean within 4 / sqrt(200), mean square within 4 sqrt(2 / 200); both and a little skewness.
    EXPECT_NEAR(sum[i] / cases, 0.0, 0.3) << i;
    EXPECT_NEAR(squares[i] / cases, 1.0, 0.4) << i;
  }
}

TEST(NoiseSpectrum, IsOfOneLapHoweverManyLapsThereAre) {
  const NoiseSpectrum truth{2.0, 5.0, 6.0};
  for (const int laps : {2, 3, 10}) {
    SCOPED_TRACE("seed 4, laps " + std::to_string(laps));
    std::mt19937_64 random(4);
    std::vector<RepeatScatter> all;
    for (int i = 0; i < 20; ++i) all.push_back(draw(random, truth, lap_frequency(), laps));
    const NoiseSpectrumFit fit = fit_noise_spectrum(all);
    EXPECT_NEAR(fit.spectrum.white, truth.white, 4 * truth.white * fit.log_sd()[0]);
    EXPECT_LT(fit.log_sd()[0], 0.03);
    EXPECT_NEAR(fit.spectrum.variance(0.0), 7.0, 2.0);
  }
}

TEST(NoiseSpectrum, IsTwiceThatOfHalfTheDifferenceOfTwoLaps) {
  std::mt19937_64 random(8);
  const CosineTransform transform(400, 1.0, 180.0);
  const MatrixXd laps = RepeatLaps{0.7, 0.7, 0.97}.draw(random, 400, 2);
  const RepeatScatter scatter = scatter_of(transform, laps);
  const VectorXd half = transform(0.5 * (laps.col(0) - laps.col(1)));
  EXPECT_EQ(scatter.dof, 1);
  EXPECT_LT((scatter.energy - 2.0 * half.cwiseAbs2()).lpNorm<Eigen::Infinity>(), 1e-12);
}

TEST(NoiseSpectrum, IsLikelierThanTheTruthAndThanAllNeighboursWhateverTheTruthIs) {
  // A fit that gets stuck loses against the truth (physics-gap.md 6.8).
  int fits = 0;
  for (const double slow : {1e-3, 0.1, 1.0, 30.0, 1e3, 1e5})
    for (const double corner : {0.7, 3.0, 15.0, 60.0})
      for (unsigned seed = 1; seed <= 4; ++seed) {
        SCOPED_TRACE("slow " + std::to_string(slow) + " corner " + std::to_string(corner) + " seed " +
                     std::to_string(seed));
        const NoiseSpectrum truth{1.0, slow, corner};
        std::mt19937_64 random(seed);
        std::vector<RepeatScatter> all;
        for (int i = 0; i < 8; ++i) all.push_back(draw(random, truth, lap_frequency(), 2));
        const NoiseSpectrumFit fit = fit_noise_spectrum(all);
        ASSERT_EQ(fit.status, FitStatus::kOk);
        const NoiseSpectrum& s = fit.spectrum;
        const double found = minus_log_likelihood(all, s.white, s.slow, s.corner);
        // The faint prior may cost a little where the repeats know nothing.
        EXPECT_LT(found, minus_log_likelihood(all, truth.white, truth.slow, truth.corner) + 0.5);
        for (const double by : {0.5, 0.9, 1.1, 2.0}) {
          EXPECT_LT(found, minus_log_likelihood(all, s.white * by, s.slow, s.corner) + 0.5) << by;
          EXPECT_LT(found, minus_log_likelihood(all, s.white, s.slow * by, s.corner) + 0.5) << by;
          EXPECT_LT(found, minus_log_likelihood(all, s.white, s.slow, s.corner * by) + 0.5) << by;
        }
        for (const double z : fit.band_z) EXPECT_LT(std::abs(z), 5.0);
        ++fits;
      }
  EXPECT_EQ(fits, 96);
}

TEST(NoiseSpectrum, SaysWhichParameterTheRepeatsDoNotKnow) {
  std::mt19937_64 random(2);
  std::vector<RepeatScatter> all;
  for (int i = 0; i < 34; ++i) all.push_back(draw(random, {0.49, 0.0, 1.0}, lap_frequency(), 2));
  const NoiseSpectrumFit fit = fit_noise_spectrum(all);
  EXPECT_NEAR(fit.spectrum.white, 0.49, 0.03);
  EXPECT_GT(fit.log_sd()[2], 0.5) << "white noise has no corner";
  for (const double h : {0.0, 1.0, 5.0, 50.0}) EXPECT_NEAR(fit.spectrum.variance(h), 0.49, 0.15) << h;
}

TEST(NoiseSpectrum, OfArcsIsThatOfLapsInCyclesPerTurn) {
  std::mt19937_64 random(6);
  const RepeatLaps noise{0.3, 1.0, 0.9};
  std::vector<RepeatScatter> laps, arcs, both;
  for (int i = 0; i < 300; ++i) {
    laps.push_back(scatter_of(CosineTransform(400, 1.0, 180.0), noise.draw(random, 400, 2)));
    arcs.push_back(scatter_of(CosineTransform(244, 0.61, 180.0), noise.draw(random, 244, 2)));
    both.push_back(i % 2 ? laps.back() : arcs.back());
  }
  const double corner = fit_noise_spectrum(laps).spectrum.corner;
  // 12 %: four standard deviations of the difference. Counted in harmonics, it would be 39 % less.
  // AR(1): half of the density at h = 0 where cos(2 pi h / 400) = (4 rho - 1 - rho^2) / (2 rho).
  EXPECT_NEAR(corner, std::acos((4 * 0.9 - 1 - 0.81) / 1.8) * 400 / (2 * std::numbers::pi), 0.5);
  EXPECT_NEAR(fit_noise_spectrum(arcs).spectrum.corner, corner, 0.12 * corner);
  EXPECT_NEAR(fit_noise_spectrum(both).spectrum.corner, corner, 0.12 * corner);
}

TEST(NoiseSpectrum, KeepsItsUnit) {
  std::mt19937_64 random(9);
  const CosineTransform transform(300, 0.75, 120.0);
  const MatrixXd um = RepeatLaps{0.7, 1.1, 0.95}.draw(random, 300, 4);
  const NoiseSpectrum s = fit_noise_spectrum({scatter_of(transform, um)}).spectrum;
  const NoiseSpectrum si = fit_noise_spectrum({scatter_of(transform, 1e-6 * um)}).spectrum;
  EXPECT_NEAR(si.white * 1e12 / s.white, 1.0, 1e-6);
  EXPECT_NEAR(si.slow * 1e12 / s.slow, 1.0, 1e-6);
  EXPECT_NEAR(si.corner / s.corner, 1.0, 1e-6);
}

TEST(NoiseSpectrum, FlagsTheBandThatItDoesNotDescribe) {
  // A line of 24.5 cycles per turn that comes and goes from lap to lap.
  std::mt19937_64 random(10);
  std::vector<RepeatScatter> all;
  for (int i = 0; i < 10; ++i) {
    all.push_back(draw(random, {1.0, 10.0, 3.0}, lap_frequency(), 2));
    all.back().energy[49] += 300.0;
  }
  const NoiseSpectrumFit fit = fit_noise_spectrum(all);
  EXPECT_GT(*std::max_element(fit.band_z.begin(), fit.band_z.end()), 9.0);
}

TEST(NoiseSpectrum, SaysSoWhereThereIsNothingToFit) {
  const CosineTransform transform(50, 1.0, 20.0);
  EXPECT_EQ(fit_noise_spectrum({}).status, FitStatus::kTooFewPoints);
  EXPECT_EQ(fit_noise_spectrum({{transform.frequency(), VectorXd::Zero(41), 0}}).status,
            FitStatus::kTooFewPoints);
  const MatrixXd same = VectorXd::LinSpaced(50, 0.1, 0.7).replicate(1, 3);
  EXPECT_EQ(fit_noise_spectrum({scatter_of(transform, same)}).status, FitStatus::kIllConditioned);
  EXPECT_THROW(scatter_of(transform, MatrixXd::Zero(50, 1)), std::invalid_argument);
  EXPECT_THROW(scatter_of(transform, MatrixXd::Constant(50, 2, std::nan(""))), std::invalid_argument);
  EXPECT_THROW(fit_noise_spectrum({{transform.frequency(), VectorXd::Ones(3), 1}}), std::invalid_argument);
  EXPECT_THROW(fit_noise_spectrum({{transform.frequency(), -VectorXd::Ones(41), 1}}), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
