#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>

#include "core/units.hpp"
#include "metrology/signature_columns.hpp"
#include "numerics/resolved_fit.hpp"

namespace ballbar::signature {
namespace {

using Eigen::ArrayXd;
using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr std::size_t kMostFound = 6;
constexpr std::size_t kRefined = 2;  // of the five kinds, the best of the rough scan
constexpr int kMostRefinements = 8;
constexpr double kAlike = 0.05;       // share of a column's power that the others leave, to count as known
constexpr double kOddsAgainst = 1e5;  // that noise alone looks like this
constexpr double kLeastShare = 0.1;   // of the power above the sensor's noise that is left, to be named
constexpr double kSlowest = 16.0;     // order; slower is the business of the other signatures
constexpr double kFastest = 100.0;    // likewise
constexpr double kSamplesPerOrder = 8.0;  // of one turn

/// What the found terms leave, and the space that they span; both times the root of the weights.
struct State {
  MatrixXd basis;
  VectorXd root, left;
  double power = 0.0;  ///< of `left`
};

State state_of(const Samples& samples, const std::vector<Term>& terms) {
  Index p = 0;
  for (const Term& term : terms) p += term.columns.cols();
  MatrixXd columns(samples.deviation.size(), p);
  p = 0;
  for (const Term& term : terms) {
    columns.middleCols(p, term.columns.cols()) = term.columns;
    p += term.columns.cols();
  }
  const ResolvedFit fit = fit_resolved(columns, samples.deviation, samples.weight);
  State state;
  state.basis = fit.basis;
  state.root = samples.weight.cwiseSqrt();
  const VectorXd weighted = state.root.cwiseProduct(samples.deviation);
  state.left = weighted - fit.basis * (fit.basis.transpose() * weighted);
  state.power = state.left.squaredNorm();
  return state;
}

/// By how much the sum of squares falls where the columns join; 0 where they add next to nothing that is new.
double gain(const State& state, const MatrixXd& columns) {
  const MatrixXd weighted = state.root.asDiagonal() * columns;
  const MatrixXd fresh = weighted - state.basis * (state.basis.transpose() * weighted);
  if (fresh.squaredNorm() < kAlike * weighted.squaredNorm()) return 0.0;
  MatrixXd normal = fresh.transpose() * fresh;
  normal.diagonal().array() += 1e-9 * normal.trace();
  const VectorXd right = fresh.transpose() * state.left;
  return right.dot(normal.ldlt().solve(right));
}

struct Candidate {
  Kind kind = Kind::kOrder;
  double parameter = 0.0;
  double gain = 0.0;
  double low = 0.0;  ///< neighbours on the scan
  double high = 0.0;
  double tried = 1.0;
};

/// The parameters of a spike: travel from a step of the angle or two up to a fifth of the radius.
Candidate scan_spike(const Samples& samples, const State& state, Kind kind) {
  constexpr int kSteps = 22;
  Candidate best{kind};
  const double ratio = std::pow(40.0, 1.0 / kSteps);
  double travel = samples.radius / 200.0;
  for (int k = 0; k <= kSteps; ++k, travel *= ratio) {
    const double g = gain(state, searched_term(samples, kind, travel).columns);
    if (g > best.gain) best = {kind, travel, g, travel / ratio, travel * ratio, kSteps};
  }
  return best;
}

/// Frequencies of exp(i k x) by steps: one complex product per sample and step. `amplitude` multiplies the
/// waves; `part` (0 or 1 per sample) lets two directions have their own phases.
Candidate scan_waves(const State& state, Kind kind, const ArrayXd& x, const ArrayXd& amplitude,
                     const ArrayXd& part, double step, double fastest) {
  Candidate best{kind};
  const Index n = x.size();
  std::vector<std::complex<double>> wave(static_cast<std::size_t>(n));
  std::vector<std::complex<double>> turn(wave.size());
  const ArrayXd shape = amplitude * state.root.array();
  const ArrayXd weighted = shape * state.left.array();
  const double size = std::max(1e-300, (shape * shape * part).sum() / 2.0);
  const double other_size = std::max(1e-300, (shape * shape * (1.0 - part)).sum() / 2.0);
  for (Index i = 0; i < n; ++i) {
    wave[static_cast<std::size_t>(i)] = std::polar(weighted[i], kSlowest * x[i]);
    turn[static_cast<std::size_t>(i)] = std::polar(1.0, step * x[i]);
  }
  const double tried = std::max(1.0, (fastest - kSlowest) / step);
  for (int count = 0; kSlowest + count * step <= fastest; ++count) {
    const double k = kSlowest + count * step;
    std::complex<double> sum = 0.0;
    std::complex<double> other = 0.0;
    for (std::size_t i = 0; i < wave.size(); ++i) {
      (part[static_cast<Index>(i)] > 0.5 ? sum : other) += wave[i];
      const double re = wave[i].real() * turn[i].real() - wave[i].imag() * turn[i].imag();
      const double im = wave[i].real() * turn[i].imag() + wave[i].imag() * turn[i].real();
      wave[i] = {re, im};
    }
    const double g = std::norm(sum) / size + std::norm(other) / other_size;
    if (g > best.gain) best = {kind, k, g, k - step, k + step, tried};
  }
  return best;
}

/// The best parameter between its neighbours: golden section.
Candidate refine(const Samples& samples, const State& state, Candidate candidate) {
  constexpr double kGolden = 0.6180339887498949;
  const auto at = [&](double parameter) {
    return gain(state, searched_term(samples, candidate.kind, parameter).columns);
  };
  double low = candidate.low;
  double high = candidate.high;
  double left = high - kGolden * (high - low);
  double right = low + kGolden * (high - low);
  double at_left = at(left);
  double at_right = at(right);
  for (int k = 0; k < 22; ++k) {
    if (at_left > at_right) {
      high = right;
      right = left;
      at_right = at_left;
      left = high - kGolden * (high - low);
      at_left = at(left);
    } else {
      low = left;
      left = right;
      at_left = at_right;
      right = low + kGolden * (high - low);
      at_right = at(right);
    }
  }
  candidate.parameter = (low + high) / 2.0;
  candidate.gain = at(candidate.parameter);
  return candidate;
}

double fastest_of(const Samples& samples) {
  const double turns = samples.turns.maxCoeff() * (samples.one_way ? 1.0 : 2.0);
  const double per_turn = static_cast<double>(samples.angle.size()) / std::max(turns, 1e-9);
  return std::min(kFastest, per_turn / kSamplesPerOrder);
}

Candidate best_candidate(const Samples& samples, const State& state) {
  const double fastest = fastest_of(samples);
  const ArrayXd all = ArrayXd::Ones(samples.angle.size());
  const ArrayXd there = samples.one_way ? all : ArrayXd((1.0 + samples.way) / 2.0);
  std::array<Candidate, 5> candidates{
      scan_spike(samples, state, Kind::kSpikeX), scan_spike(samples, state, Kind::kSpikeY),
      scan_waves(state, Kind::kCyclicX, samples.cos, samples.cos, all, 0.7, fastest),
      scan_waves(state, Kind::kCyclicY, samples.sin, samples.sin, all, 0.7, fastest),
      scan_waves(state, Kind::kOrder, samples.angle, all, there, 0.25, fastest)};
  std::stable_sort(candidates.begin(), candidates.end(),
                   [](const Candidate& a, const Candidate& b) { return a.gain > b.gain; });
  Candidate best;
  for (std::size_t k = 0; k < kRefined; ++k) {
    if (!(candidates[k].gain > 0.0)) continue;
    const Candidate fine = refine(samples, state, candidates[k]);
    if (fine.gain > best.gain) best = fine;
  }
  return best;
}

bool believable(const Samples& samples, const State& state, const Candidate& candidate) {
  const auto n = static_cast<double>(samples.angle.size());
  const double noise = std::max(samples.noise * samples.noise, (state.power - candidate.gain) / n);
  const double above_noise = std::max(state.power - n * samples.noise * samples.noise, 0.0);
  // Four columns of noise alone gain more than x variances with a chance of about (1 + x/2) exp(-x/2).
  const double threshold = 2.0 * std::log(candidate.tried * kOddsAgainst) + 6.0;
  return candidate.gain > threshold * noise && candidate.gain > kLeastShare * above_noise;
}

struct Found {
  Candidate at;
  Term term;
};

std::vector<Term> joined(const std::vector<Term>& linear, const std::vector<Found>& found,
                         std::size_t without) {
  std::vector<Term> all = linear;
  for (std::size_t k = 0; k < found.size(); ++k)
    if (k != without) all.push_back(found[k].term);
  return all;
}

/// Each parameter anew with all others in the model, until they rest.
void settle(const Samples& samples, const std::vector<Term>& linear, std::vector<Found>& found) {
  if (found.size() < 2) return;
  for (int round = 0; round < kMostRefinements; ++round) {
    double moved = 0.0;
    for (std::size_t k = 0; k < found.size(); ++k) {
      const State state = state_of(samples, joined(linear, found, k));
      Candidate wider = found[k].at;
      const double reach = (wider.high - wider.low) / 4.0;
      wider.low = wider.parameter - reach;
      wider.high = wider.parameter + reach;
      Candidate fine = refine(samples, state, wider);
      moved = std::max(moved, std::abs(fine.parameter - found[k].at.parameter) / fine.parameter);
      fine.low = found[k].at.low;
      fine.high = found[k].at.high;
      found[k] = {fine, searched_term(samples, fine.kind, fine.parameter)};
    }
    if (moved < 1e-5) break;
  }
}

/// Looks for a better one in the place of each: what was found first was found among all that was not yet
/// known. True where one was replaced.
bool revise(const Samples& samples, const std::vector<Term>& linear, std::vector<Found>& found) {
  bool replaced = false;
  for (std::size_t k = 0; found.size() > 1 && k < found.size(); ++k) {
    const State state = state_of(samples, joined(linear, found, k));
    const Candidate best = best_candidate(samples, state);
    if (!(best.gain > 1.001 * gain(state, found[k].term.columns))) continue;
    found[k] = {best, searched_term(samples, best.kind, best.parameter)};
    settle(samples, linear, found);
    replaced = true;
  }
  return replaced;
}

}  // namespace

std::vector<SearchedTerm> search(const Samples& samples, const std::vector<Term>& linear) {
  std::vector<Found> found;
  for (bool revised = false; found.size() < kMostFound;) {
    const State state = state_of(samples, joined(linear, found, found.size()));
    const Candidate best = best_candidate(samples, state);
    if (!(best.gain > 0.0) || !believable(samples, state, best)) {
      // Once: what is left may have been hidden by a wrong choice.
      if (revised || !revise(samples, linear, found)) break;
      revised = true;
      continue;
    }
    found.push_back({best, searched_term(samples, best.kind, best.parameter)});
    settle(samples, linear, found);
  }
  std::vector<SearchedTerm> terms;
  terms.reserve(found.size());
  for (Found& each : found) terms.push_back({each.at.kind, std::move(each.term)});
  return terms;
}

}  // namespace ballbar::signature
