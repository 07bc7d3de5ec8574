#include "numerics/noise_spectrum.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// All coefficients of one frequency, of all recordings: together they are as good as singly.
struct Bin {
  double frequency, energy, dof;
};

std::vector<Bin> pooled(const std::vector<RepeatScatter>& recordings) {
  std::map<double, Bin> bins;
  for (const RepeatScatter& r : recordings) {
    if (r.energy.size() != r.frequency.size() || r.dof < 0)
      throw std::invalid_argument("noise spectrum: as many energies as frequencies are needed");
    if (!r.energy.allFinite() || !r.frequency.allFinite() || (r.energy.array() < 0.0).any() ||
        (r.frequency.array() < 0.0).any())
      throw std::invalid_argument("noise spectrum: an energy or a frequency is negative or not finite");
    if (r.dof == 0) continue;
    for (Index i = 0; i < r.frequency.size(); ++i) {
      Bin& bin = bins.try_emplace(r.frequency[i], Bin{r.frequency[i], 0.0, 0.0}).first->second;
      bin.energy += r.energy[i];
      bin.dof += r.dof;
    }
  }
  std::vector<Bin> all;
  all.reserve(bins.size());
  for (const auto& [frequency, bin] : bins) all.push_back(bin);
  return all;
}

/// Median of energy / dof over the bins from `begin` up to `end`, over the median of chi2 / dof (Wilson and
/// Hilferty 1931).
double median_level(const std::vector<Bin>& bins, std::size_t begin, std::size_t end) {
  std::vector<double> level;
  for (std::size_t i = begin; i < end; ++i)
    level.push_back(bins[i].energy / bins[i].dof / std::pow(1.0 - 2.0 / (9.0 * bins[i].dof), 3));
  const auto middle = level.begin() + static_cast<std::ptrdiff_t>(level.size() / 2);
  std::nth_element(level.begin(), middle, level.end());
  return *middle;
}

NoiseSpectrum spectrum_of(const Vector3d& log) {
  return {std::exp(log[0]), std::exp(log[1]), std::exp(log[2])};
}

/// Minus log posterior of the three logarithms, its slope and its expected curvature.
class Likelihood {
 public:
  Likelihood(const std::vector<Bin>& bins, const Vector3d& centre) : bins_(bins), centre_(centre) {}

  double value(const Vector3d& log) const {
    const NoiseSpectrum s = spectrum_of(log);
    double sum = 0.5 * kFaint.cwiseProduct(log - centre_).squaredNorm();
    for (const Bin& bin : bins_) {
      const double variance = s.variance(bin.frequency);
      sum += 0.5 * (bin.dof * std::log(variance) + bin.energy / variance);
    }
    return sum;
  }

  void derivatives(const Vector3d& log, Vector3d& slope, Matrix3d& curvature) const {
    const NoiseSpectrum s = spectrum_of(log);
    const Vector3d faint = kFaint.cwiseAbs2();
    slope = faint.cwiseProduct(log - centre_);
    curvature = faint.asDiagonal();
    for (const Bin& bin : bins_) {
      const double ratio = (bin.frequency / s.corner) * (bin.frequency / s.corner);
      const double low = s.slow / (1.0 + ratio);
      const double variance = s.white + low;
      const Vector3d share = Vector3d(s.white, low, low * 2.0 * ratio / (1.0 + ratio)) / variance;
      slope += 0.5 * (bin.dof - bin.energy / variance) * share;
      curvature += 0.5 * bin.dof * share * share.transpose();
    }
  }

 private:
  inline static const Vector3d kFaint{1.0 / 5.0, 1.0 / 5.0, 1.0 / 2.0};
  const std::vector<Bin>& bins_;
  Vector3d centre_;
};

/// Fisher scoring, damped as by Levenberg and Marquardt.
Vector3d minimise(const Likelihood& likelihood, Vector3d log) {
  double damping = 1e-3;
  double value = likelihood.value(log);
  for (int round = 0; round < 200 && damping < 1e6; ++round) {
    Vector3d slope;
    Matrix3d curvature;
    likelihood.derivatives(log, slope, curvature);
    curvature.diagonal() *= 1.0 + damping;
    const Vector3d step = -curvature.llt().solve(slope);
    const double next = likelihood.value(log + step);
    if (next < value) {
      log += step;
      value = next;
      damping = std::max(1e-9, 0.1 * damping);
    } else {
      damping *= 10.0;
    }
    if (step.lpNorm<Eigen::Infinity>() < 1e-8) break;
  }
  return log;
}

}  // namespace

VectorXd NoiseSpectrum::variance(const VectorXd& frequency) const {
  VectorXd all(frequency.size());
  for (Index i = 0; i < all.size(); ++i) all[i] = variance(frequency[i]);
  return all;
}

RepeatScatter repeat_scatter(const VectorXd& frequency, const MatrixXd& coefficients) {
  if (coefficients.cols() < 2) throw std::invalid_argument("noise spectrum: fewer than two laps");
  if (coefficients.rows() != frequency.size())
    throw std::invalid_argument("noise spectrum: one coefficient per frequency is needed");
  if (!coefficients.allFinite()) throw std::invalid_argument("noise spectrum: a value is not finite");
  const MatrixXd from_first = coefficients.colwise() - coefficients.col(0);  // equal laps: exactly zero
  RepeatScatter scatter;
  scatter.frequency = frequency;
  scatter.energy = (from_first.colwise() - from_first.rowwise().mean()).rowwise().squaredNorm();
  scatter.dof = static_cast<int>(coefficients.cols()) - 1;
  return scatter;
}

NoiseSpectrumFit fit_noise_spectrum(const std::vector<RepeatScatter>& recordings) {
  NoiseSpectrumFit fit;
  fit.log_covariance.setConstant(std::numeric_limits<double>::quiet_NaN());
  std::vector<Bin> bins = pooled(recordings);
  double energy = 0.0, dof = 0.0;
  for (const Bin& bin : bins) energy += bin.energy, dof += bin.dof;
  if (dof < 4.0) return fit;
  const double scale = energy / dof;
  fit.status = FitStatus::kIllConditioned;
  if (!(scale > 0.0)) return fit;
  for (Bin& bin : bins) bin.energy /= scale;

  constexpr double kFloor = 1e-6, kCorner = 5.0;
  const std::size_t low = std::max<std::size_t>(1, std::min<std::size_t>(5, bins.size() / 4));
  const double white = std::max(kFloor, median_level(bins, bins.size() / 2, bins.size()));
  const double slow = std::max({kFloor, 0.1 * white, median_level(bins, 0, low) - white});
  const Vector3d centre(std::log(white), std::log(slow), std::log(kCorner));
  const Likelihood likelihood(bins, centre);
  Vector3d best = centre;
  double best_value = std::numeric_limits<double>::infinity();
  for (const double corner : {0.5, 2.0, 8.0, 32.0, 128.0}) {
    const Vector3d found = minimise(likelihood, {centre[0], centre[1], std::log(corner)});
    const double value = likelihood.value(found);
    if (!(value < best_value)) continue;
    best = found;
    best_value = value;
  }

  Vector3d slope;
  Matrix3d curvature;
  likelihood.derivatives(best, slope, curvature);
  fit.log_covariance = curvature.llt().solve(Matrix3d::Identity());
  fit.spectrum = spectrum_of(best);
  for (std::size_t band = 0; band < kNoiseBandBegin.size(); ++band) {
    double chi2 = 0.0, counted = 0.0;
    for (const Bin& bin : bins) {
      if (bin.frequency < kNoiseBandBegin[band]) continue;
      if (band + 1 < kNoiseBandBegin.size() && bin.frequency >= kNoiseBandBegin[band + 1]) continue;
      chi2 += bin.energy / fit.spectrum.variance(bin.frequency);
      counted += bin.dof;
    }
    fit.band_z[band] = counted > 0.0 ? (chi2 - counted) / std::sqrt(2.0 * counted) : 0.0;
  }
  fit.spectrum.white *= scale;
  fit.spectrum.slow *= scale;
  fit.status = FitStatus::kOk;
  return fit;
}

}  // namespace ballbar
