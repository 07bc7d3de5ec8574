#include "gap/diagnose.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "gap/direction_classes.hpp"
#include "gap/explain.hpp"
#include "gap/held_out.hpp"
#include "gap/input_checks.hpp"
#include "gap/rate_scan.hpp"
#include "gap/search.hpp"
#include "gap/weigh.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kMaterial = 0.5e-6;  // [m] matters in any noise, where the evidence is for it
constexpr double kSignificant = 6.0;  // z of a band
constexpr double kWorthCurve = 30.0;  // by which a curve must be better [BIC]
constexpr double kWorthShare = 0.5;  // of what the catalogue leaves beyond the noise, which a curve must take
constexpr double kExplained = 1.3;   // times the noise floor that a fit may leave and still be whole
constexpr double kHolds = 2.0;       // times what is expected that an explanation may miss elsewhere
constexpr double kBesideRest = 0.75;     // of what stays unexplained: what is smaller is part of that
constexpr std::size_t kManyEffects = 5;  // that make a set suspect
constexpr std::size_t kMostCurves = 2;
constexpr int kMostScans = 3;  // each proposes one ripple a joint

/// chi2 of the residual in four bands under the noise of the repeats alone.
double worst_band(const GapFitter& fitter, const GapFit& fit) {
  std::array<double, 4> chi2{}, count{};
  Index at = 0;
  for (const Observation& seen : fitter.observations()) {
    for (Index k = 0; k < seen.measured.size(); ++k, ++at) {
      std::size_t band = 0;
      while (band + 1 < kNoiseBandBegin.size() && seen.transform.frequency()[k] >= kNoiseBandBegin[band + 1])
        ++band;
      chi2[band] += fit.residual[at] * fit.residual[at];
      count[band] += 1.0;
    }
  }
  double worst = -1e300;
  for (std::size_t band = 0; band < chi2.size(); ++band)
    if (count[band] > 0.0) worst = std::max(worst, (chi2[band] - count[band]) / std::sqrt(2.0 * count[band]));
  return worst;
}

/// Under the strict noise: the fit of a set that was found.
GapFit refitted(const GapFitter& fitter, const GapFit& fit) { return fitter.fit(fit, GapPriors{}, true, 4); }

/// [m] coefficients of each observation as the fit has them.
std::vector<VectorXd> predicted_by(const GapFitter& fitter, const GapFit& fit) {
  std::vector<VectorXd> all;
  Index at = 0;
  for (const Observation& seen : fitter.observations()) {
    const Index n = seen.measured.size();
    all.push_back(seen.measured - fit.residual.segment(at, n).cwiseProduct(seen.variance.cwiseSqrt()));
    at += n;
  }
  return all;
}

/// Schwarz's criterion, with the effective count of a curve's coefficients.
double information(const GapFitter& fitter, const GapFit& fit) {
  double parameters = 0.0;
  for (const NamedEffect& named : fit.named) parameters += named.candidate.width() + 1.0;
  if (fit.curve) parameters += static_cast<double>(fit.curve->width()) + 1.0;
  return fit.chi2 + parameters * std::log(static_cast<double>(fitter.rows()));
}

/// Drops what is too small to matter, the smallest first, and fits again.
Found material(const GapFitter& fitter, Found found, double least) {
  for (;;) {
    const std::vector<double> size = sizes(fitter, found.fit);
    const auto smallest = std::min_element(size.begin(), size.end());
    if (smallest == size.end() || *smallest >= least) return found;
    found.fit.named.erase(found.fit.named.begin() + (smallest - size.begin()));
    found.fit.shape.resize(0);
    found.fit = fitter.fit(found.fit, GapPriors{}, true, 4);
  }
}

/// What is left beyond the noise [m]; 0 where that is no more than noise makes.
double unexplained(const GapFitter& fitter, const GapFit& strict, double floor) {
  const bool structure = worst_band(fitter, strict) > kSignificant && strict.rms > kExplained * floor;
  return structure ? std::sqrt(strict.rms * strict.rms - floor * floor) : 0.0;
}

/// Drops effects against which the odds are once all sizes are fitted, and those that are smaller than what
/// stays unexplained: a stand-in for that rather than physics of their own.
void keep_convincing(const GapFitter& fitter, Found& found, GapFit& strict, double floor) {
  const double least = kBesideRest * unexplained(fitter, strict, floor);
  for (;;) {
    const Weights weights = weigh(fitter, found.fit, {});
    std::optional<std::size_t> worst;
    for (std::size_t i = 0; i < weights.size.size(); ++i) {
      if (weights.evidence[i] >= 0.0 && weights.size[i] >= least) continue;
      if (!worst || weights.size[i] < weights.size[*worst]) worst = i;
    }
    if (!worst) return;
    found.fit.named.erase(found.fit.named.begin() + static_cast<std::ptrdiff_t>(*worst));
    found.fit.shape.resize(0);
    found.fit = refitted(fitter, found.fit);
    strict = found.fit;
  }
}

/// Lost motion is an error by direction and speed too: what its formula leaves is no other effect.
bool belongs_to_lost_motion(const Curve& curve, const GapFit& fit) {
  if (curve.driver != Driver::kDirection && curve.driver != Driver::kVelocity) return false;
  return std::any_of(fit.named.begin(), fit.named.end(), [&](const NamedEffect& named) {
    return named.candidate.family == "lost motion" && named.candidate.effect.joint == curve.joint;
  });
}

struct Tests {
  std::vector<std::string> names;
  bool repeats = false, both_directions = true;
  bool circles = false, lines = false;
};

Tests tests_of(const std::vector<Observation>& observations) {
  Tests tests;
  std::map<std::string, std::set<int>> directions;
  for (const Observation& seen : observations) {
    directions[seen.test].insert(seen.direction);
    if (seen.laps.cols() > 1) tests.repeats = true;
    (seen.instrument.is_bar() ? tests.circles : tests.lines) = true;
  }
  for (const auto& [name, seen] : directions) {
    tests.names.push_back(name);
    if (seen.size() < 2) tests.both_directions = false;
  }
  return tests;
}

/// Each test left out in turn, the sizes fitted to the others.
FitFigures left_out_in_turn(const GapModel& model, const std::vector<Observation>& observations,
                            const GapFit& fit, const Tests& tests, bool& outside) {
  FitFigures all;
  double before = 0.0, after = 0.0, floor = 0.0, expected = 0.0, count = 0.0;
  for (const std::string& test : tests.names) {
    std::vector<Observation> kept, held;
    for (const Observation& seen : observations) (seen.test == test ? held : kept).push_back(seen);
    if (kept.empty()) continue;
    GapFit start = fit;
    start.state.shift.clear();
    for (std::size_t i = 0; i < observations.size(); ++i)
      if (observations[i].test != test) start.state.shift.push_back(fit.state.shift[i]);
    start.state.set_up.resize(model.start(kept).set_up.size());
    const GapFit without = GapFitter(model, kept).fit(start, GapPriors{}, true, 4);
    const FitFigures one = held_out_figures(model, held, without, outside);
    const auto n = static_cast<double>(held.size());
    all.runs.insert(all.runs.end(), one.runs.begin(), one.runs.end());
    before += n * one.before * one.before;
    after += n * one.after * one.after;
    floor += n * one.floor * one.floor;
    expected += n * one.expected * one.expected;
    count += n;
  }
  if (count > 0.0) {
    all.before = std::sqrt(before / count);
    all.after = std::sqrt(after / count);
    all.floor = std::sqrt(floor / count);
    all.expected = std::sqrt(expected / count);
  }
  return all;
}

void warn(const std::vector<Observation>& fitted, const GapModel& model, const NoiseLevel& noise,
          const Tests& tests, Diagnosis& diagnosis) {
  auto& say = diagnosis.warnings;
  if (!noise.from_repeats)
    say.push_back(
        "No circle was repeated: how large the noise is, is a guess from single laps. Small effects are "
        "not to be trusted. Drive every circle twice, and every line.");
  if (!tests.circles)
    say.push_back(
        "Only lines: what shifts or turns a line as a whole is taken for the alignment of the optics, and of "
        "the rest only what bends it across is seen. Joints that bend it alike are not told apart. Drive "
        "circles of a bar too.");
  else if (tests.names.size() < 2)
    say.push_back(
        "Only one circle: nearly everything looks like a joint's zero offset here. What is named "
        "stands for all that looks alike.");
  if (!tests.both_directions)
    say.push_back(
        "A test was driven one way only: lost motion and lag cannot be told from other shapes. Drive both "
        "directions.");
  if (!model.loads_known())
    say.push_back(
        "The URDF has no link 'tool0': the payload's torques are not known, and compliance is not looked "
        "for.");
  double mass = 0.0;
  for (const Body& body : model.model().bodies()) mass += body.mass;
  if (mass <= 0.0)
    say.push_back(
        "The URDF gives the links no mass: gravity's torques are those of the payload alone. Compliance "
        "found here is not to be trusted.");
  const bool bends = std::any_of(diagnosis.left_out.begin(), diagnosis.left_out.end(),
                                 [](const LeftOut& one) { return one.spec.effect == "joint_compliance"; });
  if (!bends) return;
  const auto [lightest, heaviest] = std::minmax_element(
      fitted.begin(), fitted.end(),
      [](const Observation& a, const Observation& b) { return a.conditions.payload < b.conditions.payload; });
  say.push_back(
      heaviest->conditions.payload - lightest->conditions.payload < 0.1
          ? "Compliance was seen with one payload only, where it is hardly told from zero offsets: "
            "drive a circle with another payload."
          : "A compliance is as right as the payloads that were entered and the URDF's masses: only its "
            "product with them shows.");
}

}  // namespace

const char* to_string(Verdict verdict) {
  switch (verdict) {
    case Verdict::kNothingMissing:
      return "nothing_missing";
    case Verdict::kExplained:
      return "explained";
    case Verdict::kPartlyExplained:
      return "partly_explained";
    case Verdict::kUnknownEffect:
      break;
  }
  return "unknown_effect";
}

Diagnosis diagnose(const GapModel& model, const std::vector<Observation>& fitted,
                   const std::vector<Observation>& held_out, const NoiseLevel& noise) {
  const GapFitter fitter(model, fitted);
  std::vector<Candidate> candidates = candidates_for(model, fitted);
  // Half of one lap's noise by physics-gap.md 5, step 9; over few laps what is slow may be as large.
  const double least = std::min(noise.floor, kMaterial);
  Diagnosis diagnosis;
  diagnosis.noise_floor = noise.floor;
  diagnosis.noise_from_repeats = noise.from_repeats;
  diagnosis.fit.floor = noise.floor;
  diagnosis.fit.runs = runs_of(fitted);
  const GapFit configured = as_configured(model, fitted);
  diagnosis.fit.before = configured.rms;

  const Tests tests = tests_of(fitted);
  diagnosis.circles = tests.circles;
  diagnosis.lines = tests.lines;
  diagnosis.warnings = doubts_of(fitter);
  if (!diagnosis.warnings.empty()) {
    diagnosis.verdict = Verdict::kUnknownEffect;
    diagnosis.fit.after = diagnosis.remainder.rms = diagnosis.fit.before;
    diagnosis.remainder.structure = "other";
    warn(fitted, model, noise, tests, diagnosis);
    return diagnosis;
  }

  Found best = material(fitter, search_effects(fitter, candidates), least);
  for (int scan = 0; scan < kMostScans && add_ripples_of_unknown_rate(fitter, best.fit, candidates); ++scan)
    best = material(fitter, search_effects(fitter, candidates, {}, &best.fit), least);
  GapFit strict = refitted(fitter, best.fit);
  const bool left = unexplained(fitter, strict, noise.floor) > 0.0;
  if (left || best.fit.named.size() >= kManyEffects) {
    for (const Curve& curve : promising_curves(fitter, candidates, kMostCurves)) {
      if (belongs_to_lost_motion(curve, best.fit)) continue;
      const Found with = material(fitter, search_effects(fitter, candidates, curve, &best.fit), least);
      const GapFit with_strict = refitted(fitter, with.fit);
      const double excess = std::max(0.0, strict.chi2 - static_cast<double>(fitter.rows()));
      const double worth = std::max(kWorthCurve, kWorthShare * excess);
      if (!(information(fitter, with_strict) < information(fitter, strict) - worth)) continue;
      best = with;
      strict = with_strict;
    }
  }
  keep_convincing(fitter, best, strict, noise.floor);
  diagnosis.fit.after = strict.rms;
  diagnosis.remainder.rms = strict.rms;
  diagnosis.traces = traces_of(fitted, configured, strict, false);
  diagnosis.remainder.worst_z = worst_band(fitter, strict);
  const bool structure = unexplained(fitter, strict, noise.floor) > 0.0;

  std::optional<Vibration> vibration = find_vibration(fitted, predicted_by(fitter, strict));
  if (vibration && vibration->amplitude.value / std::sqrt(2.0) < least) vibration.reset();
  explain(fitter, best.fit, weigh(fitter, best.fit, candidates), candidates, vibration, least, diagnosis);
  add_direction_classes(fitter, diagnosis);
  const bool physics = std::any_of(diagnosis.left_out.begin(), diagnosis.left_out.end(),
                                   [](const LeftOut& one) { return one.level > 1; });
  if (structure) diagnosis.remainder.structure = "other";

  bool outside = false;
  if (!held_out.empty()) {
    diagnosis.held_out = held_out_figures(model, held_out, best.fit, outside, &diagnosis.traces);
    const double sounds =
        vibration ? vibration->amplitude.value / std::sqrt(2.0) : 0.0;  // phase unknown there
    diagnosis.holds_elsewhere =
        diagnosis.held_out.after <= kHolds * std::hypot(diagnosis.held_out.expected, sounds);
  } else if (tests.names.size() > 1) {
    diagnosis.held_out = left_out_in_turn(model, fitted, best.fit, tests, outside);
    diagnosis.held_out_by_leaving_out = true;
  }
  if (outside)
    diagnosis.warnings.push_back(
        "The held-out tests move a joint beyond the range that its curve was fitted on: there it "
        "says nothing.");
  const bool whole = !structure && diagnosis.holds_elsewhere;
  if (strict.curve)
    diagnosis.verdict = Verdict::kUnknownEffect;
  else if (!physics)
    diagnosis.verdict = whole ? Verdict::kNothingMissing : Verdict::kUnknownEffect;
  else
    diagnosis.verdict = whole ? Verdict::kExplained : Verdict::kPartlyExplained;
  warn(fitted, model, noise, tests, diagnosis);
  return diagnosis;
}

}  // namespace ballbar
