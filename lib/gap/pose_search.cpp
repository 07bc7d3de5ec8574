#include "gap/pose_search.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <utility>

#include "gap/pose_elimination.hpp"
#include "gap/pose_scan.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kPeaksPerJoint = 8;
constexpr double kRippleTypical = 5e-5;  // [rad] 10 arcsec
constexpr double kJumpTypical = 1e-4;    // [m]
constexpr double kCurvePenalty = 8.0;    // [ln of odds] a name of the catalogue is to be preferred
constexpr int kGroupsAtOnce = 9;
constexpr int kPlacesForRipples = 100;  // fewer of them fit some rate whatever they hold

bool is_curve(PoseEffect effect) {
  return effect == PoseEffect::kAngleCurve || effect == PoseEffect::kTimeCurve;
}

/// Candidates of one search and what each of them costs beside the search's own prior.
class Rounds {
 public:
  Rounds(const PoseModel& model, const std::vector<PoseRow>& rows, const PoseFit& fit,
         const PoseSearchOptions& options)
      : model_(model), rows_(rows), options_(options), poses_(model, rows, fit, options.least_sd) {
    for (const PoseTerm& term : fit.state.terms) {
      known_.push_back(term);
      penalty_.push_back(0.0);
    }
  }

  void add(const std::vector<PoseTerm>& terms) {
    for (const PoseTerm& term : terms) {
      const bool there =
          std::any_of(known_.begin(), known_.end(), [&](const PoseTerm& k) { return k.same_as(term); });
      if (there) continue;
      poses_.add(term);
      penalty_.push_back(is_curve(term.effect) ? kCurvePenalty : 0.0);
    }
  }

  /// Peaks of what is left, as candidates.
  void scan() {
    std::vector<PosePeak> ripples;
    if (places_of(rows_) >= kPlacesForRipples)
      ripples = scan_ripples(rows_, poses_.geometry(), poses_.residual(), model_.per_row(), poses_.sd(),
                             options_.most_cycles, kPeaksPerJoint);
    for (const PosePeak& peak : ripples) {
      poses_.add({PoseEffect::kRipple, peak.joint, peak.setting, peak.stroke, kRippleTypical, 2});
      penalty_.push_back(std::log(std::max(1.0, peak.places / kPeaksPerJoint)));
    }
    for (const PosePeak& peak : scan_jumps(rows_, poses_.residual(), model_.per_row(), poses_.sd())) {
      poses_.add({PoseEffect::kJump, 0, peak.setting, 0.0, kJumpTypical, model_.per_row()});
      penalty_.push_back(std::log(std::max(1.0, peak.places)));
    }
  }

  /// One evidence search over what is not in yet. @return how many were taken
  int round(int most) {
    std::vector<int> free;
    for (int c = 0; c < poses_.candidates(); ++c)
      if (!poses_.taken(c)) free.push_back(c);
    if (free.empty()) return 0;
    const EvidenceProblem problem = poses_.problem(free);
    EvidenceOptions options;
    options.prior_sd = kPosePrior;
    options.max_groups = most;
    std::vector<int> set = search_evidence(problem, options).best().groups;
    while (prune(problem, free, set)) {
    }
    for (const int g : set) poses_.take(free[static_cast<std::size_t>(g)]);
    if (!set.empty()) poses_.solve();
    return static_cast<int>(set.size());
  }

  PoseState state() const { return poses_.state(); }

 private:
  /// Removes the one of the set that pays its price least. @return whether one was removed
  bool prune(const EvidenceProblem& problem, const std::vector<int>& free, std::vector<int>& set) const {
    if (set.empty()) return false;
    const double all = log_evidence(problem, set, kPosePrior);
    const double prior = std::log(0.5 / std::max(1, problem.groups()));
    const EvidencePosterior posterior = evidence_posterior(problem, set, kPosePrior);
    double worst = 0.0;
    std::size_t which = set.size();
    Index at = 0;
    for (std::size_t i = 0; i < set.size(); ++i) {
      std::vector<int> without = set;
      without.erase(without.begin() + static_cast<std::ptrdiff_t>(i));
      double margin = all - log_evidence(problem, without, kPosePrior) + prior -
                      penalty_[static_cast<std::size_t>(free[static_cast<std::size_t>(set[i])])];
      const Index begin = problem.begin[static_cast<std::size_t>(set[i])], width = problem.width(set[i]);
      const VectorXd value = posterior.mean.segment(at, width);
      at += width;
      const double explained = value.dot(problem.gram.block(begin, begin, width, width) * value);
      // [standard deviations of the readings], root mean square over the rows
      if (std::sqrt(explained / static_cast<double>(rows_.size())) < options_.material)
        margin = std::min(margin, -1.0);
      if (margin < worst) {
        worst = margin;
        which = i;
      }
    }
    if (which == set.size()) return false;
    set.erase(set.begin() + static_cast<std::ptrdiff_t>(which));
    return true;
  }

  const PoseModel& model_;
  const std::vector<PoseRow>& rows_;
  PoseSearchOptions options_;
  PoseElimination poses_;
  std::vector<PoseTerm> known_;
  std::vector<double> penalty_;

 public:
  int candidates() const { return poses_.candidates(); }
  void drop(int first) {
    poses_.drop_candidates(first);
    penalty_.resize(static_cast<std::size_t>(poses_.candidates()));
  }
};

}  // namespace

PoseState search_poses(const PoseModel& model, const std::vector<PoseRow>& rows, const PoseFit& fit,
                       const std::vector<PoseTerm>& candidates, const PoseSearchOptions& options) {
  Rounds rounds(model, rows, fit, options);
  rounds.add(candidates);
  for (int i = 0; i < options.rounds; ++i) {
    const int before = rounds.candidates();
    rounds.scan();
    int taken = 0;
    while (const int more = rounds.round(kGroupsAtOnce)) taken += more;
    rounds.drop(before);
    if (taken == 0) break;
  }
  return rounds.state();
}

PoseState select_terms(const PoseModel& model, const std::vector<PoseRow>& rows, const PoseFit& fit,
                       const std::vector<PoseTerm>& candidates, const PoseSearchOptions& options) {
  Rounds rounds(model, rows, fit, options);
  rounds.add(candidates);
  while (rounds.round(static_cast<int>(candidates.size())) > 0) {
  }
  return rounds.state();
}

PoseState refine_rates(const PoseModel& model, const std::vector<PoseRow>& rows, const PoseFit& fit) {
  constexpr double kOff = 0.1;  // of the resolution, 2 pi / stroke
  PoseElimination poses(model, rows, fit, fit.sd);
  std::vector<std::pair<std::size_t, int>> rates;  // term, candidate
  std::size_t value = 0;
  for (std::size_t i = 0; i < fit.state.terms.size(); ++i) {
    const PoseTerm& term = fit.state.terms[i];
    if (term.effect == PoseEffect::kRipple) {
      const double s = fit.state.values[value], c = fit.state.values[value + 1], amplitude = std::hypot(s, c);
      if (amplitude > 0.0) {
        const double typical = amplitude * kOff * 2.0 * std::numbers::pi / term.setting2;
        rates.emplace_back(
            i, poses.add({PoseEffect::kRippleRate, term.joint, term.setting, std::atan2(c, s), typical, 1}));
        poses.take(rates.back().second);
      }
    }
    value += static_cast<std::size_t>(term.width);
  }
  PoseState refined = fit.state;
  if (rates.empty()) return refined;
  poses.solve();
  const PoseState solved = poses.state();
  for (std::size_t k = 0; k < rates.size(); ++k) {
    const PoseTerm& rate = poses.term(rates[k].second);
    const double resolution = 2.0 * std::numbers::pi / fit.state.terms[rates[k].first].setting2;
    const double amplitude = rate.typical / (kOff * resolution);
    const double off = solved.values[solved.values.size() - rates.size() + k] / amplitude;
    refined.terms[rates[k].first].setting += std::clamp(off, -0.3 * resolution, 0.3 * resolution);
  }
  return refined;
}

std::vector<PoseTermWorth> term_worth(const PoseModel& model, const std::vector<PoseRow>& rows,
                                      const PoseFit& fit, const std::vector<PoseTerm>& rivals,
                                      std::vector<std::vector<PoseTerm>>* confused) {
  std::vector<PoseTermWorth> worth;
  Index at = 0;
  double total = 0.0;
  for (const PoseTerm& term : fit.state.terms) {
    const MatrixXd covariance = fit.covariance.block(at, at, term.width, term.width);
    const VectorXd value = Eigen::Map<const VectorXd>(fit.state.values.data() + at, term.width);
    const Eigen::LLT<MatrixXd> factor(covariance);
    const double squared = value.dot(factor.solve(value));
    const double prior_variance = std::pow(kPosePrior * term.typical, 2);
    PoseTermWorth w;
    // Density of "nothing" before over after: Dickey, Ann. Math. Stat. 42 (1971) 204, exact for normal ones.
    w.evidence = 0.5 * squared + factor.matrixLLT().diagonal().array().log().sum() -
                 0.5 * term.width * std::log(prior_variance);
    const double explained = std::max(0.0, squared - value.squaredNorm() / prior_variance) * fit.sd * fit.sd;
    w.contribution = std::sqrt(explained / static_cast<double>(rows.size()));
    w.share = explained;
    total += explained;
    worth.push_back(w);
    at += term.width;
  }
  for (PoseTermWorth& w : worth) w.share = total > 0.0 ? w.share / total : 0.0;
  if (confused == nullptr) return worth;
  confused->assign(fit.state.terms.size(), {});
  PoseElimination poses(model, rows, fit, fit.sd);
  std::vector<int> others;
  for (const PoseTerm& rival : rivals) {
    const bool in = std::any_of(fit.state.terms.begin(), fit.state.terms.end(),
                                [&](const PoseTerm& t) { return t.same_as(rival); });
    if (!in) others.push_back(poses.add(rival));
  }
  for (std::size_t g = 0; g < fit.state.terms.size(); ++g) {
    if (fit.state.terms[g].effect == PoseEffect::kRipple) continue;
    std::vector<int> numbers{static_cast<int>(g)};
    numbers.insert(numbers.end(), others.begin(), others.end());
    poses.release(static_cast<int>(g));
    const MatrixXd alike = resemblance(poses.problem(numbers));
    poses.take(static_cast<int>(g));
    for (Index k = 1; k < alike.cols(); ++k)
      if (alike(0, k) > kNotToldApart)
        (*confused)[g].push_back(poses.term(numbers[static_cast<std::size_t>(k)]));
  }
  return worth;
}

}  // namespace ballbar
