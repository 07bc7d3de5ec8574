#include "gap/search.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <string>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Effects at most that a round may name: what is large first, with its pattern at its own size, before the
/// rest is looked at (physics-gap.md 8.4).
constexpr std::array<int, 6> kMostGroups{2, 4, 6, 9, 9, 9};
constexpr int kStepsOfRound = 4;     // the next round goes on from there
constexpr double kModelForm = 0.02;  // of the explained signal: physics-gap.md 5, step 7
constexpr double kGapForm = 0.10;  // of what lost motion explains: where the gap is crossed is known roughly
constexpr Index kSmooth = 8;       // coefficients on either side over which that is spread

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
    Drive drive = tangent.drive();
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
    double size = fit.named[i].coefficients[0];
    for (std::size_t j = fit.named.size(); j-- > i + 1;)
      if (rivals(fit.named[i].candidate, fit.named[j].candidate))
        fit.named.erase(fit.named.begin() + static_cast<std::ptrdiff_t>(j));
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

/// Residual and baseline about zero, and whatever is in the model: all compete again with all others.
VectorXd about_zero(const GapFitter& fitter, const Linearised& at, const GapFit& fit) {
  VectorXd y = at.residual + at.baseline * fitter.baseline_of(fit.state);
  for (const NamedEffect& named : fit.named)
    y += fitter.contribution(at, named.candidate.with(named.coefficients));
  return y;
}

GapFit baseline_fit(const GapFitter& fitter) {
  GapPriors frozen;
  frozen.shift = 0.0;  // released only with effects in the model: physics-gap.md 8.2
  GapFit fit;
  fit.state = fitter.model().start(fitter.observations());
  return fitter.fit(fit, frozen, false, 4);
}

}  // namespace

Found search_effects(const GapFitter& strict, const std::vector<Candidate>& candidates,
                     const std::optional<Curve>& curve) {
  const GapPriors priors;
  Found found;
  GapFit fit = baseline_fit(strict);
  fit.curve = curve;
  std::vector<VectorXd> now(candidates.size());
  std::vector<std::size_t> last;
  for (std::size_t round = 0; round < kMostGroups.size(); ++round) {
    const std::vector<Observation> loose = with_model_form(strict, fit);
    const GapFitter fitter(strict.model(), loose);
    const Linearised at = fitter.linearise(fit, true);
    const Columns columns = all_columns(fitter, at, candidates, now, Slope::kChord);
    const Nuisances nuisances = nuisances_of(fitter, at, priors);
    const EvidenceProblem problem = eliminate_baseline(about_zero(fitter, at, fit), nuisances.columns,
                                                       nuisances.sd, columns.all, columns.widths);
    const std::vector<std::size_t> chosen =
        choose(problem, columns, candidates, kMostGroups[round], found.evidence);
    GapFit next = fit;
    next.named.clear();
    next.shape.resize(0);
    Index k = 0;
    for (const std::size_t c : chosen) {
      next.named.push_back({candidates[c], found.evidence.posterior.mean.segment(k, columns.widths[c])});
      k += columns.widths[c];
    }
    fit = fitter.fit(with_kinds_weighed(fitter, next, priors), priors, true, kStepsOfRound);
    for (VectorXd& size : now) size.resize(0);
    for (const NamedEffect& named : fit.named)
      for (std::size_t c = 0; c < candidates.size(); ++c)
        if (rivals(candidates[c], named.candidate) || candidates[c].label() == named.candidate.label())
          now[c] = named.coefficients.head(candidates[c].width());
    if (chosen == last) break;
    last = chosen;
  }
  found.fit = std::move(fit);
  return found;
}

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
  for (std::size_t i = 0; i < named_count; ++i) {
    std::vector<int> without = set;
    without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
    weights.evidence.push_back(whole - log_evidence(problem, without, options.prior_sd));
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

namespace {

std::vector<Curve> all_curves(const GapFitter& fitter, const Linearised& at) {
  std::vector<Curve> curves;
  for (int joint = 1; joint <= fitter.model().joints(); ++joint)
    for (const auto& [driver, intervals] : {std::pair{Driver::kAngle, 12},
                                            {Driver::kAngle, 50},
                                            {Driver::kVelocity, 10},
                                            {Driver::kDirection, 12},
                                            {Driver::kTorque, 10}}) {
      Curve curve{joint, driver, 1e300, -1e300, intervals};
      if (driver == Driver::kTorque && !fitter.model().loads_known()) continue;
      double arm = 0.0;
      for (const Tangent& tangent : at.tangents) {
        Drive drive = tangent.drive();
        const VectorXd values = driver_of(curve, tangent, drive);
        curve.from = std::min(curve.from, values.minCoeff());
        curve.to = std::max(curve.to, values.maxCoeff());
        arm = std::max(arm, tangent.joint.col(joint - 1).cwiseAbs().maxCoeff());
      }
      const bool moves =
          driver == Driver::kTorque ? curve.to - curve.from > 0.05 : curve.to - curve.from > 1e-3;
      if (arm > 1e-3 && moves) curves.push_back(curve);
    }
  return curves;
}

}  // namespace

std::vector<Curve> promising_curves(const GapFitter& fitter, const std::vector<Candidate>& candidates,
                                    std::size_t most) {
  const GapPriors priors;
  const GapFit fit = baseline_fit(fitter);
  const Linearised at = fitter.linearise(fit, false);
  const Columns columns =
      all_columns(fitter, at, candidates, std::vector<VectorXd>(candidates.size()), Slope::kChord);
  const Nuisances nuisances = nuisances_of(fitter, at, priors);
  const std::vector<Curve> curves = all_curves(fitter, at);
  MatrixXd all(fitter.rows(), columns.all.cols());
  all = columns.all;
  std::vector<int> widths = columns.widths;
  for (const Curve& curve : curves) {
    const Index begin = all.cols();
    all.conservativeResize(Eigen::NoChange, begin + curve.width());
    for (std::size_t i = 0; i < at.tangents.size(); ++i) {
      const Tangent& tangent = at.tangents[i];
      Drive drive = tangent.drive();
      all.block(at.begin[i], begin, fitter.observations()[i].measured.size(), curve.width()) =
          fitter.whitened(i, curve_columns(curve, tangent, drive));
    }
    widths.push_back(static_cast<int>(curve.width()));
  }
  const EvidenceProblem problem =
      eliminate_baseline(about_zero(fitter, at, fit), nuisances.columns, nuisances.sd, all, widths);
  const Index catalogue = columns.all.cols();
  std::vector<std::pair<double, std::size_t>> ranked;
  for (std::size_t c = 0; c < curves.size(); ++c) {
    // The curve is integrated out as the baseline was; what is left is a search in the catalogue.
    const Index begin = problem.begin[candidates.size() + c], width = curves[c].width();
    MatrixXd a = problem.gram.block(begin, begin, width, width) + MatrixXd::Identity(width, width);
    const Eigen::LLT<MatrixXd> factor(a);
    const MatrixXd half = factor.matrixL().solve(problem.gram.block(begin, 0, width, catalogue));
    const VectorXd part = factor.matrixL().solve(problem.projection.segment(begin, width));
    EvidenceProblem beside;
    beside.gram = problem.gram.topLeftCorner(catalogue, catalogue) - half.transpose() * half;
    beside.projection = problem.projection.head(catalogue) - half.transpose() * part;
    beside.raw_energy = problem.raw_energy.head(catalogue);
    beside.begin.assign(problem.begin.begin(),
                        problem.begin.begin() + static_cast<std::ptrdiff_t>(candidates.size()) + 1);
    const double own = 0.5 * part.squaredNorm() - factor.matrixLLT().diagonal().array().log().sum();
    EvidenceOptions options;
    options.max_groups = 2;
    ranked.emplace_back(-(own + search_evidence(beside, options).best().log_odds), c);
  }
  std::sort(ranked.begin(), ranked.end());
  std::vector<Curve> best;
  for (std::size_t i = 0; i < std::min(most, ranked.size()); ++i) best.push_back(curves[ranked[i].second]);
  return best;
}

}  // namespace ballbar
