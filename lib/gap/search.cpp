#include "gap/search.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <string>

#include "gap/kinds.hpp"
#include "gap/search_problem.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Effects at most that a round may name: what is large first, with its pattern at its own size, before the
/// rest is looked at (physics-gap.md 8.4).
constexpr std::array<int, 6> kMostGroups{2, 4, 6, 9, 9, 9};
constexpr std::size_t kKnownRound = 3;
constexpr int kStepsOfRound = 4;     // the next round goes on from there
constexpr double kStructure = 1.3;   // chi2 per row
constexpr double kModelForm = 0.02;  // of the explained signal: physics-gap.md 5, step 7
constexpr double kGapForm = 0.10;  // of what lost motion explains: where the gap is crossed is known roughly
constexpr Index kSmooth = 8;       // coefficients on either side over which that is spread

void silence(EvidenceProblem& problem, const Columns& columns, std::size_t c) {
  problem.gram.middleRows(columns.begin[c], columns.widths[c]).setZero();
  problem.gram.middleCols(columns.begin[c], columns.widths[c]).setZero();
  problem.projection.segment(columns.begin[c], columns.widths[c]).setZero();
}

/// Searches until no effect has an impossible sign and no two are of one family of one joint.
std::vector<std::size_t> choose(EvidenceProblem problem, const Columns& columns,
                                const std::vector<Candidate>& candidates, int most,
                                EvidenceResult& evidence) {
  EvidenceOptions options;
  options.max_groups = most;
  for (;;) {
    evidence = search_evidence(problem, options);
    std::vector<std::size_t> chosen;
    std::optional<std::size_t> impossible;
    std::map<std::string, std::pair<std::size_t, double>> moments;  // what moves, moves once
    Index k = 0;
    for (const int group : evidence.best().groups) {
      const auto c = static_cast<std::size_t>(group);
      if (candidates[c].positive && evidence.posterior.mean[k] < 0.0 && !impossible) impossible = c;
      if (candidates[c].family == "ball slip" || candidates[c].family == "gauge jump") {
        const double size = evidence.posterior.mean.segment(k, columns.widths[c]).norm();
        const auto [first, fresh] = moments.try_emplace(candidates[c].family, c, size);
        if (!fresh && !impossible) impossible = size < first->second.second ? c : first->second.first;
      }
      k += columns.widths[c];
      chosen.push_back(c);
    }
    if (!impossible) return chosen;
    silence(problem, columns, *impossible);
  }
}

}  // namespace

std::vector<Observation> with_model_form(const GapFitter& fitter, const GapFit& fit) {
  std::vector<Observation> loose = fitter.observations();
  if (fit.named.empty()) return loose;
  const Linearised at = fitter.linearise(fit, false);
  for (std::size_t i = 0; i < loose.size(); ++i) {
    Observation& seen = loose[i];
    Drive drive = at.tangents[i].drive();
    VectorXd energy = VectorXd::Zero(seen.measured.size());
    for (const NamedEffect& named : fit.named) {
      const bool gap = named.candidate.slots.size() > 1 && named.candidate.family == "lost motion";
      const double form = (gap ? kGapForm : kModelForm) / kModelForm;
      const Effect effect = named.candidate.with(named.coefficients);
      energy += form * form * seen.transform(fitter.model().push(at.tangents[i], drive, effect)).cwiseAbs2();
    }
    for (Index k = 1; k < energy.size(); ++k) {
      const Index from = std::max<Index>(1, k - kSmooth), to = std::min(energy.size(), k + kSmooth + 1);
      seen.variance[k] += kModelForm * kModelForm * energy.segment(from, to - from).mean();
    }
  }
  return loose;
}

namespace {

/// Whether all that is in the model was chosen again; kinds of one joint's lost motion are one.
bool holds_all(const std::vector<std::size_t>& chosen, const std::vector<Candidate>& candidates,
               const GapFit& fit) {
  return std::all_of(fit.named.begin(), fit.named.end(), [&](const NamedEffect& named) {
    return std::any_of(chosen.begin(), chosen.end(), [&](std::size_t c) {
      return rivals(candidates[c], named.candidate) || candidates[c].label() == named.candidate.label();
    });
  });
}

bool has_structure(const GapFitter& fitter, const GapFit& fit) {
  return fit.chi2 >= kStructure * static_cast<double>(fitter.rows());
}

/// By Schwarz's criterion, without what a formula may be wrong by: what one round adds may spoil what the one
/// before had found.
GapFit best_of(const GapFitter& strict, const std::vector<GapFit>& rounds) {
  GapFit best;
  double least = std::numeric_limits<double>::infinity();
  for (const GapFit& round : rounds) {
    const GapFit fit = strict.fit(round, GapPriors{}, true, kStepsOfRound);
    double coefficients = 0.0;
    for (const NamedEffect& named : fit.named) coefficients += static_cast<double>(named.coefficients.size());
    const double criterion = fit.chi2 + coefficients * std::log(static_cast<double>(strict.rows()));
    if (criterion >= least) continue;
    least = criterion;
    best = round;
  }
  return best;
}

/// From where the last round came to; where that leaves structure, with more steps, and also from before
/// anything was named, clocks and scale held at first: what has stood in for missing physics does not find
/// back by itself.
GapFit fitted(const GapFitter& fitter, const GapFit& start, const GapState& before) {
  const GapPriors priors;
  GapFit fit = fitter.fit(start, priors, true, kStepsOfRound);
  if (!has_structure(fitter, fit)) return fit;
  fit = fitter.fit(fit, priors, true, kStepsOfRound);
  GapPriors held;
  held.shift = held.bar_scale = 0.0;
  GapFit again = start;
  again.state = before;
  again.shape.resize(0);
  again = fitter.fit(fitter.fit(again, held, true, kStepsOfRound), priors, true, 2 * kStepsOfRound);
  return again.chi2 < fit.chi2 ? again : fit;
}

}  // namespace

Found search_effects(const GapFitter& strict, const std::vector<Candidate>& candidates,
                     const std::optional<Curve>& curve, const GapFit* known) {
  const GapPriors priors;
  Found found;
  const GapFit first = baseline_fit(strict);
  GapFit fit = known ? *known : first;
  fit.curve = curve;
  fit.shape.resize(0);
  std::vector<VectorXd> now(candidates.size());
  std::vector<std::size_t> last;
  std::vector<GapFit> rounds;
  bool structure = false;
  const auto take_sizes = [&] {
    for (VectorXd& size : now) size.resize(0);
    for (const NamedEffect& named : fit.named)
      for (std::size_t c = 0; c < candidates.size(); ++c)
        if (rivals(candidates[c], named.candidate) || candidates[c].label() == named.candidate.label())
          now[c] = named.coefficients.head(candidates[c].width());
  };
  take_sizes();
  for (std::size_t round = known ? kKnownRound : 0; round < kMostGroups.size(); ++round) {
    const std::vector<Observation> loose = with_model_form(strict, fit);
    const GapFitter fitter(strict.model(), loose);
    Linearised at = fitter.linearise(fit, true);
    const Columns columns = all_columns(fitter, at, candidates, now, Slope::kChord);
    const auto chosen_now = [&] {
      const Nuisances nuisances = nuisances_of(fitter, at, priors);
      return choose(eliminate_baseline(about_zero(fitter, at, fit), nuisances.columns, nuisances.sd,
                                       columns.all, columns.widths),
                    columns, candidates, kMostGroups[round], found.evidence);
    };
    std::vector<std::size_t> chosen = chosen_now();
    if (at.shape.cols() > 0 && !holds_all(chosen, candidates, fit)) {
      // What an effect may be beside its formula is nothing without it, but over a small stroke may look like
      // it.
      at.shape.resize(Eigen::NoChange, 0);
      chosen = chosen_now();
    }
    GapFit next = fit;
    next.named.clear();
    next.shape.resize(0);
    Index k = 0;
    for (const std::size_t c : chosen) {
      next.named.push_back({candidates[c], found.evidence.posterior.mean.segment(k, columns.widths[c])});
      k += columns.widths[c];
    }
    next = with_kinds_weighed(fitter, with_moments_weighed(fitter, next, priors), priors);
    fit = fitted(fitter, next, first.state);
    structure = has_structure(fitter, fit);
    rounds.push_back(fit);
    take_sizes();
    if (chosen == last) break;
    last = chosen;
  }
  found.fit = structure ? best_of(strict, rounds) : std::move(fit);
  return found;
}

}  // namespace ballbar
