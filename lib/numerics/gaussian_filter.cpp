#include "numerics/gaussian_filter.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <numeric>
#include <stdexcept>
#include <unsupported/Eigen/FFT>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kTurn = 2.0 * std::numbers::pi;
constexpr double kSamplesPerWave = 7.0;  // of the cut-off
constexpr double kGridPerWave = 128.0;   // likewise, of the even grid that the sums are made on

/// A place on the even grid: between node and node + 1.
struct Place {
  std::size_t node = 0;
  std::size_t next = 0;
  double share = 0.0;  ///< of the way to the next node
};

Place place_of(double angle, std::size_t nodes) {
  const double at = angle / kTurn * static_cast<double>(nodes);
  const double floor = std::floor(at);
  const auto node = static_cast<std::size_t>(floor) % nodes;
  return {node, (node + 1) % nodes, at - floor};
}

/// Convolves real and imaginary part, each for itself, with the Gaussian. The samples came onto the grid, and
/// leave it, by linear shares: each dampens order k by sinc^2(k / nodes), which is taken back.
std::vector<std::complex<double>> smooth(const std::vector<std::complex<double>>& grid, double cutoff) {
  constexpr double kNothing = 8.0;  // in cut-offs: 2^-64 passes
  Eigen::FFT<double> fft;
  std::vector<std::complex<double>> spectrum;
  fft.fwd(spectrum, grid);
  const std::size_t nodes = grid.size();
  for (std::size_t k = 1; k <= nodes / 2; ++k) {
    const double order = static_cast<double>(k);
    double gain = 0.0;
    if (order < kNothing * cutoff) {
      const double x = std::numbers::pi * order / static_cast<double>(nodes);
      const double sinc = std::sin(x) / x;
      gain = std::exp2(-order * order / (cutoff * cutoff)) / (sinc * sinc * sinc * sinc);
    }
    spectrum[k] *= gain;
    if (k < nodes - k) spectrum[nodes - k] *= gain;
  }
  std::vector<std::complex<double>> smoothed;
  fft.inv(smoothed, spectrum);
  return smoothed;
}

/// The profile by rising angle in [0, 2 pi).
struct Sorted {
  std::vector<std::size_t> sequence;
  std::vector<double> angle;
  std::vector<double> step;  ///< to the next one, around the turn
  std::size_t widest = 0;    ///< the step that is the largest
};

Sorted sorted_by_angle(const VectorXd& angle) {
  Sorted sorted;
  VectorXd folded(angle.size());
  for (Index i = 0; i < angle.size(); ++i) {
    folded[i] = angle[i] - kTurn * std::floor(angle[i] / kTurn);
    if (!(folded[i] < kTurn)) folded[i] = 0.0;
  }
  sorted.sequence.resize(static_cast<std::size_t>(angle.size()));
  std::iota(sorted.sequence.begin(), sorted.sequence.end(), std::size_t{0});
  std::stable_sort(sorted.sequence.begin(), sorted.sequence.end(), [&](std::size_t a, std::size_t b) {
    return folded[static_cast<Index>(a)] < folded[static_cast<Index>(b)];
  });
  for (const std::size_t i : sorted.sequence) sorted.angle.push_back(folded[static_cast<Index>(i)]);
  for (std::size_t i = 0; i + 1 < sorted.angle.size(); ++i)
    sorted.step.push_back(sorted.angle[i + 1] - sorted.angle[i]);
  sorted.step.push_back(sorted.angle.front() + kTurn - sorted.angle.back());
  sorted.widest = static_cast<std::size_t>(std::max_element(sorted.step.begin(), sorted.step.end()) -
                                           sorted.step.begin());
  return sorted;
}

}  // namespace

FilteredProfile gaussian_filter(const VectorXd& angle, const VectorXd& value, double cutoff) {
  if (angle.size() != value.size()) throw std::invalid_argument("filter: angles and values differ in number");
  if (!angle.allFinite() || !value.allFinite())
    throw std::invalid_argument("filter: an angle or a value is not finite");
  if (!(cutoff > 0.0 && cutoff <= 1000.0))
    throw std::invalid_argument("filter: the cut-off is not in (0, 1000]");
  FilteredProfile filtered;
  const auto n = static_cast<std::size_t>(angle.size());
  if (n < 3) return filtered;
  const double wave = kTurn / cutoff;
  Sorted sorted = sorted_by_angle(angle);
  const bool open = sorted.step[sorted.widest] > wave / kSamplesPerWave;
  const double hole = open ? sorted.step[sorted.widest] : 0.0;
  const double end = sorted.angle[sorted.widest];  // the hole begins here
  if (open) {
    sorted.step[sorted.widest] = 0.0;  // the ends' stretches do not reach into the hole
    const double others = *std::max_element(sorted.step.begin(), sorted.step.end());
    if (others > wave / kSamplesPerWave || kTurn - hole <= 2.0 * wave) return filtered;
  }

  std::size_t nodes = 1024;
  while (nodes < n || static_cast<double>(nodes) < kGridPerWave * cutoff) nodes *= 2;
  const double mean =
      value.mean();  // so that rounding, and the cut of the weights, act on the deviation from it
  std::vector<std::complex<double>> sums(nodes);  // of stretch x value, and of stretch
  for (std::size_t i = 0; i < n; ++i) {
    const double stretch = (sorted.step[i] + sorted.step[(i + n - 1) % n]) / 2.0;
    const std::complex<double> part(stretch * (value[static_cast<Index>(sorted.sequence[i])] - mean),
                                    stretch);
    const Place at = place_of(sorted.angle[i], nodes);
    sums[at.node] += (1.0 - at.share) * part;
    sums[at.next] += at.share * part;
  }
  const std::vector<std::complex<double>> smoothed = smooth(sums, cutoff);

  filtered.status = FitStatus::kOk;
  filtered.value.resize(angle.size());
  filtered.defined.assign(n, true);
  for (std::size_t i = 0; i < n; ++i) {
    const std::size_t sample = sorted.sequence[i];
    const Place at = place_of(sorted.angle[i], nodes);
    const double past =
        std::fmod(sorted.angle[i] - end + kTurn, kTurn);  // since the hole began; 0 at its first end
    if (open && (past < hole + wave || kTurn - past < wave)) {
      filtered.defined[sample] = false;
      filtered.value[static_cast<Index>(sample)] = std::numeric_limits<double>::quiet_NaN();
      continue;
    }
    const std::complex<double> sum = (1.0 - at.share) * smoothed[at.node] + at.share * smoothed[at.next];
    filtered.value[static_cast<Index>(sample)] = mean + sum.real() / sum.imag();
  }
  return filtered;
}

}  // namespace ballbar
