#include "gap/kinds.hpp"

#include <algorithm>
#include <cmath>

#include "gap/search_problem.hpp"
#include "numerics/evidence_search.hpp"

namespace ballbar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

GapFit with_kinds_weighed(const GapFitter& fitter, GapFit fit, const GapPriors& priors) {
  for (std::size_t i = 0; i < fit.named.size(); ++i) {
    if (fit.named[i].candidate.family != "lost motion") continue;
    // All of this joint's lost motion as one.
    double size = fit.named[i].coefficients[0];
    for (std::size_t j = fit.named.size(); j-- > i + 1;)
      if (rivals(fit.named[i].candidate, fit.named[j].candidate))
        fit.named.erase(fit.named.begin() + static_cast<std::ptrdiff_t>(j));
    const Linearised at = fitter.linearise(fit, true);
    const Nuisances nuisances = nuisances_of(fitter, at, priors);
    std::vector<Candidate> all;
    std::vector<VectorXd> now;
    VectorXd y = at.residual + at.baseline * baseline_of(fit.state);
    for (const NamedEffect& named : fit.named) {
      y += fitter.contribution(at, named.candidate.with(named.coefficients));
      all.push_back(named.candidate);
      now.push_back(named.coefficients);
    }
    const std::size_t others = all.size();
    for (Candidate& kind : lost_motion_kinds(fit.named[i].candidate.effect.joint)) {
      all.push_back(std::move(kind));
      now.emplace_back();
    }
    double best = -1e300;
    std::size_t chosen = i;
    for (const bool at_own_size : {false, true}) {  // a pattern's width is a part of it: physics-gap.md 8.4
      const Columns columns = all_columns(fitter, at, all, now, Slope::kChord);
      const EvidenceProblem problem =
          eliminate_baseline(y, nuisances.columns, nuisances.sd, columns.all, columns.widths);
      for (std::size_t k = others; k < all.size(); ++k) {
        std::vector<int> set{static_cast<int>(k)};
        for (std::size_t j = 0; j < others; ++j)
          if (j != i) set.push_back(static_cast<int>(j));
        std::sort(set.begin(), set.end());
        const EvidencePosterior posterior = evidence_posterior(problem, set, 2.0);
        const double found = posterior.mean[posterior.mean.size() - 1];
        if (!at_own_size) {
          now[k] = VectorXd::Constant(1, std::clamp(found, 0.05, 20.0));
          continue;
        }
        const double evidence = log_evidence(problem, set, 2.0);
        if (evidence <= best || found <= 0.0) continue;
        best = evidence;
        chosen = k;
        size = found;
      }
    }
    if (chosen == i) continue;
    fit.named[i].candidate = all[chosen];
    fit.named[i].coefficients = VectorXd::Constant(1, size);
    fit.shape.resize(0);
  }
  for (NamedEffect& named : fit.named) {
    named.candidate = with_free_shape(named.candidate);
    const double size = named.coefficients[0];
    if (named.coefficients.size() == named.candidate.width()) continue;
    named.coefficients = VectorXd::Ones(named.candidate.width());
    named.coefficients[0] = size;
  }
  return fit;
}

namespace {

bool is_slip(const Candidate& found) { return found.family == "ball slip"; }

std::size_t moment_slot(const Candidate& found) { return is_slip(found) ? 3 : 1; }

/// Of a ball only circles about it.
bool shows(const Observation& seen, const Candidate& found) {
  const std::vector<double>& values = found.effect.values;
  return seen.instrument.is_bar() &&
         (!is_slip(found) || seen.instrument.origin == Vector3d(values[4], values[5], values[6]));
}

/// [us] inside the recordings next to the moment that was found.
std::vector<double> moments_near(const std::vector<Observation>& observations, const Candidate& found) {
  const double moment = found.effect.values[moment_slot(found)];
  constexpr int kParts = 20;  // of a recording
  const Observation* before = nullptr;
  const Observation* after = nullptr;
  for (const Observation& seen : observations) {
    if (!shows(seen, found)) continue;
    if (static_cast<double>(seen.begin_us) <= moment) before = &seen;
    if (!after && static_cast<double>(seen.end_us) >= moment) after = &seen;
  }
  std::vector<double> near;
  for (const Observation* seen : {before, after}) {
    if (!seen || (seen == after && before == after)) continue;
    const auto length = static_cast<double>(seen->end_us - seen->begin_us);
    for (int i = 1; i < kParts; ++i)
      near.push_back(static_cast<double>(seen->begin_us) + length * static_cast<double>(i) / kParts);
  }
  return near;
}

}  // namespace

GapFit with_moments_weighed(const GapFitter& fitter, GapFit fit, const GapPriors& priors) {
  constexpr double kLeastGain = 5.0;  // [ln of the odds] one of some forty would be better by chance
  for (std::size_t i = 0; i < fit.named.size(); ++i) {
    const Candidate found = fit.named[i].candidate;
    if (found.family != "ball slip" && found.family != "gauge jump") continue;
    const std::size_t slot = moment_slot(found);
    const Linearised at = fitter.linearise(fit, true);
    std::vector<Candidate> all;
    std::vector<VectorXd> now;
    for (const NamedEffect& named : fit.named) {
      all.push_back(named.candidate);
      now.push_back(named.coefficients);
    }
    const std::size_t others = all.size();
    for (const double moment : moments_near(fitter.observations(), found)) {
      all.push_back(found);
      all.back().effect.values[slot] = moment;
      now.emplace_back();
    }
    const Columns columns = all_columns(fitter, at, all, now, Slope::kChord);
    const Nuisances nuisances = nuisances_of(fitter, at, priors);
    const EvidenceProblem problem = eliminate_baseline(about_zero(fitter, at, fit), nuisances.columns,
                                                       nuisances.sd, columns.all, columns.widths);
    const auto with = [&](std::size_t k) {
      std::vector<int> set{static_cast<int>(k)};
      for (std::size_t j = 0; j < others; ++j)
        if (j != i) set.push_back(static_cast<int>(j));
      std::sort(set.begin(), set.end());
      return set;
    };
    const double as_found = log_evidence(problem, with(i), 2.0);
    double best = as_found + kLeastGain;
    for (std::size_t k = others; k < all.size(); ++k) {
      const double evidence = log_evidence(problem, with(k), 2.0);
      if (evidence <= best) continue;
      best = evidence;
      const VectorXd mean = evidence_posterior(problem, with(k), 2.0).mean;
      fit.named[i].candidate = all[k];
      fit.named[i].coefficients = mean.tail(all[k].width());
    }
  }
  return fit;
}

}  // namespace ballbar
