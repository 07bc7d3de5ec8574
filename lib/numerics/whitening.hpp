#pragma once
/// Evenly spaced samples as uncorrelated numbers of unit variance: harmonics over the standard deviation of
/// their noise.

#include <Eigen/Core>

namespace ballbar {

/// The orthonormal real discrete Fourier transform of n evenly spaced samples, of harmonics 0..K only, where
/// K is the largest with K <= n/2 and K/turns <= max_frequency.
///
/// Sequence of the rows: mean, cos 1, sin 1, cos 2, sin 2, ..., cos K, sin K; the last sine is missing where
/// K = n/2 (it is zero at every sample). White noise of variance v gives coefficients of variance v each,
/// whatever n is. Phases count from the first sample.
class RealDft {
 public:
  /// @param samples        n >= 1
  /// @param turns          n times the step between samples, in turns: 1 for a closed lap, less for an arc
  /// @param max_frequency  >= 0 [cycles per turn]
  /// @throws std::invalid_argument
  RealDft(Eigen::Index samples, double turns, double max_frequency);

  Eigen::Index samples() const { return samples_; }
  /// One per row [cycles per turn]: harmonic over turns.
  const Eigen::VectorXd& frequency() const { return frequency_; }

  /// @param values  n x m, a record per column @return rows x m
  /// @throws std::invalid_argument for another number of samples
  Eigen::MatrixXd operator()(const Eigen::MatrixXd& values) const;

 private:
  Eigen::Index samples_;
  Eigen::VectorXd frequency_;
  Eigen::MatrixXd cos_;  // (K + 1) x (n/2 + 1), for sums of the samples i and n - i
  Eigen::MatrixXd sin_;  // sines kept x (n - 1)/2, for their differences
};

/// Coefficients of `dft` over the standard deviation of their noise: where `variance` is that of the values'
/// noise, the result has noise of unit variance ("whitened: unit variance", physics-gap.md 5, step 1).
/// Columns of a model are whitened by the same call as the data.
/// @param values    n x m
/// @param variance  one per row of dft, > 0 [unit of the values, squared]
/// @throws std::invalid_argument for other sizes, or a variance that is not above zero or not finite
Eigen::MatrixXd whiten(const RealDft& dft, const Eigen::MatrixXd& values, const Eigen::VectorXd& variance);

}  // namespace ballbar
