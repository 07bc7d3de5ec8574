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
constexpr double kAsWell = 2.0;        // times the misfit (energy) that all smooth physics together leaves
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

/// Columns C in standard deviations of their priors, with the factor L of 1 + C'C.
class Rough {
 public:
  explicit Rough(MatrixXd columns) : columns_(std::move(columns)) {
    MatrixXd normal = MatrixXd::Identity(columns_.cols(), columns_.cols());
    normal.selfadjointView<Eigen::Lower>().rankUpdate(columns_.transpose());
    factor_.compute(normal.selfadjointView<Eigen::Lower>());
  }
  const MatrixXd& columns() const { return columns_; }
  /// L^-1 of what C' makes of readings or of other columns.
  MatrixXd taken(const MatrixXd& of) const { return factor_.matrixL().solve(of); }

 private:
  MatrixXd columns_;
  Eigen::LLT<MatrixXd> factor_;
};

constexpr double kTypicalSizes = 3.0;  // standard deviation of each prior

/// Zeros, set-up, and each joint's lag and lost motion; or with them what is smooth too: eccentricities,
/// lengths, twists and the tool.
MatrixXd rough_columns(const GapFitter& fitter, const Linearised& at, bool smooth) {
  std::vector<MatrixXd> parts{at.baseline * fitter.baseline_sd(GapPriors{}).asDiagonal()};
  Index width = parts.front().cols();
  for (const Candidate& candidate : candidates_for(fitter.model(), fitter.observations())) {
    const std::string_view name = candidate.effect.kind->name;
    const bool is_smooth = name == "link_geometry" || name == "tool_offset" || name == "joint_eccentricity";
    if (name != "servo_lag" && !(smooth && is_smooth)) continue;
    parts.push_back(kTypicalSizes * fitter.columns(at, candidate, VectorXd()));
    width += parts.back().cols();
  }
  for (int joint = 1; joint <= fitter.model().joints(); ++joint) {
    parts.push_back(kTypicalSizes * fitter.columns(at, lost_motion_kinds(joint).front(), VectorXd()));
    ++width;
  }
  MatrixXd all(fitter.rows(), width);
  Index next = 0;
  for (const MatrixXd& part : parts) {
    all.middleCols(next, part.cols()) = part;
    next += part.cols();
  }
  return all;
}

MatrixXd beside(const MatrixXd& a, const MatrixXd& b) {
  MatrixXd both(a.rows(), a.cols() + b.cols());
  both << a, b;
  return both;
}

/// All swapped, or one after another for as long as each makes the rest fit better.
/// @param most  [energy] that may be left
std::optional<std::string> swapped(const GapFitter& fitter, const Rough& rough, const Linearised& at,
                                   double most) {
  const std::vector<Observation>& seen = fitter.observations();
  const auto rows = static_cast<double>(fitter.rows());
  const double energy = at.residual.squaredNorm();
  // A reading at a share x of the way is then one at 1 - x: every odd coefficient has the other sign. Column
  // i: what that changes in L^-1 C'y.
  MatrixXd mirror = MatrixXd::Zero(rough.columns().cols(), static_cast<Index>(seen.size()));
  for (std::size_t i = 0; i < seen.size(); ++i) {
    // On lines the instrument says itself where it reads: they are not mirrored.
    if (!seen[i].instrument.is_bar()) continue;
    for (Index k = 1; k < seen[i].measured.size(); k += 2)
      mirror.col(static_cast<Index>(i)) -=
          2.0 * at.residual[at.begin[i] + k] * rough.columns().row(at.begin[i] + k).transpose();
  }
  mirror = rough.taken(mirror);
  VectorXd taken = rough.taken(rough.columns().transpose() * at.residual);
  const double before = energy - taken.squaredNorm();
  std::set<std::size_t> found;
  double best = energy - (taken + mirror.rowwise().sum()).squaredNorm();
  if (best < kMuchBetter * before) {
    for (std::size_t i = 0; i < seen.size(); ++i)
      if (seen[i].instrument.is_bar()) found.insert(i);
    if (best > most) return std::nullopt;
  } else {
    best = before;
    for (;;) {
      double least = best;
      std::optional<std::size_t> chosen;
      for (std::size_t i = 0; i < seen.size(); ++i) {
        if (found.contains(i)) continue;
        const double left = energy - (taken + mirror.col(static_cast<Index>(i))).squaredNorm();
        if (left >= least) continue;
        least = left;
        chosen = i;
      }
      if (!chosen) break;
      taken += mirror.col(static_cast<Index>(*chosen));
      found.insert(*chosen);
      best = least;
    }
    if (best > std::min(most, kMuchBetter * before) || 2 * found.size() > seen.size()) return std::nullopt;
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

/// What bending by torques of another payload leaves of the readings y, beside rough columns. The bending is
/// B + s P: P is not zero on the rows of one group alone, s is in kilograms.
class OtherPayload {
 public:
  OtherPayload(const Rough& rough, const Bending& bending, const Linearised& at,
               const std::vector<Observation>& seen)
      : rough_(rough),
        bending_(bending),
        at_(at),
        seen_(seen),
        readings_(rough.taken(rough.columns().transpose() * at.residual)),
        bent_(rough.taken(rough.columns().transpose() * bending.as_recorded)),
        gram_(bending.as_recorded.transpose() * bending.as_recorded),
        with_readings_(bending.as_recorded.transpose() * at.residual) {}

  void choose(const std::vector<std::size_t>& group) {
    const Index joints = bending_.per_kg.cols();
    MatrixXd rough_heavier = MatrixXd::Zero(rough_.columns().cols(), joints);
    cross_ = heavier_gram_ = MatrixXd::Zero(joints, joints);
    heavier_with_readings_ = VectorXd::Zero(joints);
    for (const std::size_t i : group) {
      const Index from = at_.begin[i], rows = seen_[i].measured.size();
      const auto heavier = bending_.per_kg.middleRows(from, rows);
      rough_heavier += rough_.columns().middleRows(from, rows).transpose() * heavier;
      cross_ += bending_.as_recorded.middleRows(from, rows).transpose() * heavier;
      heavier_gram_ += heavier.transpose() * heavier;
      heavier_with_readings_ += heavier.transpose() * at_.residual.segment(from, rows);
    }
    heavier_ = rough_.taken(rough_heavier);
  }

  /// @param more  s [kg] for the chosen group
  double left(double more) const {
    const MatrixXd taken = bent_ + more * heavier_;
    const double variance = kTypicalSizes * kTypicalSizes;
    const MatrixXd normal = MatrixXd::Identity(taken.cols(), taken.cols()) +
                            variance * (gram_ + more * (cross_ + cross_.transpose()) +
                                        more * more * heavier_gram_ - taken.transpose() * taken);
    const VectorXd part = with_readings_ + more * heavier_with_readings_ - taken.transpose() * readings_;
    return at_.residual.squaredNorm() - readings_.squaredNorm() -
           variance * part.dot(normal.llt().solve(part));
  }

 private:
  const Rough& rough_;
  const Bending& bending_;
  const Linearised& at_;
  const std::vector<Observation>& seen_;
  VectorXd readings_;  ///< L^-1 C'y
  MatrixXd bent_;      ///< L^-1 C'B
  MatrixXd gram_;      ///< B'B
  VectorXd with_readings_;
  MatrixXd heavier_, cross_, heavier_gram_;  ///< of the chosen group: L^-1 C'P, B'P, P'P
  VectorXd heavier_with_readings_;
};

/// Of all with one payload, or of one test, a payload with which the whole fits.
std::optional<std::string> other_payload(const GapFitter& fitter, const MatrixXd& columns,
                                         const Bending& bending, const Linearised& at, double most) {
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
  const Rough rough(columns);
  OtherPayload other(rough, bending, at, seen);
  other.choose(groups.front());
  const double before = other.left(0.0);
  double best = before, fits = 0.0;
  const std::vector<std::size_t>* blamed = nullptr;
  for (const std::vector<std::size_t>& group : groups) {
    const double entered = seen[group.front()].conditions.payload;
    std::vector<double> tried;
    for (const double factor : {0.0, 0.25, 0.5, 0.75, 1.0, 1.25, 1.5, 2.0, 2.5, 3.0, 4.0})
      tried.push_back(factor * heaviest);
    for (const auto& [known, members] : by_payload) tried.push_back(seen[members.front()].conditions.payload);
    other.choose(group);
    for (const double payload : tried) {
      const double left = other.left(payload - entered);
      if (left >= best) continue;
      best = left;
      fits = payload;
      blamed = &group;
    }
  }
  if (!blamed || best > std::min(most, kMuchBetter * before)) return std::nullopt;
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
  std::optional<Bending> bending;
  if (fitter.model().loads_known()) bending = bending_of(fitter, at);
  const auto with_bending = [&](const MatrixXd& columns) {
    return Rough(bending ? beside(columns, kTypicalSizes * bending->as_recorded) : columns);
  };
  const auto left = [&](const Rough& by) {
    return at.residual.squaredNorm() - by.taken(by.columns().transpose() * at.residual).squaredNorm();
  };
  const MatrixXd columns = rough_columns(fitter, at, false);
  const Rough rough = with_bending(columns);
  if (left(rough) < kStructure * rows) return {};
  const double most = kAsWell * left(with_bending(rough_columns(fitter, at, true)));
  if (const auto found = swapped(fitter, rough, at, most)) return {*found};
  if (bending)
    if (const auto found = other_payload(fitter, columns, *bending, at, most)) return {*found};
  return {};
}

}  // namespace ballbar
