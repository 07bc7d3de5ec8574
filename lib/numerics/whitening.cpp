#include "numerics/whitening.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <stdexcept>

namespace ballbar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

RealDft::RealDft(Index samples, double turns, double max_frequency) : samples_(samples) {
  if (samples < 1 || !std::isfinite(turns) || !(turns > 0.0) || !(max_frequency >= 0.0))
    throw std::invalid_argument("transform: no samples, no turn or a negative frequency");
  const Index n = samples;
  const Index highest = n / 2;
  // The rounding of turns must not cost the last harmonic.
  const auto order = static_cast<Index>(
      std::min(static_cast<double>(highest), std::floor(max_frequency * turns * (1 + 1e-9))));
  const Index sines = std::min(order, (n - 1) / 2);
  frequency_.resize(1 + order + sines);
  for (Index row = 0; row < frequency_.size(); ++row)
    frequency_[row] = std::ceil(0.5 * static_cast<double>(row)) / turns;
  cos_.resize(order + 1, n / 2 + 1);
  sin_.resize(sines, (n - 1) / 2);
  const auto angle = [n](Index k, Index i) {
    return 2.0 * std::numbers::pi * static_cast<double>(k * i % n) / static_cast<double>(n);
  };
  const double single = std::sqrt(1.0 / static_cast<double>(n));
  const double paired = std::sqrt(2.0 / static_cast<double>(n));
  for (Index i = 0; i < cos_.cols(); ++i)
    for (Index k = 0; k <= order; ++k)
      cos_(k, i) = (k == 0 || 2 * k == n ? single : paired) * std::cos(angle(k, i));
  for (Index i = 0; i < sin_.cols(); ++i)
    for (Index k = 0; k < sines; ++k) sin_(k, i) = paired * std::sin(angle(k + 1, i + 1));
}

MatrixXd RealDft::operator()(const MatrixXd& values) const {
  if (values.rows() != samples_) throw std::invalid_argument("transform: another number of samples");
  // Cosines are even about the first sample, sines are odd: half the products each.
  const Index pairs = (samples_ - 1) / 2;
  const auto mirrored = values.bottomRows(pairs).colwise().reverse();
  MatrixXd even = values.topRows(samples_ / 2 + 1);
  even.middleRows(1, pairs) += mirrored;
  const MatrixXd odd = values.middleRows(1, pairs) - mirrored;
  const MatrixXd cosines = cos_ * even;
  const MatrixXd sines = sin_ * odd;
  MatrixXd coefficients(frequency_.size(), values.cols());
  coefficients.row(0) = cosines.row(0);
  for (Index k = 1; k < cosines.rows(); ++k) coefficients.row(2 * k - 1) = cosines.row(k);
  for (Index k = 0; k < sines.rows(); ++k) coefficients.row(2 * k + 2) = sines.row(k);
  return coefficients;
}

MatrixXd whiten(const RealDft& dft, const MatrixXd& values, const VectorXd& variance) {
  if (variance.size() != dft.frequency().size() || !variance.allFinite() || !(variance.minCoeff() > 0.0))
    throw std::invalid_argument("whitening: a variance above zero for every coefficient is needed");
  return variance.cwiseSqrt().cwiseInverse().asDiagonal() * dft(values);
}

}  // namespace ballbar
