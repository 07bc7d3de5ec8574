#include "gap/vibration.hpp"

#include <algorithm>
#include <cmath>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kLowest = 2.0;       // [Hz]: below, the motion itself is
constexpr double kStepOfScan = 0.02;  // [Hz]: a fifth of what the slowest lap resolves
constexpr double kStandsOut = 20.0;   // z
constexpr Index kNear = 1;            // coefficients on either side that belong to a line
constexpr Index kBeside = 20;         // and those, further out, that tell its noise
constexpr double kMedianOfChi2 = 0.4549;

struct VibrationLap {
  VectorXd energy;   ///< [m^2] of each coefficient
  VectorXd level;    ///< [m^2] median of its neighbours' energy over that of chi2: its noise
  double per_hertz;  ///< coefficients
  double places;
};

VectorXd levels(const VectorXd& energy) {
  VectorXd level(energy.size());
  std::vector<double> beside;
  for (Index k = 0; k < energy.size(); ++k) {
    beside.clear();
    for (Index i = std::max<Index>(1, k - kBeside); i < std::min(energy.size(), k + kBeside + 1); ++i)
      if (std::abs(i - k) > 3) beside.push_back(energy[i]);
    const auto middle = beside.begin() + static_cast<std::ptrdiff_t>(beside.size() / 2);
    std::nth_element(beside.begin(), middle, beside.end());
    level[k] = *middle / kMedianOfChi2;
  }
  return level;
}

std::vector<VibrationLap> laps_of(const std::vector<Observation>& observations,
                                  const std::vector<VectorXd>& predicted) {
  std::vector<VibrationLap> laps;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Observation& seen = observations[i];
    if (!seen.instrument.is_bar() || seen.measured.size() < 4 * kBeside) continue;
    const VectorXd time = seen.time(seen.sample);
    const auto places = static_cast<double>(seen.places());
    const double duration = (time[time.size() - 1] - time[0]) * places / (places - 1.0);
    for (Index lap = 0; lap < seen.laps.cols(); ++lap) {
      const VectorXd energy = (seen.laps.col(lap) - predicted[i]).cwiseAbs2();
      laps.push_back({energy, levels(energy), 2.0 * duration, places});
    }
  }
  return laps;
}

}  // namespace

std::optional<Vibration> find_vibration(const std::vector<Observation>& observations,
                                        const std::vector<VectorXd>& predicted) {
  const std::vector<VibrationLap> laps = laps_of(observations, predicted);
  double highest = 0.0;
  for (const VibrationLap& lap : laps)
    highest = std::max(highest, static_cast<double>(lap.energy.size() - 2) / lap.per_hertz);
  Vibration best;
  double squares = 0.0, heard = 0.0;
  const auto steps = static_cast<int>(std::max(0.0, (highest - kLowest) / kStepOfScan));
  for (int step = 0; step < steps; ++step) {
    const double hertz = kLowest + kStepOfScan * step;
    double sum = 0.0, count = 0.0, power = 0.0, laps_here = 0.0;
    for (const VibrationLap& lap : laps) {
      const auto k = static_cast<Index>(std::lround(hertz * lap.per_hertz));
      if (k - kNear < 4 || k + kNear >= lap.energy.size()) continue;
      double line = 0.0;
      for (Index i = k - kNear; i <= k + kNear; ++i) {
        sum += lap.energy[i] / lap.level[k];
        count += 1.0;
        line += lap.energy[i] - lap.level[k];
      }
      power += 2.0 * line / lap.places;  // amplitude squared
      laps_here += 1.0;
    }
    if (laps_here < 4.0) continue;
    const double z = (sum - count) / std::sqrt(2.0 * count);
    if (z <= best.z) continue;
    best.z = z;
    best.frequency.value = hertz;
    squares = power;
    heard = laps_here;
  }
  if (best.z < kStandsOut || !(squares > 0.0)) return std::nullopt;
  // Three coefficients hold nine tenths of a line, whatever its phase.
  best.amplitude.value = std::sqrt(squares / heard / 0.9);
  best.amplitude.sd = best.amplitude.value * std::sqrt(1.0 / heard + 0.01);
  double slowest = 0.0;  // of the laps that reach so high
  for (const VibrationLap& lap : laps)
    if (best.frequency.value * lap.per_hertz + kNear < static_cast<double>(lap.energy.size()))
      slowest = std::max(slowest, lap.per_hertz);
  best.frequency.sd = 0.8 / slowest;  // three coefficients are 1.5 wide either way
  return best;
}

}  // namespace ballbar
