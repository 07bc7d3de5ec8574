#include "gap/pose_diagnosis.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/error.hpp"
#include "gap/pose_elimination.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int kSmallSet = 400;  // rows up to which every part of a split is left out in turn
constexpr int kParts = 5;
constexpr double kAboveNoise = 1.5;  // of the repeats: more is a remainder
constexpr int kPlacesForCurves = 100;

bool is_curve(const PoseTerm& term) {
  return term.effect == PoseEffect::kAngleCurve || term.effect == PoseEffect::kTimeCurve;
}

int level_of(const PoseTerm& term) {
  return term.effect == PoseEffect::kZeroOffset ? 1 : term.effect <= PoseEffect::kLinkBeta ? 2 : 3;
}

PoseState with_terms(PoseState state, const std::vector<PoseTerm>& terms) {
  for (const PoseTerm& term : terms) {
    state.terms.push_back(term);
    state.values.insert(state.values.end(), static_cast<std::size_t>(term.width), 0.0);
  }
  return state;
}

/// The state with those of its terms that `keep` says.
template <typename Keep>
PoseState kept_terms(const PoseState& state, Keep keep) {
  PoseState kept = state;
  kept.terms.clear();
  kept.values.clear();
  auto value = state.values.begin();
  for (std::size_t i = 0; i < state.terms.size(); ++i) {
    if (keep(i)) {
      kept.terms.push_back(state.terms[i]);
      kept.values.insert(kept.values.end(), value, value + state.terms[i].width);
    }
    value += state.terms[i].width;
  }
  return kept;
}

/// Everything from the configured model to the last one, of one set of rows.
struct Fits {
  PoseFit configured, zero_offsets, geometry, compliance, all;
  PoseFit named;  ///< as all, but only with the geometry and compliance that evidence asks for
};

class Fitter {
 public:
  Fitter(const PoseRows& rows, const PoseModel& model, const PoseDiagnosisOptions& options)
      : rows_(rows), model_(model), options_(options) {
    least_sd_ = 0.0;
    if (rows.repeat_dof > 0) {
      double repeats = 0.0;
      for (const PoseRow& row : rows.rows) repeats += 1.0 / row.repeats;
      least_sd_ = rows.repeat_sd * std::sqrt(repeats / static_cast<double>(rows.rows.size()));
    }
    options_.search.least_sd = least_sd_;
  }

  Fits fit(const std::vector<PoseRow>& fitted) const {
    Fits fits;
    fits.configured = fit_poses(model_, fitted, start_poses(model_, rows_), least_sd_);
    const std::vector<PoseTerm> geometry = geometry_terms(model_.chain());
    std::vector<PoseTerm> offsets;
    for (const PoseTerm& term : geometry)
      if (level_of(term) == 1) offsets.push_back(term);
    fits.zero_offsets = fit_poses(model_, fitted, with_terms(fits.configured.state, offsets), least_sd_);
    fits.geometry = fit_poses(model_, fitted, with_terms(fits.configured.state, geometry), least_sd_);
    // Every arm bends under its weight, as every arm is mastered: both are in whether they are named or not,
    // so that nothing rarer is taken for them.
    std::vector<PoseTerm> commonplace = geometry;
    for (const PoseTerm& term : effect_candidates(rows_, fitted))
      if (term.effect == PoseEffect::kCompliance) commonplace.push_back(term);
    fits.compliance = fit_poses(model_, fitted, with_terms(fits.configured.state, commonplace), least_sd_);
    fits.all = searched(fitted, fits.compliance, commonplace.size());
    const PoseState rare = kept_terms(fits.all.state, [&](std::size_t i) { return i >= commonplace.size(); });
    const PoseFit bare = fit_poses(model_, fitted, rare, least_sd_);
    fits.named = fit_poses(model_, fitted, select_terms(model_, fitted, bare, commonplace, options_.search),
                           least_sd_);
    if (fits.named.state.terms.empty()) fits.all = fits.configured;  // nothing is needed: nothing is fitted
    return fits;
  }

  double least_sd() const { return least_sd_; }

 private:
  /// @param always  the first terms of `commonplace` stay whatever they are worth
  PoseFit searched(const std::vector<PoseRow>& fitted, const PoseFit& commonplace, std::size_t always) const {
    std::vector<PoseTerm> candidates = effect_candidates(rows_, fitted);
    PoseFit fit = commonplace;
    for (int stage = 0; stage < 3; ++stage) {  // twice around a better place, then with curves
      const std::size_t before = fit.state.terms.size();
      if (stage == 2 && places_of(fitted) >= kPlacesForCurves)
        for (const PoseTerm& curve : curve_candidates(fitted)) candidates.push_back(curve);
      const PoseState found = search_poses(model_, fitted, fit, candidates, options_.search);
      if (found.terms.size() == before) continue;
      fit = fit_poses(model_, fitted, found, least_sd_);
      for (int i = 0; i < 2; ++i) {
        const PoseFit moved = fit_poses(model_, fitted, refine_rates(model_, fitted, fit), least_sd_);
        if (moved.residual.squaredNorm() > fit.residual.squaredNorm()) break;
        fit = moved;
      }
      fit = without_idle(fitted, fit, always);
    }
    return fit;
  }

  /// Effects that others have made superfluous.
  PoseFit without_idle(const std::vector<PoseRow>& fitted, const PoseFit& fit, std::size_t always) const {
    const std::vector<PoseTermWorth> worth = term_worth(model_, fitted, fit, {}, nullptr);
    const PoseState kept =
        kept_terms(fit.state, [&](std::size_t i) { return i < always || worth[i].evidence > 0.0; });
    return kept.terms.size() == fit.state.terms.size() ? fit : fit_poses(model_, fitted, kept, least_sd_);
  }

  const PoseRows& rows_;
  const PoseModel& model_;
  PoseDiagnosisOptions options_;
  double least_sd_;
};

/// Rows of several series whose base frames agree become rows of one frame: fewer unknowns (Schwarz, Ann.
/// Stat. 6 (1978) 461).
bool share_frame(PoseRows& rows, const PoseModel& model) {
  if (rows.frames.size() < 2 || rows.lengths ||
      std::find(rows.frame_held_out.begin(), rows.frame_held_out.end(), true) != rows.frame_held_out.end())
    return false;
  PoseRows one = rows;
  one.frames = {rows.frames.front()};
  one.frame_held_out = {false};
  for (PoseRow& row : one.rows) row.frame = 0;
  const auto criterion = [&](const PoseRows& set) {
    std::vector<PoseRow> fitted;
    for (const PoseRow& row : set.rows)
      if (!row.held_out) fitted.push_back(row);
    const PoseFit fit =
        fit_poses(model, fitted, with_terms(start_poses(model, set), geometry_terms(model.chain())), 0.0);
    const auto n = static_cast<double>(fit.residual.size());
    return n * std::log(fit.residual.squaredNorm() / n) +
           6.0 * static_cast<double>(set.frames.size()) * std::log(n);
  };
  if (!(criterion(one) < criterion(rows))) return false;
  rows = one;
  return true;
}

std::vector<PoseRow> chosen(const PoseRows& rows, const std::vector<bool>& held, bool which) {
  std::vector<PoseRow> some;
  for (std::size_t i = 0; i < rows.rows.size(); ++i)
    if (held[i] == which) some.push_back(rows.rows[i]);
  return some;
}

/// Evenly over the sequence: more rows than that cost time and tell nothing new.
std::vector<PoseRow> to_fit(const PoseRows& rows, const std::vector<bool>& held, int most) {
  std::vector<PoseRow> all = chosen(rows, held, false);
  if (static_cast<int>(all.size()) <= most) return all;
  std::vector<PoseRow> some;
  for (std::size_t i = 0; i < static_cast<std::size_t>(most); ++i)
    some.push_back(all[i * all.size() / static_cast<std::size_t>(most)]);
  return some;
}

/// Residuals of rows that were not fitted; set-ups that no fitted row has are fitted to them.
VectorXd predicted(const PoseRows& rows, const PoseModel& model, const std::vector<PoseRow>& held,
                   PoseState state) {
  std::vector<PoseRow> strange;
  for (const PoseRow& row : held)
    if (rows.frame_held_out[static_cast<std::size_t>(row.frame)]) strange.push_back(row);
  if (!strange.empty()) state = fit_set_ups(model, strange, state);
  return model.residual(held, state);
}

PoseProof prove(const PoseRows& rows, const PoseModel& model, const Fitter& fitter, const std::string& how,
                const std::vector<std::vector<bool>>& parts, const Fits* known, int most) {
  PoseProof proof;
  proof.how = how;
  proof.parts = static_cast<int>(parts.size());
  const std::vector<std::string> names{"configured", "zero offsets", "geometry", "compliance", "all"};
  std::vector<std::vector<double>> residual(names.size());
  std::vector<double> squares(names.size(), 0.0);
  int fitted_rows = 0;
  for (const std::vector<bool>& held : parts) {
    const std::vector<PoseRow> fitted = to_fit(rows, held, most), left = chosen(rows, held, true);
    const Fits fits = known != nullptr ? *known : fitter.fit(fitted);
    const PoseFit* each[] = {&fits.configured, &fits.zero_offsets, &fits.geometry, &fits.compliance,
                             &fits.all};
    for (std::size_t k = 0; k < names.size(); ++k) {
      const VectorXd r = predicted(rows, model, left, each[k]->state);
      residual[k].insert(residual[k].end(), r.data(), r.data() + r.size());
      squares[k] += each[k]->residual.squaredNorm();
    }
    proof.rows += static_cast<int>(left.size());
    proof.fitted_rows = std::max(proof.fitted_rows, static_cast<int>(fitted.size()));
    fitted_rows += static_cast<int>(fitted.size());
    const PoseCoverage coverage = pose_coverage(fitted, left);
    proof.coverage.outside += coverage.outside;
    proof.coverage.joints.insert(proof.coverage.joints.end(), coverage.joints.begin(), coverage.joints.end());
  }
  for (std::size_t k = 0; k < names.size(); ++k) {
    const VectorXd r = Eigen::Map<const VectorXd>(residual[k].data(), static_cast<Index>(residual[k].size()));
    proof.steps.push_back({names[k], std::sqrt(squares[k] / std::max(1, fitted_rows)),
                           pose_rms(r, model.per_row()), pose_median(r, model.per_row())});
  }
  return proof;
}

std::vector<PoseProof> proofs(const PoseRows& rows, const PoseModel& model, const Fitter& fitter,
                              const Fits& main, const PoseDiagnosisOptions& options) {
  const bool small = static_cast<int>(rows.rows.size()) <= kSmallSet;
  const auto split = [&](const char* how, auto hold_out) {
    std::vector<std::vector<bool>> parts;
    for (int part = small ? 0 : kParts - 1; part < kParts; ++part) parts.push_back(hold_out(part));
    return prove(rows, model, fitter, how, parts, nullptr, options.most_rows);
  };
  const auto blocks = [&] {
    return split("blocks", [&](int part) { return hold_out_blocks(rows, part, kParts); });
  };
  const auto random = [&] {
    return split("random", [&](int part) { return hold_out_random(rows, part, kParts, options.seed); });
  };
  switch (options.hold_out) {
    case PoseHoldOut::kBlocks:
      return {blocks()};
    case PoseHoldOut::kRandom:
      return {random()};
    case PoseHoldOut::kEachPlace: {
      std::vector<std::vector<bool>> parts(static_cast<std::size_t>(rows.places));
      for (std::size_t part = 0; part < parts.size(); ++part)
        for (const PoseRow& row : rows.rows) parts[part].push_back(row.place == static_cast<int>(part));
      return {prove(rows, model, fitter, "each pose", parts, nullptr, options.most_rows)};
    }
    case PoseHoldOut::kDefault:
      break;
  }
  std::vector<bool> held;
  bool series = false;
  for (const PoseRow& row : rows.rows) {
    held.push_back(row.held_out);
    series = series || rows.frame_held_out[static_cast<std::size_t>(row.frame)];
  }
  if (std::find(held.begin(), held.end(), true) == held.end()) return {blocks(), random()};
  return {prove(rows, model, fitter, series ? "series" : "column", {held}, &main, options.most_rows)};
}

std::vector<PoseFinding> findings(const PoseModel& model, const std::vector<PoseRow>& fitted,
                                  const Fits& fits, const PoseRows& rows) {
  std::vector<PoseTerm> rivals = geometry_terms(model.chain());
  for (const PoseTerm& term : effect_candidates(rows, fitted)) rivals.push_back(term);
  std::vector<std::vector<PoseTerm>> confused;
  const PoseFit& fit = fits.named;
  const std::vector<PoseTermWorth> worth = term_worth(model, fitted, fit, rivals, &confused);
  std::vector<PoseFinding> found;
  Index at = 0;
  for (std::size_t i = 0; i < fit.state.terms.size(); ++i) {
    const PoseTerm& term = fit.state.terms[i];
    PoseFinding finding;
    finding.term = term;
    for (Index k = at; k < at + term.width; ++k) {
      finding.values.push_back(fit.state.values[static_cast<std::size_t>(k)]);
      finding.sd.push_back(std::sqrt(std::max(0.0, fit.covariance(k, k))));
    }
    at += term.width;
    finding.level = level_of(term);
    finding.evidence = worth[i].evidence;
    finding.contribution = worth[i].contribution;
    finding.share = worth[i].share;
    finding.cannot_be_told_from = confused[i];
    if (finding.evidence > 0.0) found.push_back(finding);
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const PoseFinding& a, const PoseFinding& b) { return a.share > b.share; });
  return found;
}

/// Geometry of which the set-ups leave next to nothing.
std::vector<PoseTerm> absorbed(const PoseModel& model, const std::vector<PoseRow>& fitted,
                               const PoseFit& fit) {
  constexpr double kLeft = 1e-5;  // of the column's energy
  PoseElimination poses(model, fitted, fit, fit.sd);
  std::vector<int> numbers;
  for (const PoseTerm& term : geometry_terms(model.chain())) numbers.push_back(poses.add(term));
  const EvidenceProblem problem = poses.problem(numbers);
  std::vector<PoseTerm> gone;
  for (std::size_t i = 0; i < numbers.size(); ++i) {
    const auto k = static_cast<Index>(i);
    if (problem.gram(k, k) <= kLeft * problem.raw_energy[k]) gone.push_back(poses.term(numbers[i]));
  }
  return gone;
}

/// The coarsest step that all readings are multiples of [rad]; 0 where there is none of a hundredth to a
/// thousandth of a degree or more.
double reading_step(const PoseRows& rows) {
  constexpr double kDegree = std::numbers::pi / 180.0;
  for (const double step : {0.1, 0.05, 0.02, 0.01, 0.005, 0.002, 0.001}) {
    bool all = true;
    for (const PoseRow& row : rows.rows)
      for (Index j = 0; all && j < row.q.size(); ++j) {
        const double steps = row.q[j] / (step * kDegree);
        all = std::abs(steps - std::round(steps)) < 1e-4;
      }
    if (all) return step * kDegree;
  }
  return 0.0;
}

/// How far command minus reading looks like a part of the last move.
void compare_command(const PoseRows& rows, PoseDiagnosis& diagnosis) {
  double cm = 0.0, mm = 0.0, cc = 0.0;
  for (const PoseRow& row : rows.rows) {
    cm += row.command.dot(row.move);
    mm += row.move.squaredNorm();
    cc += row.command.squaredNorm();
  }
  if (!(mm > 0.0) || !(cc > 0.0)) return;
  diagnosis.command_on_move = cm / mm;
  diagnosis.command_follows_move = cm * cm > 0.5 * mm * cc;
}

void judge(PoseDiagnosis& diagnosis) {
  double curves = 0.0;
  for (const PoseFinding& finding : diagnosis.left_out) {
    if (!is_curve(finding.term)) continue;
    if (!diagnosis.structured) diagnosis.remainder_structure = finding.term;
    diagnosis.structured = true;
    curves += finding.share;
  }
  const bool above = diagnosis.noise_from_repeats && diagnosis.after > kAboveNoise * diagnosis.noise_floor;
  diagnosis.remainder = diagnosis.structured || above;
  if (diagnosis.left_out.empty())
    diagnosis.verdict = diagnosis.remainder ? PoseVerdict::kUnknownEffect : PoseVerdict::kNothingMissing;
  else if (curves > 0.5)
    diagnosis.verdict = PoseVerdict::kUnknownEffect;
  else
    diagnosis.verdict = diagnosis.remainder ? PoseVerdict::kPartlyExplained : PoseVerdict::kExplained;
}

}  // namespace

PoseDiagnosis diagnose_poses(const PoseRows& given, const Chain& chain, const PoseDiagnosisOptions& options) {
  PoseRows rows = given;
  const PoseModel model(chain, rows.lengths);
  PoseDiagnosis diagnosis;
  diagnosis.one_frame = share_frame(rows, model);
  const bool by_default = options.hold_out == PoseHoldOut::kDefault;
  std::vector<bool> held;
  for (const PoseRow& row : rows.rows) held.push_back(by_default && row.held_out);
  const std::vector<PoseRow> fitted = to_fit(rows, held, options.most_rows);
  const Fitter fitter(rows, model, options);
  const Fits fits = fitter.fit(fitted);
  diagnosis.frames = rows.frames;
  diagnosis.tools = rows.tools;
  diagnosis.not_applied = rows.not_applied;
  diagnosis.lengths = rows.lengths;
  diagnosis.fitted_rows = static_cast<int>(fitted.size());
  diagnosis.before = pose_rms(fits.configured.residual, model.per_row());
  diagnosis.after = pose_rms(fits.all.residual, model.per_row());
  diagnosis.left_out = findings(model, fitted, fits, rows);
  diagnosis.noise_from_repeats = rows.repeat_dof >= 2 * rows.per_row();
  const double crowd = crowding(fitted, fits.all.residual);
  diagnosis.noise_floor = std::sqrt(static_cast<double>(rows.per_row())) *
                          (diagnosis.noise_from_repeats ? fitter.least_sd() : fits.all.sd / crowd);
  diagnosis.state = fits.all.state;
  diagnosis.absorbed = absorbed(model, fitted, fits.configured);
  diagnosis.reading_step = reading_step(rows);
  compare_command(rows, diagnosis);
  diagnosis.held_out = proofs(rows, model, fitter, fits, options);
  judge(diagnosis);
  return diagnosis;
}

}  // namespace ballbar
