#include "gap/next_test.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <optional>

#include "core/error.hpp"
#include "core/units.hpp"
#include "physics/catalogue.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Of an effect, that its formula may be wrong by: where a gap is crossed is known roughly, and so are
/// masses.
constexpr double kFormulaOfTest = 0.02, kRoughFormula = 0.10;
constexpr double kLargest = 20.0;  // times its size that a rival may be
constexpr std::size_t kTestsShown = 5;

std::string whole(double value) { return std::to_string(std::lround(value)); }

/// Those of a candidate that a diagnosis named as a twin.
const Candidate* find_twin(const std::vector<Candidate>& candidates, const Twin& twin) {
  for (const Candidate& candidate : candidates)
    if (candidate.label() == twin.label) return &candidate;
  return nullptr;
}

std::string joint_of_pair(int joint) { return joint > 0 ? " of joint " + std::to_string(joint) : ""; }

/// What the effects of a diagnosis are called, and what they do; nothing for those without a model.
std::optional<Suspect> suspect_of(const EffectSpec& spec) {
  const EffectKind* kind = find_effect_kind(spec.effect);
  if (!kind || !kind->forward || effect_fault(spec)) return std::nullopt;
  return Suspect{spec.effect + joint_of_pair(spec.joint), {make_effect(spec)}, false};
}

}  // namespace

Suspect suspect_of(const Candidate& candidate, double size) {
  Suspect suspect{candidate.label(), {}, candidate.positive};
  const Index width = candidate.width();
  for (Index i = 0; i < width; ++i)
    suspect.columns.push_back(candidate.with(size * VectorXd::Unit(width, i)));
  return suspect;
}

Information information_of(const GapModel& model, const std::vector<Observation>& observations,
                           const GapState& state, const std::vector<Suspect>& suspects) {
  const GapFitter fitter(model, observations);
  GapFit fit;
  fit.state = state;
  const Linearised at = fitter.linearise(fit, false);
  Index columns = 0;
  for (const Suspect& suspect : suspects) columns += static_cast<Index>(suspect.columns.size());
  const Layout layout(state);
  const std::vector<Index> hold = layout.shared();
  const auto before = static_cast<Index>(hold.size());
  MatrixXd shared(fitter.rows(), before + columns);
  shared.leftCols(before) = at.baseline(Eigen::all, hold);
  const MatrixXd own = at.baseline(Eigen::all, layout.own());
  const VectorXd own_sd = fitter.baseline_sd(GapPriors{})(layout.own());
  for (std::size_t i = 0; i < observations.size(); ++i) {
    Drive drive = at.tangents[i].drive();
    MatrixXd values(observations[i].places(), columns);
    Index k = 0;
    for (const Suspect& suspect : suspects)
      for (const Effect& effect : suspect.columns)
        values.col(k++) = model.push(at.tangents[i], drive, effect);
    shared.block(at.begin[i], before, observations[i].measured.size(), columns) = fitter.whitened(i, values);
  }
  MatrixXd normal = own.transpose() * own;
  normal.diagonal() += own_sd.cwiseAbs2().cwiseInverse();
  const MatrixXd across = own.transpose() * shared;
  return shared.transpose() * shared - across.transpose() * normal.llt().solve(across);
}

Judge::Judge(const Information& all, const std::vector<Suspect>& suspects, int joints) : suspects_(suspects) {
  const GapPriors priors;
  const Index shared = joints + 2, columns = all.cols() - shared;
  MatrixXd normal = all.topLeftCorner(shared, shared);
  for (Index j = 0; j < joints; ++j) normal(j, j) += 1.0 / (priors.zero * priors.zero);
  normal(joints, joints) += 1.0 / (priors.bar_zero * priors.bar_zero);
  normal(joints + 1, joints + 1) += 1.0 / (priors.bar_scale * priors.bar_scale);
  const MatrixXd across = all.topRightCorner(shared, columns);
  gram_ = all.bottomRightCorner(columns, columns) - across.transpose() * normal.llt().solve(across);
  Index at = 0;
  for (const Suspect& suspect : suspects) {
    begin_.push_back(at);
    at += static_cast<Index>(suspect.columns.size());
  }
  begin_.push_back(at);
}

double Judge::like(std::size_t a, std::size_t b) const {
  const double own = gram_(begin_[b], begin_[b]);
  return own > 0.0 ? gram_(begin_[b], begin_[a]) / own : 0.0;
}

Separation Judge::of(std::size_t a, std::size_t b, const std::vector<std::size_t>& others) const {
  std::vector<Index> rest;
  const auto add = [&](std::size_t suspect) {
    for (Index k = begin_[suspect]; k < begin_[suspect + 1]; ++k) rest.push_back(k);
  };
  if (b != a) add(b);
  for (const std::size_t other : others) add(other);
  const Index width = begin_[a + 1] - begin_[a], n = static_cast<Index>(rest.size());
  const MatrixXd whole = gram_.block(begin_[a], begin_[a], width, width);
  MatrixXd left = whole;
  if (n > 0) {
    MatrixXd normal(n, n), across(n, width);
    for (Index i = 0; i < n; ++i) {
      for (Index k = 0; k < n; ++k)
        normal(i, k) = gram_(rest[static_cast<std::size_t>(i)], rest[static_cast<std::size_t>(k)]);
      normal(i, i) += 1.0 / (kLargest * kLargest);
      across.row(i) = gram_.row(rest[static_cast<std::size_t>(i)]).segment(begin_[a], width);
    }
    const MatrixXd sizes = normal.llt().solve(across);
    if (b != a && suspects_[b].positive && width == 1 && sizes(0, 0) < 0.0) return of(a, a, others);
    left -= across.transpose() * sizes;
  }
  const Eigen::SelfAdjointEigenSolver<MatrixXd> solver(left);
  const VectorXd worst = solver.eigenvectors().col(0);
  const double energy = std::max(0.0, solver.eigenvalues()[0]);
  const std::string_view name = suspects_[a].columns.front().kind->name;
  const bool rough = name == "joint_lost_motion" || name == "joint_compliance";
  const double formula = rough ? kRoughFormula : kFormulaOfTest;
  const double all = std::max(0.0, worst.dot(whole * worst));
  return {std::sqrt(energy), std::sqrt(energy / (1.0 + formula * formula * all))};
}

std::vector<PairPlan> plan_for(const GapModel& model, const std::vector<Observation>& driven,
                               const Diagnosis& diagnosis, const std::vector<ProposedTest>& proposed,
                               const Progress& progress) {
  const std::vector<Candidate> candidates = candidates_for(model, driven);
  std::vector<Suspect> suspects;
  struct Pair {
    std::size_t a, b;
    const Candidate* twin;
  };
  std::vector<Pair> pairs;
  std::vector<std::size_t> named;
  for (const LeftOut& one : diagnosis.left_out) {
    if (one.level == 1) continue;  // the joints' zeros are always free
    std::optional<Suspect> suspect = suspect_of(one.spec);
    if (!suspect) continue;
    const std::size_t a = suspects.size();
    named.push_back(a);
    suspects.push_back(std::move(*suspect));
    for (const Twin& twin : one.twins) {
      const Candidate* candidate = find_twin(candidates, twin);
      if (!candidate) continue;
      pairs.push_back({a, suspects.size(), candidate});
      suspects.push_back(suspect_of(*candidate));
      suspects.back().label = twin.effect + joint_of_pair(twin.joint);
    }
  }
  if (pairs.empty()) return {};
  const GapState state = model.start(driven);
  Information now = information_of(model, driven, state, suspects);
  {  // a pattern that hangs on its size is looked at where it comes nearest
    const Judge judge(now, suspects, model.joints());
    for (const Pair& pair : pairs)
      if (pair.twin->width() == 1)
        suspects[pair.b].columns =
            suspect_of(*pair.twin, std::clamp(judge.like(pair.a, pair.b), 0.05, kLargest)).columns;
    now = information_of(model, driven, state, suspects);
  }
  const PlannedNoise noise(driven);
  std::vector<Information> with;
  for (std::size_t t = 0; t < proposed.size(); ++t) {
    if (progress) progress(t, proposed.size());
    const std::vector<Observation> seen = as_observed(model, proposed[t].test, 0, noise.of(proposed[t].test));
    with.push_back(now + information_of(model, seen, model.start(seen), suspects));
  }
  std::vector<PairPlan> plans;
  const Judge today(now, suspects, model.joints());
  for (const Pair& pair : pairs) {
    std::vector<std::size_t> others;
    for (const std::size_t other : named)
      if (other != pair.a) others.push_back(other);
    PairPlan plan{suspects[pair.a].label, suspects[pair.b].label, today.of(pair.a, pair.b, others), {}};
    for (std::size_t t = 0; t < proposed.size(); ++t) {
      const Separation then = Judge(with[t], suspects, model.joints()).of(pair.a, pair.b, others);
      plan.tests.push_back({proposed[t], then.noise, then.sure, then.sure >= kSure ? 1u : 0u});
    }
    std::stable_sort(plan.tests.begin(), plan.tests.end(),
                     [](const RankedTest& x, const RankedTest& y) { return x.sure > y.sure; });
    if (plan.tests.size() > kTestsShown) plan.tests.resize(kTestsShown);
    plans.push_back(std::move(plan));
  }
  return plans;
}

std::string sentence_of(const RankedTest& best, const Separation& now) {
  const TestSpec& test = best.proposed.test;
  const std::string what =
      test.kind == TestKind::kLine
          ? "drive a " + best.proposed.differs + ", at " + whole(to_mm(test.feed)) + " mm/s"
          : "drive a circle of radius " + whole(to_mm(test.circle.radius)) + " mm at " +
                whole(to_mm(test.feed)) + " mm/s, " + best.proposed.differs;
  std::string text = what + ", both ways, twice: it takes them from " + whole(now.noise) + " to " +
                     whole(best.noise) + " standard deviations of noise apart";
  if (best.sure < kSure) text += ", which is still too little to be sure of";
  return text;
}

bool has_twins(const Diagnosis& diagnosis) {
  return std::any_of(diagnosis.left_out.begin(), diagnosis.left_out.end(),
                     [](const LeftOut& one) { return !one.twins.empty(); });
}

void suggest(const std::vector<PairPlan>& plans, Diagnosis& diagnosis) {
  std::size_t next = 0;
  for (LeftOut& one : diagnosis.left_out)
    for (Twin& twin : one.twins) {
      if (next == plans.size()) return;
      const PairPlan& plan = plans[next];
      if (plan.a != one.spec.effect + joint_of_pair(one.spec.joint) ||
          plan.b != twin.effect + joint_of_pair(twin.joint))
        continue;
      ++next;
      if (!plan.tests.empty() && plan.tests.front().noise > 1.5 * plan.now.noise + 1.0)
        twin.to_tell_apart = sentence_of(plan.tests.front(), plan.now);
    }
}

std::vector<Suspect> suspects_of(const GapModel& model, const std::vector<std::string>& names) {
  std::vector<Suspect> all;
  std::vector<bool> used(names.size(), false);
  for (const Candidate& candidate : candidates_for(model, {})) {
    const std::string name(candidate.effect.kind->name);
    const std::string with_joint = name + ":" + std::to_string(candidate.effect.joint);
    // Kinds of lost motion are weighed against each other where they are found.
    if (candidate.family == "lost motion" &&
        candidate.effect.word != lost_motion_kinds(1).front().effect.word)
      continue;
    bool wanted = names.empty();
    for (std::size_t i = 0; i < names.size(); ++i)
      if (names[i] == name || names[i] == with_joint) wanted = used[i] = true;
    if (wanted) all.push_back(suspect_of(candidate));
  }
  for (std::size_t i = 0; i < names.size(); ++i)
    if (!used[i])
      throw Error(Cause::kInput, "--effects " + names[i] +
                                     ": no effect of this robot that a test could show; write EFFECT or "
                                     "EFFECT:JOINT as in docs/effects.md, e.g. servo_lag:3");
  return all;
}

namespace {

/// Smallest of both ways round: neither can be mistaken for the other.
double sure_of(const Judge& judge, std::size_t a, std::size_t b) {
  return std::min(judge.of(a, b).sure, judge.of(b, a).sure);
}

}  // namespace

RobotPlan plan_for_robot(const GapModel& model, const std::vector<Observation>& driven,
                         const std::vector<Suspect>& suspects, const std::vector<ProposedTest>& proposed,
                         std::size_t most, const Progress& progress) {
  RobotPlan plan;
  plan.effects = suspects.size();
  const int joints = model.joints();
  Index size = joints + 2;
  for (const Suspect& suspect : suspects) size += static_cast<Index>(suspect.columns.size());
  Information known = MatrixXd::Zero(size, size);
  if (!driven.empty()) known = information_of(model, driven, model.start(driven), suspects);
  const PlannedNoise noise(driven);
  std::vector<Information> says;
  Information everything = known;
  for (std::size_t t = 0; t < proposed.size(); ++t) {
    if (progress) progress(t, proposed.size());
    const std::vector<Observation> seen = as_observed(model, proposed[t].test, 0, noise.of(proposed[t].test));
    says.push_back(information_of(model, seen, model.start(seen), suspects));
    everything += says.back();
  }
  const Judge best(everything, suspects, joints), today(known, suspects, joints);
  std::vector<std::pair<std::size_t, std::size_t>> open;
  for (std::size_t a = 0; a < suspects.size(); ++a) {
    if (today.of(a).sure >= kSure) ++plan.visible;
    if (best.of(a).sure < kSure) continue;
    for (std::size_t b = a + 1; b < suspects.size(); ++b) {
      if (best.of(b).sure < kSure) continue;
      ++plan.pairs;
      if (sure_of(today, a, b) >= kSure)
        ++plan.apart;
      else if (sure_of(best, a, b) >= kSure)
        open.emplace_back(a, b);
      else
        plan.never.push_back(suspects[a].label + " and " + suspects[b].label);
    }
  }
  plan.apart_with_all = plan.apart;
  while (plan.tests.size() < most && !open.empty()) {
    double best_score = -1.0;
    std::size_t chosen = 0, chosen_decides = 0;
    for (std::size_t t = 0; t < proposed.size(); ++t) {
      const Judge judge(known + says[t], suspects, joints);
      double score = 0.0;
      std::size_t decides = 0;
      for (const auto& [a, b] : open) {
        const double sure = sure_of(judge, a, b);
        if (sure >= kSure) ++decides;
        score += std::min(sure, kSure) / kSure + 1e-3 * sure;
      }
      score += static_cast<double>(decides);
      if (score <= best_score) continue;
      best_score = score;
      chosen = t;
      chosen_decides = decides;
    }
    if (best_score < 0.0) break;
    known += says[chosen];
    const Judge judge(known, suspects, joints);
    plan.tests.push_back({proposed[chosen], 0.0, 0.0, chosen_decides});
    std::erase_if(open, [&](const auto& pair) { return sure_of(judge, pair.first, pair.second) >= kSure; });
    plan.apart_with_all += chosen_decides;
    if (suspects.size() == 2) {
      const Separation then = judge.of(0, 1);
      plan.tests.back().noise = then.noise;
      plan.tests.back().sure = then.sure;
    }
  }
  return plan;
}

}  // namespace ballbar
