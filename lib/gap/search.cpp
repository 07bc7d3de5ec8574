#include "gap/search.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <optional>
#include <set>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Effects at most that a round may name: what is large first, with its pattern at its own size, before the
/// rest is looked at (physics-gap.md 8.4).
constexpr std::array<int, 6> kMostGroups{2, 4, 6, 9, 9, 9};
constexpr double kModelForm = 0.02;  // of the explained signal: physics-gap.md 5, step 7
constexpr Index kSmooth = 8;         // coefficients on either side over which that is spread

/// Columns of many candidates side by side.
struct Columns {
  MatrixXd all;
  std::vector<int> widths;
  std::vector<Index> begin;
};

Columns all_columns(const GapFitter& fitter, const Linearised& at, const std::vector<Candidate>& candidates,
                    const std::vector<VectorXd>& now, Slope slope) {
  Columns columns;
  Index total = 0;
  for (const Candidate& candidate : candidates) {
    columns.begin.push_back(total);
    columns.widths.push_back(candidate.width());
    total += candidate.width();
  }
  columns.all.resize(fitter.rows(), total);
  for (std::size_t i = 0; i < at.tangents.size(); ++i) {
    const Tangent& tangent = at.tangents[i];
    Drive drive(tangent.motor, fitter.model().model().chain(), tangent.bodies);
    MatrixXd values(tangent.time.size(), total);
    for (std::size_t c = 0; c < candidates.size(); ++c)
      values.middleCols(columns.begin[c], columns.widths[c]) =
          columns_of(fitter.model(), tangent, drive, candidates[c], now[c], slope);
    columns.all.middleRows(at.begin[i], fitter.observations()[i].measured.size()) =
        fitter.whitened(i, values);
  }
  return columns;
}

/// What is beside the candidates: baseline and shape freedom, and their standard deviations.
struct Nuisances {
  MatrixXd columns;
  VectorXd sd;
};

Nuisances nuisances_of(const GapFitter& fitter, const Linearised& at, const GapPriors& priors) {
  Nuisances all;
  all.columns.resize(at.baseline.rows(), at.baseline.cols() + at.shape.cols());
  all.columns << at.baseline, at.shape;
  const VectorXd base = fitter.baseline_sd(priors);
  all.sd.resize(all.columns.cols());
  all.sd << base, VectorXd::Ones(at.shape.cols());
  return all;
}

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
    Index k = 0;
    for (const int group : evidence.best().groups) {
      const auto c = static_cast<std::size_t>(group);
      if (candidates[c].positive && evidence.posterior.mean[k] < 0.0 && !impossible) impossible = c;
      k += columns.widths[c];
      chosen.push_back(c);
    }
    if (!impossible) return chosen;
    silence(problem, columns, *impossible);
  }
}

/// Effects that this one would replace: lost motion of one joint is named once.
bool rivals(const Candidate& a, const Candidate& b) {
  return !a.family.empty() && a.family == "lost motion" && a.family == b.family &&
         a.effect.joint == b.effect.joint;
}

}  // namespace

GapFit with_kinds_weighed(const GapFitter& fitter, GapFit fit, const GapPriors& priors) {
  for (std::size_t i = 0; i < fit.named.size(); ++i) {
    if (fit.named[i].candidate.family != "lost motion") continue;
    // All of this joint's lost motion as one.
    double size = 0.0;
    for (std::size_t j = fit.named.size(); j-- > i;)
      if (j == i || rivals(fit.named[i].candidate, fit.named[j].candidate)) {
        size += fit.named[j].coefficients[0];
        if (j != i) fit.named.erase(fit.named.begin() + static_cast<std::ptrdiff_t>(j));
      }
    fit.named[i].coefficients[0] = size;
    const Linearised at = fitter.linearise(fit, true);
    const Nuisances nuisances = nuisances_of(fitter, at, priors);
    std::vector<Candidate> all;
    std::vector<VectorXd> now;
    VectorXd y = at.residual + at.baseline * fitter.baseline_of(fit.state);
    for (const NamedEffect& named : fit.named) {
      y += fitter.contribution(at, named.candidate.with(named.coefficients));
      all.push_back(named.candidate);
      now.push_back(named.coefficients);
    }
    const std::size_t others = all.size();
    for (Candidate& kind : lost_motion_kinds(fit.named[i].candidate.effect.joint)) {
      const bool load = kind.effect.word == 2;
      all.push_back(std::move(kind));
      now.push_back(load ? VectorXd() : VectorXd(fit.named[i].coefficients.head(1)));
    }
    const Columns columns = all_columns(fitter, at, all, now, Slope::kChord);
    const EvidenceProblem problem =
        eliminate_baseline(y, nuisances.columns, nuisances.sd, columns.all, columns.widths);
    double best = -1e300;
    std::size_t chosen = i;
    for (std::size_t k = others; k < all.size(); ++k) {
      std::vector<int> set{static_cast<int>(k)};
      for (std::size_t j = 0; j < others; ++j)
        if (j != i) set.push_back(static_cast<int>(j));
      std::sort(set.begin(), set.end());
      const double evidence = log_evidence(problem, set, 2.0);
      if (evidence <= best) continue;
      const EvidencePosterior posterior = evidence_posterior(problem, set, 2.0);
      if (posterior.mean[posterior.mean.size() - 1] <= 0.0) continue;
      best = evidence;
      chosen = k;
      size = posterior.mean[posterior.mean.size() - 1];
    }
    if (chosen == i) continue;
    fit.named[i].candidate = with_free_friction(all[chosen]);
    fit.named[i].coefficients = VectorXd::Ones(fit.named[i].candidate.width());
    fit.named[i].coefficients[0] = size;
    fit.shape.resize(0);
  }
  return fit;
}

std::vector<Observation> with_model_form(const GapFitter& fitter, const GapFit& fit) {
  std::vector<Observation> loose = fitter.observations();
  GapState with = fit.state, without = fit.state;
  for (const NamedEffect& named : fit.named) with.effects.push_back(named.candidate.with(named.coefficients));
  const AsBuilt built_with = fitter.model().built(with), built_without = fitter.model().built(without);
  for (std::size_t i = 0; i < loose.size(); ++i) {
    Observation& seen = loose[i];
    const VectorXd signal = seen.transform(fitter.model().predict(built_with, seen, i, with) -
                                           fitter.model().predict(built_without, seen, i, without));
    const VectorXd energy = signal.cwiseAbs2();
    for (Index k = 1; k < energy.size(); ++k) {
      const Index from = std::max<Index>(1, k - kSmooth), to = std::min(energy.size(), k + kSmooth + 1);
      seen.variance[k] += kModelForm * kModelForm * energy.segment(from, to - from).mean();
    }
  }
  return loose;
}

Found search_effects(const GapFitter& strict, std::vector<Candidate> candidates) {
  GapPriors priors;
  Found found;
  GapFit fit;
  fit.state = strict.model().start(strict.observations());
  GapPriors frozen = priors;
  frozen.shift = 0.0;  // released only with effects in the model: physics-gap.md 8.2
  fit = strict.fit(fit, frozen, false, 4);
  std::vector<VectorXd> now(candidates.size());
  std::vector<std::size_t> last;
  const bool trace = std::getenv("BALLBAR_TRACE") != nullptr;
  for (std::size_t round = 0; round < kMostGroups.size(); ++round) {
    const std::vector<Observation> loose = with_model_form(strict, fit);
    const GapFitter fitter(strict.model(), loose);
    const Linearised at = fitter.linearise(fit, true);
    const Columns columns = all_columns(fitter, at, candidates, now, Slope::kChord);
    // Everything about zero: baseline and effects that are in the model compete again with all others.
    VectorXd y = at.residual + at.baseline * fitter.baseline_of(fit.state);
    for (std::size_t i = 0; i < fit.named.size(); ++i) {
      const NamedEffect& named = fit.named[i];
      y += fitter.contribution(at, named.candidate.with(named.coefficients));
    }
    const Nuisances nuisances = nuisances_of(fitter, at, priors);
    found.problem = eliminate_baseline(y, nuisances.columns, nuisances.sd, columns.all, columns.widths);
    const std::vector<std::size_t> chosen =
        choose(found.problem, columns, candidates, kMostGroups[round], found.evidence);
    GapFit next = fit;
    next.named.clear();
    next.shape.resize(0);
    Index k = 0;
    for (const std::size_t c : chosen) {
      next.named.push_back({candidates[c], found.evidence.posterior.mean.segment(k, columns.widths[c])});
      k += columns.widths[c];
    }
    fit = fitter.fit(with_kinds_weighed(fitter, next, priors), priors, true);
    found.named.clear();
    for (VectorXd& size : now) size.resize(0);
    for (const NamedEffect& named : fit.named)
      for (std::size_t c = 0; c < candidates.size(); ++c)
        if (rivals(candidates[c], named.candidate) || candidates[c].label() == named.candidate.label())
          now[c] = named.coefficients.head(candidates[c].width());
    if (trace) {
      std::fprintf(stderr, "round %d: rms %.3f um chi2/n %.3f odds %.1f visited %d\n",
                   static_cast<int>(round), fit.rms * 1e6, fit.chi2 / static_cast<double>(fitter.rows()),
                   found.evidence.best().log_odds, found.evidence.visited);
      for (const NamedEffect& named : fit.named) {
        std::fprintf(stderr, "   %s", named.candidate.label().c_str());
        if (named.candidate.family == "lost motion")
          std::fprintf(stderr, " @%.2f", named.candidate.effect.values[1]);
        for (const double c : named.coefficients) std::fprintf(stderr, " %.4f", c);
        std::fprintf(stderr, "\n");
      }
    }
    if (chosen == last) break;
    last = chosen;
  }
  found.fit = std::move(fit);
  found.candidates = std::move(candidates);
  return found;
}

}  // namespace ballbar
