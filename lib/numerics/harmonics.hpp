#pragma once
/// Harmonics of a quantity over an angle, by least squares on the true angles: no grid, no full turn is
/// needed.

#include <Eigen/Core>

#include "numerics/fit_status.hpp"

namespace ballbar {

/// value = mean + sum over k = 1..order of cos(k) cos(k angle) + sin(k) sin(k angle) + residual.
struct HarmonicFit {
  FitStatus status = FitStatus::kTooFewPoints;  ///< kOk or kTooFewPoints (fewer than two samples)
  int order = 0;                                ///< K, the highest order that the angles carry
  Eigen::VectorXd coefficients;  ///< 2K+1: mean, cos 1, sin 1, cos 2, sin 2, ... [unit of value]
  Eigen::MatrixXd covariance;    ///< (2K+1) x (2K+1), same sequence, inflation included
  Eigen::VectorXd residual;      ///< one per sample, in the sequence of the samples
  double residual_sd = 0.0;      ///< sqrt(RSS / (n - 2K - 1))
  double inflation = 1.0;        ///< >= 1; factor on the covariance for correlated residuals

  double mean() const { return coefficients[0]; }
  double cos(int k) const { return coefficients[2 * Eigen::Index{k} - 1]; }
  double sin(int k) const { return coefficients[2 * Eigen::Index{k}]; }
};

/// The orthonormal basis of one set of angles; as many fits on it as one likes.
///
/// The order K is the largest <= max_order with 2K+1 <= n-1 for which no coefficient of the model of orders
/// 0..K has a standard deviation above kWorstDilution times that of n samples spread evenly over a turn
/// (1/sqrt(n) for the mean, sqrt(2/n) for the others, per unit noise). So an order that a partial arc or a
/// hole cannot carry is refused.
class HarmonicBasis {
 public:
  static constexpr double kWorstDilution = 5.0;

  /// @param angle      n values [rad], any sequence, any number of turns
  /// @param max_order  >= 0
  /// @throws std::invalid_argument where an angle is not finite or max_order is negative
  HarmonicBasis(const Eigen::VectorXd& angle, int max_order);

  int order() const { return order_; }  ///< K; -1 where there are fewer than two samples

  /// The least-squares coefficients alone. @param value n values @return 2K+1: mean, cos 1, sin 1, ...
  Eigen::VectorXd coefficients(const Eigen::VectorXd& value) const;

  /// The whole fit. @param value n values, in sequence of time (for the correlation of the residuals)
  /// @throws std::invalid_argument for another count or a value that is not finite
  HarmonicFit fit(const Eigen::VectorXd& value) const;

 private:
  Eigen::Index samples_ = 0;
  int order_ = -1;
  Eigen::MatrixXd columns_;    // n x (2K+1): 1, cos, sin, cos 2, sin 2, ...
  Eigen::MatrixXd q_;          // n x (2K+1), orthonormal
  Eigen::MatrixXd r_inverse_;  // (2K+1) x (2K+1), upper triangular
};

/// HarmonicBasis(angle, max_order).fit(value).
HarmonicFit fit_harmonics(const Eigen::VectorXd& angle, const Eigen::VectorXd& value, int max_order);

/// Variance of a mean of correlated values over that of independent ones: 1 + 2 sum of the autocorrelations
/// from lag 1 up to the first that is not positive (the initial positive sequence of Markov-chain practice,
/// Geyer 1992). At least 1. Harmonics that are slow against the correlation scale the same way; for faster
/// ones it is cautious. Noise as slow as the fitted harmonics themselves cannot be told from them: it is in
/// the coefficients, not in the residual, and not in this factor.
double autocorrelation_inflation(const Eigen::VectorXd& residual);

}  // namespace ballbar
