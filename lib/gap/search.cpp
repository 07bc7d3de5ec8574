#include "gap/search.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
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

constexpr int kRounds = 4;
constexpr double kModelForm = 0.02;    // of the explained signal: physics-gap.md 5, step 7
constexpr double kMaterial = 0.35e-6;  // [m]

struct Columns {
  MatrixXd all;
  std::vector<int> widths;
  std::vector<Index> begin;
};

Columns all_columns(const GapFitter& fitter, const Linearised& at, const std::vector<Candidate>& candidates,
                    const std::vector<VectorXd>& now) {
  Columns columns;
  Index total = 0;
  for (const Candidate& candidate : candidates) {
    columns.begin.push_back(total);
    columns.widths.push_back(candidate.width());
    total += candidate.width();
  }
  columns.all.resize(fitter.rows(), total);
  std::vector<Drive> drives;
  for (std::size_t i = 0; i < at.tangents.size(); ++i) {
    const Tangent& tangent = at.tangents[i];
    Drive drive(tangent.motor, fitter.model().model().chain(), tangent.bodies);
    MatrixXd values(tangent.time.size(), total);
    for (std::size_t c = 0; c < candidates.size(); ++c)
      values.middleCols(columns.begin[c], columns.widths[c]) =
          columns_of(fitter.model(), tangent, drive, candidates[c], now[c]);
    columns.all.middleRows(at.begin[i], fitter.observations()[i].measured.size()) = fitter.whitened(i, values);
  }
  return columns;
}

MatrixXd nuisance_of(const Linearised& at) {
  MatrixXd all(at.baseline.rows(), at.baseline.cols() + at.shape.cols());
  all << at.baseline, at.shape;
  return all;
}

}  // namespace

Found search_effects(const GapFitter& fitter, std::vector<Candidate> candidates) {
  GapPriors priors;
  Found found;
  GapFit fit;
  fit.state = fitter.model().start(fitter.observations());
  GapPriors frozen = priors;
  frozen.shift = 0.0;  // released only with effects in the model: physics-gap.md 8.2
  fit = fitter.fit(fit, frozen, false, 4);
  std::vector<VectorXd> now(candidates.size());
  std::set<std::size_t> excluded;
  std::vector<std::size_t> last;
  const bool trace = std::getenv("BALLBAR_TRACE") != nullptr;
  for (int round = 0; round < kRounds; ++round) {
    const Linearised at = fitter.linearise(fit, true);
    const Columns columns = all_columns(fitter, at, candidates, now);
    // Everything about zero: baseline and effects that are in the model compete again with all others.
    VectorXd y = at.residual + at.baseline * fitter.baseline_of(fit.state);
    for (std::size_t i = 0; i < fit.named.size(); ++i) {
      const std::size_t c = found.named[i];
      y += columns.all.middleCols(columns.begin[c], columns.widths[c]) * fit.named[i].coefficients;
    }
    const VectorXd base_sd = fitter.baseline_sd(priors);
    VectorXd sd(base_sd.size() + at.shape.cols());
    sd << base_sd, VectorXd::Ones(at.shape.cols());
    found.problem = eliminate_baseline(y, nuisance_of(at), sd, columns.all, columns.widths);
    EvidenceProblem usable = found.problem;
    std::vector<std::size_t> chosen;
    for (;;) {
      for (const std::size_t c : excluded) {  // a group without energy is never worth its prior
        usable.gram.middleRows(columns.begin[c], columns.widths[c]).setZero();
        usable.gram.middleCols(columns.begin[c], columns.widths[c]).setZero();
        usable.projection.segment(columns.begin[c], columns.widths[c]).setZero();
      }
      found.evidence = search_evidence(usable);
      chosen.clear();
      Index k = 0;
      std::optional<std::size_t> impossible;
      for (const int group : found.evidence.best().groups) {
        const auto c = static_cast<std::size_t>(group);
        if (candidates[c].positive && found.evidence.posterior.mean[k] < 0.0 && !impossible) impossible = c;
        k += columns.widths[c];
        chosen.push_back(c);
      }
      if (!impossible) break;
      excluded.insert(*impossible);
    }
    GapFit next = fit;
    next.named.clear();
    Index k = 0;
    for (const std::size_t c : chosen) {
      next.named.push_back({candidates[c], found.evidence.posterior.mean.segment(k, columns.widths[c])});
      k += columns.widths[c];
    }
    found.named = chosen;
    next.shape.resize(0);
    fit = fitter.fit(next, priors, true);
    for (VectorXd& size : now) size.resize(0);
    for (std::size_t i = 0; i < chosen.size(); ++i) now[chosen[i]] = fit.named[i].coefficients;
    if (trace) {
      std::fprintf(stderr, "round %d: rms %.3f um chi2/n %.3f odds %.1f visited %d\n", round, fit.rms * 1e6,
                   fit.chi2 / static_cast<double>(fitter.rows()), found.evidence.best().log_odds,
                   found.evidence.visited);
      for (const NamedEffect& named : fit.named) {
        std::fprintf(stderr, "   %s", named.candidate.label().c_str());
        for (const double c : named.coefficients) std::fprintf(stderr, " %.4f", c);
        std::fprintf(stderr, "\n");
      }
    }
    if (chosen == last) break;
    last = chosen;
  }
  found.fit = std::move(fit);
  found.candidates = std::move(candidates);
  (void)kModelForm;
  (void)kMaterial;
  return found;
}

}  // namespace ballbar
