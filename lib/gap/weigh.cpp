#include "gap/weigh.hpp"

#include <cmath>

#include "gap/search.hpp"
#include "gap/search_problem.hpp"
#include "gap/shape_freedom.hpp"
#include "numerics/evidence_search.hpp"

namespace ballbar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::vector<double> sizes(const GapFitter& fitter, const GapFit& fit) {
  std::vector<double> size;
  if (fit.named.empty()) return size;
  std::vector<Observation> plain = fitter.observations();
  double places = 0.0;
  for (Observation& seen : plain) places += even_out(seen);
  const GapFitter even(fitter.model(), plain);
  const Linearised level = even.linearise(fit, false);
  MatrixXd contributions(even.rows(), static_cast<Index>(fit.named.size()));
  for (std::size_t i = 0; i < fit.named.size(); ++i)
    contributions.col(static_cast<Index>(i)) =
        even.contribution(level, fit.named[i].candidate.with(fit.named[i].coefficients));
  const EvidenceProblem left =
      eliminate_baseline(contributions.col(0) * 0.0, level.baseline, even.baseline_sd(GapPriors{}),
                         contributions, std::vector<int>(fit.named.size(), 1));
  for (std::size_t i = 0; i < fit.named.size(); ++i)
    size.push_back(1e-6 * std::sqrt(left.gram(static_cast<Index>(i), static_cast<Index>(i)) / places));
  return size;
}

Weights weigh(const GapFitter& strict, const GapFit& fit, const std::vector<Candidate>& candidates) {
  const GapPriors priors;
  const EvidenceOptions options;
  Weights weights;
  if (fit.named.empty()) return weights;
  const std::vector<Observation> loose = with_model_form(strict, fit);
  const GapFitter fitter(strict.model(), loose);
  const Linearised at = fitter.linearise(fit, true);
  std::vector<Candidate> all;
  std::vector<VectorXd> now;
  for (const NamedEffect& named : fit.named) {
    all.push_back(named.candidate);
    now.push_back(named.coefficients);
  }
  const std::size_t named_count = all.size();
  for (const Candidate& candidate : candidates) {
    all.push_back(candidate);
    now.emplace_back();
  }
  for (std::size_t i = 0; i < named_count; ++i)  // each as one column: what it does in full
    if (all[i].width() == 2 && all[i].form == Candidate::Form::kSizes) {
      all[i].slots.pop_back();
      all[i].typical.pop_back();
      all[i].effect.values[1] = fit.named[i].candidate.with(fit.named[i].coefficients).values[1];
      now[i] = fit.named[i].coefficients.head(1);
    }
  const Columns columns = all_columns(fitter, at, all, now, Slope::kChord);
  const Nuisances nuisances = nuisances_of(fitter, at, priors);
  const EvidenceProblem problem = eliminate_baseline(about_zero(fitter, at, fit), nuisances.columns,
                                                     nuisances.sd, columns.all, columns.widths);
  std::vector<int> set;
  for (std::size_t i = 0; i < named_count; ++i) set.push_back(static_cast<int>(i));
  const double whole = log_evidence(problem, set, options.prior_sd);
  const MatrixXd alike = resemblance(problem);
  const Index named_columns = columns.begin[named_count - 1] + columns.widths[named_count - 1];
  Index shape_begin = 0;
  for (std::size_t i = 0; i < named_count; ++i) {
    std::vector<int> without = set;
    without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
    weights.evidence.push_back(whole - log_evidence(problem, without, options.prior_sd));
    if (const Index width = shape_width(fit.named[i]); width > 0) {
      // What it may be beside its formula does not count against the formula.
      Nuisances others;
      others.columns.resize(nuisances.columns.rows(), nuisances.columns.cols() - width);
      const Index before = at.baseline.cols() + shape_begin, behind = others.columns.cols() - before;
      others.columns << nuisances.columns.leftCols(before), nuisances.columns.rightCols(behind);
      others.sd.resize(others.columns.cols());
      others.sd << nuisances.sd.head(before), nuisances.sd.tail(behind);
      const EvidenceProblem own = eliminate_baseline(
          about_zero(fitter, at, fit), others.columns, others.sd, columns.all.leftCols(named_columns),
          {columns.widths.begin(), columns.widths.begin() + static_cast<std::ptrdiff_t>(named_count)});
      weights.evidence.back() =
          log_evidence(own, set, options.prior_sd) - log_evidence(own, without, options.prior_sd);
      shape_begin += width;
    }
    weights.twins.emplace_back();
    for (std::size_t c = named_count; c < all.size(); ++c) {
      if (rivals(all[c], all[i]) || all[c].label() == all[i].label()) continue;
      const double like = alike(static_cast<Index>(i), static_cast<Index>(c));
      if (like < kNotToldApart) continue;
      std::vector<int> instead = without;
      instead.push_back(static_cast<int>(c));
      const double odds = log_evidence(problem, instead, options.prior_sd) - whole;
      if (odds > -kAlternative) weights.twins.back().push_back({c - named_count, odds, like});
    }
  }
  weights.size = sizes(strict, fit);
  return weights;
}

}  // namespace ballbar
