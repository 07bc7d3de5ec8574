#include "gap/input_checks.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <map>
#include <optional>
#include <set>

#include "core/text.hpp"
#include "core/units.hpp"
#include "physics/catalogue.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kMuchBetter = 0.25;   // of the misfit that is left after one change
constexpr double kStructure = 4.0;     // times the noise's energy: below, nothing is wrong
constexpr double kMostOfIt = 0.5;      // of what is left, that another payload must take
constexpr double kSamePayload = 0.05;  // [kg]

std::string listed(const std::set<std::string>& names) {
  std::string text;
  for (const std::string& name : names) text += (text.empty() ? "" : ", ") + name;
  return text;
}

double typical_compliance(int joint) { return joint <= 3 ? 4e-5 : 2e-4; }

/// [m] whitened, of every joint: bending under the load, and what one kilogram more on the flange adds.
struct Bending {
  MatrixXd as_recorded, per_kg;
};

Bending bending_of(const GapFitter& fitter, const Linearised& at) {
  const GapModel& model = fitter.model();
  const int joints = model.joints();
  const EffectKind* kind = find_effect_kind("joint_compliance");
  const Vec3 com = model.spec().payload_com;
  const Body kilogram = model.model().payload(1.0, {com[0], com[1], com[2]}, "tool0");
  Bending all{MatrixXd(fitter.rows(), joints), MatrixXd(fitter.rows(), joints)};
  for (std::size_t i = 0; i < at.tangents.size(); ++i) {
    const Tangent& tangent = at.tangents[i];
    std::vector<Body> heavier = model.bodies(tangent.conditions);
    heavier.push_back(kilogram);
    Loads more(tangent.motor, tangent.chain, std::move(heavier));
    Drive drive = tangent.drive(), loaded(tangent.motor, more);
    MatrixXd values(tangent.time.size(), 2 * joints);
    for (int joint = 1; joint <= joints; ++joint) {
      const Effect effect{.kind = kind, .joint = joint, .values = {typical_compliance(joint)}};
      values.col(joint - 1) = model.push(tangent, drive, effect);
      values.col(joints + joint - 1) = model.push(tangent, loaded, effect) - values.col(joint - 1);
    }
    const MatrixXd white = fitter.whitened(i, values);
    all.as_recorded.middleRows(at.begin[i], white.rows()) = white.leftCols(joints);
    all.per_kg.middleRows(at.begin[i], white.rows()) = white.rightCols(joints);
  }
  return all;
}

/// Columns in standard deviations of their priors, factored: what they leave of any readings.
class Rough {
 public:
  explicit Rough(MatrixXd columns) : columns_(std::move(columns)) {
    MatrixXd normal = MatrixXd::Identity(columns_.cols(), columns_.cols());
    normal.selfadjointView<Eigen::Lower>().rankUpdate(columns_.transpose());
    factor_.compute(normal.selfadjointView<Eigen::Lower>());
  }
  double left(const VectorXd& readings) const {
    const VectorXd part = columns_.transpose() * readings;
    return readings.squaredNorm() - part.dot(factor_.solve(part));
  }

 private:
  MatrixXd columns_;
  Eigen::LLT<MatrixXd> factor_;
};

constexpr double kTypicalSizes = 3.0;  // standard deviation of each prior

/// Zeros, set-up, and each joint's lag and lost motion.
MatrixXd rough_columns(const GapFitter& fitter, const Linearised& at) {
  const int joints = fitter.model().joints();
  const Index base = at.baseline.cols();
  MatrixXd all(fitter.rows(), base + Index{2} * joints);
  all.leftCols(base) = at.baseline * fitter.baseline_sd(GapPriors{}).asDiagonal();
  const EffectKind* lag = find_effect_kind("servo_lag");
  for (int joint = 1; joint <= joints; ++joint) {
    const Effect late{.kind = lag, .joint = joint, .values = {3e-3}};
    all.col(base + joint - 1) = kTypicalSizes * fitter.contribution(at, late);
    const Candidate gap = lost_motion_kinds(joint).front();
    all.col(base + joints + joint - 1) = kTypicalSizes * fitter.contribution(at, gap.with(VectorXd::Ones(1)));
  }
  return all;
}

MatrixXd beside(const MatrixXd& a, const MatrixXd& b) {
  MatrixXd both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

/// All swapped, or one after another for as long as each makes the rest fit better.
std::optional<std::string> swapped(const GapFitter& fitter, const Rough& rough, const Linearised& at) {
  const std::vector<Observation>& seen = fitter.observations();
  const auto rows = static_cast<double>(fitter.rows());
  // A reading at a share x of the way is then one at 1 - x: every odd coefficient has the other sign.
  const auto mirror = [&](VectorXd& all, std::size_t i) {
    // On lines the instrument says itself where it reads: they are not mirrored.
    if (!seen[i].instrument.is_bar()) return;
    for (Index k = 1; k < seen[i].measured.size(); k += 2) all[at.begin[i] + k] *= -1.0;
  };
  VectorXd readings = at.residual, all = at.residual;
  const double before = rough.left(readings);
  std::set<std::size_t> found;
  for (std::size_t i = 0; i < seen.size(); ++i) mirror(all, i);
  double best = rough.left(all);
  if (best < kMuchBetter * before) {
    for (std::size_t i = 0; i < seen.size(); ++i)
      if (seen[i].instrument.is_bar()) found.insert(i);
  } else {
    best = before;
    for (;;) {
      double least = best;
      std::optional<std::size_t> chosen;
      for (std::size_t i = 0; i < seen.size(); ++i) {
        if (found.contains(i)) continue;
        VectorXd one = readings;
        mirror(one, i);
        const double left = rough.left(one);
        if (left >= least) continue;
        least = left;
        chosen = i;
      }
      if (!chosen) break;
      mirror(readings, *chosen);
      found.insert(*chosen);
      best = least;
    }
    if (best > kMuchBetter * before || 2 * found.size() > seen.size()) return std::nullopt;
  }
  std::set<std::string> names;
  for (const std::size_t i : found) names.insert(seen[i].test + (seen[i].direction > 0 ? "+1" : "-1"));
  return "Swapped directions: " + listed(names) +
         " fit as if driven the other way than recorded: " + to_hundredths(std::sqrt(best / rows)) +
         " times the noise is left instead of " + to_hundredths(std::sqrt(before / rows)) +
         ". Look at the direction in the marks, and whether these readings and these joints are of one run. "
         "No "
         "physics was looked for.";
}

/// Of all with one payload, or of one test, a payload with which the whole fits.
std::optional<std::string> other_payload(const GapFitter& fitter, const MatrixXd& rough,
                                         const Bending& bending, const Linearised& at) {
  const std::vector<Observation>& seen = fitter.observations();
  std::map<long, std::vector<std::size_t>> by_payload;
  std::map<std::string, std::vector<std::size_t>> by_test;
  for (std::size_t i = 0; i < seen.size(); ++i) {
    by_payload[std::lround(seen[i].conditions.payload / kSamePayload)].push_back(i);
    by_test[seen[i].test].push_back(i);
  }
  if (by_payload.size() < 2) return std::nullopt;
  std::vector<std::vector<std::size_t>> groups;
  double heaviest = 0.0;
  for (const auto& [payload, group] : by_payload) {
    groups.push_back(group);
    heaviest = std::max(heaviest, seen[group.front()].conditions.payload);
  }
  for (const auto& [test, group] : by_test) groups.push_back(group);
  const auto rows = static_cast<double>(fitter.rows());
  const double before = Rough(beside(rough, kTypicalSizes * bending.as_recorded)).left(at.residual);
  double best = before, fits = 0.0;
  const std::vector<std::size_t>* blamed = nullptr;
  for (const std::vector<std::size_t>& group : groups) {
    const double entered = seen[group.front()].conditions.payload;
    std::vector<double> tried;
    for (const double factor : {0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0})
      tried.push_back(factor * heaviest);
    for (const auto& [known, members] : by_payload) tried.push_back(seen[members.front()].conditions.payload);
    for (const double payload : tried) {
      MatrixXd bent = bending.as_recorded;
      for (const std::size_t i : group)
        bent.middleRows(at.begin[i], seen[i].measured.size()) +=
            (payload - entered) * bending.per_kg.middleRows(at.begin[i], seen[i].measured.size());
      const double left = Rough(beside(rough, kTypicalSizes * bent)).left(at.residual);
      if (left >= best) continue;
      best = left;
      fits = payload;
      blamed = &group;
    }
  }
  if (!blamed || best > kMuchBetter * before) return std::nullopt;
  std::set<std::string> tests;
  for (const std::size_t i : *blamed) tests.insert(seen[i].test);
  return "Doubtful payload: " + listed(tests) + ", recorded with " +
         to_hundredths(seen[blamed->front()].conditions.payload) + " kg, fit as if driven with about " +
         to_hundredths(fits) + " kg: " + to_hundredths(std::sqrt(best / rows)) +
         " times the noise is left instead of " + to_hundredths(std::sqrt(before / rows)) +
         ". Look at payload_kg of marks and configuration. No physics was looked for.";
}

}  // namespace

std::vector<std::string> doubts_of(const GapFitter& fitter) {
  GapFit none;
  none.state = fitter.model().start(fitter.observations());
  const Linearised at = fitter.linearise(none, false);
  const auto rows = static_cast<double>(fitter.rows());
  MatrixXd columns = rough_columns(fitter, at);
  std::optional<Bending> bending;
  if (fitter.model().loads_known()) bending = bending_of(fitter, at);
  const Rough rough(bending ? beside(columns, kTypicalSizes * bending->as_recorded) : columns);
  if (rough.left(at.residual) < kStructure * rows) return {};
  if (const auto found = swapped(fitter, rough, at)) return {*found};
  if (bending)
    if (const auto found = other_payload(fitter, columns, *bending, at)) return {*found};
  return {};
}

}  // namespace ballbar
