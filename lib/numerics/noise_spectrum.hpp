#pragma once
/// Level and colour of the noise, from laps that repeat each other.

#include <Eigen/Core>
#include <array>
#include <vector>

#include "numerics/fit_status.hpp"
#include "numerics/whitening.hpp"

namespace ballbar {

/// Variance of a coefficient (CosineTransform) of ONE lap's noise:
/// S(h) = white + slow / (1 + (h / corner)^2). That of the mean of n laps is S/n: for two laps,
/// physics-gap.md 5, step 1 writes S for that half. `slow` goes with the density of the samples, so it holds
/// only for the step that it was fitted at.
struct NoiseSpectrum {
  double white = 0.0;   ///< a [unit of the samples, squared]: the variance of white noise
  double slow = 0.0;    ///< b [unit of the samples, squared]
  double corner = 1.0;  ///< h0 [cycles per turn]

  double variance(double frequency) const {
    return white + slow / (1.0 + (frequency / corner) * (frequency / corner));
  }
  /// @param frequency  [cycles per turn] @return one per frequency, of one lap
  Eigen::VectorXd variance(const Eigen::VectorXd& frequency) const;
};

/// What the laps of one recording differ by.
struct RepeatScatter {
  Eigen::VectorXd frequency;  ///< [cycles per turn], one per coefficient
  Eigen::VectorXd energy;     ///< squares of the laps' coefficients about their mean, summed over the laps
  int dof = 0;                ///< laps - 1; energy / dof estimates the variance of one lap
};

/// @param frequency     [cycles per turn]
/// @param coefficients  one row per frequency, a lap per column
/// @throws std::invalid_argument for other sizes, fewer than two laps or a value that is not finite
RepeatScatter repeat_scatter(const Eigen::VectorXd& frequency, const Eigen::MatrixXd& coefficients);

/// Limits of the bands in which a spectrum is held against the repeats [cycles per turn] (physics-gap.md 5,
/// step 8); the last band is open.
inline constexpr std::array<double, 4> kNoiseBandBegin{0.0, 4.0, 12.0, 40.0};

struct NoiseSpectrumFit {
  FitStatus status = FitStatus::kTooFewPoints;  ///< kIllConditioned: the laps do not differ at all
  NoiseSpectrum spectrum;                       ///< of one lap
  Eigen::Matrix3d log_covariance;               ///< of log white, log slow, log corner
  /// (chi2 - dof) / sqrt(2 dof) of the repeats in each band under the fitted spectrum; 0 for a band without
  /// coefficients. Above 5 or so the three parameters do not describe this noise: results that lean on that
  /// band are too sure of themselves.
  std::array<double, 4> band_z{};

  Eigen::Vector3d log_sd() const { return log_covariance.diagonal().cwiseSqrt(); }
};

/// The spectrum under which the repeats are likeliest (Whittle 1953: coefficients independent, normal),
/// pooled over the recordings, which need the same step between samples but neither the same length nor the
/// same number of laps. Covariance from the curvature of the expected log likelihood. Where the repeats do
/// not know a parameter (`corner` of noise that is white), a faint prior of the logarithms decides: standard
/// deviation 5 of white and slow about robust first guesses, 2 of the corner about 5 cycles per turn; its
/// curvature is included, so such a parameter has a log_sd of that size. Deterministic.
///
/// Recordings without repeats contribute nothing, and with none at all the status is kTooFewPoints: which
/// level to assume then is the caller's matter, never one of the residuals of a fit (physics-gap.md 8.8).
/// @throws std::invalid_argument for sizes that do not match, or a value negative or not finite
NoiseSpectrumFit fit_noise_spectrum(const std::vector<RepeatScatter>& recordings);

}  // namespace ballbar
