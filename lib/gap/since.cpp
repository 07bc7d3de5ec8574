#include "gap/since.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <map>
#include <stdexcept>

#include "numerics/harmonics.hpp"
#include "physics/catalogue.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kRows = Index{2} * (kLastChangedOrder - kFirstChangedOrder + 1);
constexpr double kLeastExplained = 0.05;
constexpr double kRelative = 0.03;  // of a change: columns are linear, motions not the same to the last

/// Harmonics of columns over an arc; as those of a run they are fitted with all lower orders.
MatrixXd harmonics_of(const VectorXd& angle, const MatrixXd& columns) {
  const HarmonicBasis basis(angle, kLastChangedOrder);
  MatrixXd rows = MatrixXd::Zero(kRows, columns.cols());
  const Index first = 2 * kFirstChangedOrder - 1;  // of mean, cos 1, sin 1, cos 2, ...
  for (Index k = 0; k < columns.cols(); ++k) {
    const VectorXd all = basis.coefficients(columns.col(k));
    const Index there = std::min(kRows, all.size() - first);
    if (there > 0) rows.col(k).head(there) = all.segment(first, there);
  }
  return rows;
}

/// A zero offset is not in candidates_for(): the diagnosis eliminates it.
Candidate zero_offset(int joint) {
  Candidate one;
  one.effect.kind = find_effect_kind("joint_zero_offset");
  one.effect.joint = joint;
  one.effect.values = {0.0};
  one.slots = {0};
  const ParameterKind& offset = one.effect.kind->parameters[0];
  one.typical = {offset.typical * offset.si};
  return one;
}

Likeness named(const Candidate& candidate, const VectorXd& sizes) {
  Likeness like;
  const Effect& effect = candidate.effect;
  like.effect = effect.kind->name;
  like.joint = effect.joint;
  if (effect.word >= 0) like.kind = effect.kind->word.allowed[static_cast<std::size_t>(effect.word)];
  if (candidate.form == Candidate::Form::kSizes)
    for (std::size_t i = 0; i < candidate.slots.size(); ++i) {
      const ParameterKind& parameter = effect.kind->parameters[candidate.slots[i]];
      like.parameters.emplace_back(parameter.name,
                                   candidate.typical[i] * sizes[static_cast<Index>(i)] / parameter.si);
    }
  return like;
}

}  // namespace

std::vector<Likeness> looks_like(const GapModel& model, const std::vector<Observation>& observations,
                                 const std::vector<HarmonicChange>& changes) {
  const GapState state = model.start(observations);
  const AsBuilt built = model.built(state);
  std::vector<Tangent> tangents;
  VectorXd measured(kRows * static_cast<Index>(changes.size())), sd(measured.size());
  for (std::size_t i = 0; i < changes.size(); ++i) {
    const HarmonicChange& change = changes[i];
    if (change.step.size() != kRows || change.sd.size() != kRows)
      throw std::invalid_argument("change: cos and sin of the orders 2 to 10");
    const auto at = static_cast<Index>(i) * kRows;
    measured.segment(at, kRows) = change.step;
    const double form = kRelative * change.step.norm() / std::sqrt(static_cast<double>(kRows));
    sd.segment(at, kRows) = (change.sd.array().square() + form * form).sqrt();
    tangents.push_back(model.tangent(built, observations.at(change.observation), change.observation, state));
  }
  if (changes.empty() || !(sd.minCoeff() > 0.0)) return {};
  std::vector<Candidate> candidates = candidates_for(model, observations);
  for (int joint = 1; joint <= model.joints(); ++joint) candidates.push_back(zero_offset(joint));

  const VectorXd weighed = measured.cwiseQuotient(sd);
  const double all = weighed.squaredNorm(), places = static_cast<double>(weighed.size());
  if (!(all > 0.0)) return {};
  std::map<std::pair<std::string_view, int>, double>
      forms;  // of one effect and joint, e.g. kinds of lost motion
  for (const Candidate& candidate : candidates)
    forms[{candidate.effect.kind->name, candidate.effect.joint}] += 1.0;
  std::vector<Likeness> found;
  for (const Candidate& candidate : candidates) {
    // A jump within one run, of ball or gauge, is no change from run to run.
    if (candidate.effect.kind->ball || candidate.effect.kind->gauge) continue;
    MatrixXd columns(measured.size(), candidate.width());
    for (std::size_t i = 0; i < changes.size(); ++i) {
      Drive drive = tangents[i].drive();
      const MatrixXd pushed = columns_of(model, tangents[i], drive, candidate, {}, Slope::kChord);
      columns.middleRows(static_cast<Index>(i) * kRows, kRows) =
          harmonics_of(observations[changes[i].observation].place, pushed);
    }
    const MatrixXd whitened = sd.cwiseInverse().asDiagonal() * columns;
    if (!whitened.allFinite() || !(whitened.norm() > 0.0)) continue;
    const VectorXd sizes = whitened.completeOrthogonalDecomposition().solve(weighed);
    const double left = (weighed - whitened * sizes).squaredNorm();
    Likeness like = named(candidate, sizes);
    like.explains = 1.0 - left / all;
    if (like.explains < kLeastExplained) continue;
    like.size = (columns * sizes).norm() / std::sqrt(2.0 * static_cast<double>(changes.size()));
    like.worse = 0.5 * left + 0.5 * static_cast<double>(candidate.width()) * std::log(places);
    // What has many forms to choose from fits by chance more easily; under load a backlash is a zero offset.
    like.worse += std::log(forms.at({candidate.effect.kind->name, candidate.effect.joint}));
    found.push_back(std::move(like));
  }
  std::stable_sort(found.begin(), found.end(),
                   [](const Likeness& a, const Likeness& b) { return a.worse < b.worse; });
  // Of one effect and joint in several kinds only the best stands for all.
  std::vector<Likeness> best;
  for (Likeness& one : found) {
    const bool known = std::any_of(best.begin(), best.end(), [&](const Likeness& other) {
      return other.effect == one.effect && other.joint == one.joint;
    });
    if (!known) best.push_back(std::move(one));
  }
  for (std::size_t i = best.size(); i-- > 0;) best[i].worse -= best.front().worse;
  return best;
}

}  // namespace ballbar
