#include "gap/gap_fit.hpp"

#include <Eigen/Cholesky>
#include <cmath>

#include "gap/ball_fit.hpp"
#include "gap/shape_freedom.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Parameters of a fit as one vector.
struct Layout {
  Index effects, shape;
};

Layout layout_of(const GapFit& fit) {
  Layout at{};
  at.effects = fit.state.zero.size() + 3 * static_cast<Index>(fit.state.set_up.size()) + 2 +
               static_cast<Index>(fit.state.shift.size());
  at.shape = at.effects;
  for (const NamedEffect& named : fit.named) at.shape += named.candidate.width();
  return at;
}

/// More is no bar: while effects are missing, a fit would take it for one.
constexpr double kLargestBarScale = 0.01;

void move_baseline(GapState& state, const VectorXd& by) {
  Index at = 0;
  for (double& zero : state.zero) zero += by[at++];
  for (Eigen::Vector3d& one : state.set_up) {
    one += by.segment<3>(at);
    at += 3;
  }
  state.bar_zero += by[at++];
  state.bar_scale = std::clamp(state.bar_scale + by[at++], -kLargestBarScale, kLargestBarScale);
  for (double& shift : state.shift)
    shift = std::clamp(shift + by[at++], -kLargestTimeShift, kLargestTimeShift);
}

}  // namespace

Index GapFitter::rows() const {
  Index rows = 0;
  for (const Observation& seen : observations_) rows += seen.measured.size();
  return rows;
}

VectorXd GapFitter::baseline_sd(const GapPriors& priors) const {
  const GapState none = model_.start(observations_);
  VectorXd sd(baseline_of(none).size());
  const Index joints = none.zero.size(), set_ups = 3 * static_cast<Index>(none.set_up.size());
  sd.head(joints).setConstant(priors.zero);
  sd.segment(joints, set_ups).setConstant(priors.ball);
  for (const Observation& seen : observations_)
    if (!seen.instrument.is_bar()) sd.segment<3>(joints + Index{3} * seen.set_up).setConstant(priors.optics);
  sd[joints + set_ups] = priors.bar_zero;
  sd[joints + set_ups + 1] = priors.bar_scale;
  sd.tail(static_cast<Index>(none.shift.size())).setConstant(priors.shift);
  return sd;
}

VectorXd GapFitter::baseline_of(const GapState& state) const {
  VectorXd all(state.zero.size() + 3 * static_cast<Index>(state.set_up.size()) + 2 +
               static_cast<Index>(state.shift.size()));
  Index at = 0;
  for (const double zero : state.zero) all[at++] = zero;
  for (const Eigen::Vector3d& one : state.set_up)
    for (const double number : one) all[at++] = number;
  all[at++] = state.bar_zero;
  all[at++] = state.bar_scale;
  for (const double shift : state.shift) all[at++] = shift;
  return all;
}

GapState GapFitter::with_effects(const GapFit& fit) const {
  GapState state = fit.state;
  state.effects.clear();
  for (const NamedEffect& named : fit.named)
    state.effects.push_back(named.candidate.with(named.coefficients));
  return state;
}

MatrixXd GapFitter::whitened(std::size_t index, const MatrixXd& values) const {
  const Observation& seen = observations_[index];
  return seen.variance.cwiseSqrt().cwiseInverse().asDiagonal() * seen.transform(values);
}

VectorXd GapFitter::residual_of(const GapFit& fit) const {
  const GapState state = with_effects(fit);
  const AsBuilt built = model_.built(state);
  VectorXd all(rows());
  Index at = 0;
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    const Observation& seen = observations_[i];
    const VectorXd predicted = model_.predict(built, seen, i, state, loads_of(fit, i));
    all.segment(at, seen.measured.size()) =
        (seen.measured - seen.transform(predicted)).cwiseQuotient(seen.variance.cwiseSqrt());
    at += seen.measured.size();
  }
  return all;
}

Linearised GapFitter::linearise(const GapFit& fit, bool with_shape) const {
  const GapState state = with_effects(fit);
  const AsBuilt built = model_.built(state);
  Linearised all;
  all.residual.resize(rows());
  const Index parameters = baseline_of(state).size();
  const Index joints = state.zero.size();
  const Index set_ups = static_cast<Index>(state.set_up.size());
  all.baseline = MatrixXd::Zero(rows(), parameters);
  all.shape = MatrixXd::Zero(rows(), with_shape ? shape_width(fit) : 0);
  Index row = 0;
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    const Observation& seen = observations_[i];
    const Index n = seen.measured.size(), places = seen.places();
    all.begin.push_back(row);
    all.tangents.push_back(model_.tangent(built, seen, i, state, loads_of(fit, i)));
    const Tangent& at = all.tangents.back();
    MatrixXd values(places, 1 + joints + 3 + 2 + 1 + all.shape.cols());
    const double scale = at.bar ? 1.0 + state.bar_scale : 1.0;
    values.col(0) = at.predicted;
    values.middleCols(1, joints) = scale * at.joint;
    values.middleCols(1 + joints, 3) = scale * at.set_up;
    if (at.bar) {
      values.col(4 + joints).setOnes();
      values.col(5 + joints) = at.predicted.array() - state.bar_zero;
    } else {
      values.middleCols(4 + joints, 2).setZero();
    }
    values.col(6 + joints) = by_shift(built, at, i, state);
    if (all.shape.cols() > 0) values.rightCols(all.shape.cols()) = shape_columns(at, fit);
    const MatrixXd white = whitened(i, values);
    all.residual.segment(row, n) = seen.measured.cwiseQuotient(seen.variance.cwiseSqrt()) - white.col(0);
    all.baseline.block(row, 0, n, joints) = white.middleCols(1, joints);
    all.baseline.block(row, joints + Index{3} * seen.set_up, n, 3) = white.middleCols(1 + joints, 3);
    all.baseline.block(row, joints + 3 * set_ups, n, 2) = white.middleCols(4 + joints, 2);
    all.baseline.block(row, joints + 3 * set_ups + 2 + static_cast<Index>(i), n, 1) = white.col(6 + joints);
    if (all.shape.cols() > 0) all.shape.middleRows(row, n) = white.rightCols(all.shape.cols());
    row += n;
  }
  return all;
}

VectorXd GapFitter::by_shift(const AsBuilt& built, const Tangent& at, std::size_t index,
                             const GapState& state) const {
  constexpr double kStep = 0.2e-3;  // [s]: ripple has turned by a twentieth of a radian
  const bool still = std::all_of(built.effects().begin(), built.effects().end(), [](const Effect& effect) {
    const EffectKind& kind = *effect.kind;
    return !kind.command && !kind.deflection && !kind.growth && !kind.base && !kind.ball && !kind.gauge;
  });
  const double scale = at.bar ? 1.0 + state.bar_scale : 1.0;
  if (still) return scale * at.joint.cwiseProduct(at.speed).rowwise().sum();
  GapState later = state;
  later.shift[index] += kStep;
  return (model_.predict(built, observations_[index], index, later, at.loads) - at.predicted) / kStep;
}

MatrixXd GapFitter::columns(const Linearised& at, const Candidate& candidate, const VectorXd& now) const {
  MatrixXd all(rows(), candidate.width());
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    const Tangent& tangent = at.tangents[i];
    Drive drive = tangent.drive();
    all.middleRows(at.begin[i], observations_[i].measured.size()) =
        whitened(i, columns_of(model_, tangent, drive, candidate, now, Slope::kTangent));
  }
  return all;
}

VectorXd GapFitter::contribution(const Linearised& at, const Effect& effect) const {
  VectorXd all(rows());
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    const Tangent& tangent = at.tangents[i];
    Drive drive = tangent.drive();
    all.segment(at.begin[i], observations_[i].measured.size()) =
        whitened(i, model_.push(tangent, drive, effect));
  }
  return all;
}

GapFit GapFitter::fit(GapFit best, const GapPriors& priors, bool with_shape, int steps) const {
  // Of a standard deviation, every parameter: what the next step would change is a part of that, as this one
  // is of the one before.
  constexpr double kSettled = 0.03;
  constexpr int kHalvings = 6;
  const VectorXd base_sd = baseline_sd(priors);
  const auto prior_cost = [&](const GapFit& fit) {
    double cost = 0.0;
    const VectorXd base = baseline_of(fit.state);
    for (Index i = 0; i < base.size(); ++i)
      if (base_sd[i] > 0.0) cost += std::pow(base[i] / base_sd[i], 2);
    if (priors.effect > 0.0)
      for (const NamedEffect& named : fit.named)
        cost += named.coefficients.squaredNorm() / std::pow(priors.effect, 2);
    return cost;
  };
  for (int step = 0; step < steps; ++step) {
    const Linearised at = linearise(best, with_shape);
    best.loads.clear();
    for (const Tangent& tangent : at.tangents) best.loads.push_back(tangent.loads);
    const Layout layout = layout_of(best);
    const Index total = layout.shape + at.shape.cols();
    MatrixXd columns(rows(), total);
    VectorXd sd(total), value = VectorXd::Zero(total);
    columns.leftCols(layout.effects) = at.baseline;
    sd.head(layout.effects) = base_sd;
    value.head(layout.effects) = baseline_of(best.state);
    Index next = layout.effects;
    for (const NamedEffect& named : best.named) {
      const Index width = named.candidate.width();
      columns.middleCols(next, width) = this->columns(at, named.candidate, named.coefficients);
      sd.segment(next, width).setConstant(priors.effect);
      value.segment(next, width) = named.coefficients;
      next += width;
    }
    columns.rightCols(at.shape.cols()) = at.shape;
    sd.tail(at.shape.cols()).setOnes();
    // In standard deviations of the prior: (C'C + 1) step = C'r - value.
    columns = columns * sd.asDiagonal();
    VectorXd in_sd = VectorXd::Zero(total);
    for (Index i = 0; i < total; ++i)
      if (sd[i] > 0.0) in_sd[i] = value[i] / sd[i];
    MatrixXd normal = MatrixXd::Identity(total, total);
    normal.selfadjointView<Eigen::Lower>().rankUpdate(columns.transpose());
    const Eigen::LLT<MatrixXd> factor(normal.selfadjointView<Eigen::Lower>());
    const VectorXd change = factor.solve(columns.transpose() * at.residual - in_sd);
    if (!change.allFinite()) break;
    const VectorXd shape = change.tail(at.shape.cols());
    const VectorXd move = sd.cwiseProduct(change);
    const double cost_now = (at.residual - at.shape * shape).squaredNorm() + prior_cost(best);
    double share = 1.0;
    GapFit trial = best;
    bool helped = false;
    for (int half = 0; half <= kHalvings; ++half, share /= 2.0) {
      trial = best;
      move_baseline(trial.state, share * move.head(layout.effects));
      Index k = layout.effects;
      for (NamedEffect& named : trial.named) {
        named.coefficients += share * move.segment(k, named.candidate.width());
        if (named.candidate.positive) named.coefficients[0] = std::max(named.coefficients[0], 0.0);
        k += named.candidate.width();
      }
      for (NamedEffect& named : trial.named)
        if (named.coefficients.size() > 1 && named.candidate.curved)
          named.coefficients[1] = std::clamp(named.coefficients[1], kLeastShape, kMostShape);
      const VectorXd residual = residual_of(trial) - at.shape * shape;
      if (residual.allFinite() && residual.squaredNorm() + prior_cost(trial) < cost_now + 1e-6) {
        helped = true;
        break;
      }
    }
    trial.shape = shape;
    const MatrixXd covariance = factor.solve(MatrixXd::Identity(total, total));
    const VectorXd sds = covariance.diagonal().cwiseSqrt();
    const bool settled =
        !helped || (change.cwiseQuotient(sds).head(layout.shape).cwiseAbs().maxCoeff() < kSettled);
    if (helped) best = std::move(trial);
    best.covariance = sd.asDiagonal() * covariance * sd.asDiagonal();
    if (settled) break;
  }
  const Linearised at = linearise(best, with_shape);
  if (best.shape.size() != at.shape.cols()) best.shape = VectorXd::Zero(at.shape.cols());
  finish(at, best);
  return best;
}

void GapFitter::finish(const Linearised& at, GapFit& fit) const {
  fit.residual = at.residual - at.shape * fit.shape;
  fit.chi2 = fit.residual.squaredNorm();
  fit.observation_rms.clear();
  double all = 0.0;
  for (std::size_t i = 0; i < observations_.size(); ++i) {
    const Observation& seen = observations_[i];
    const VectorXd left =
        fit.residual.segment(at.begin[i], seen.measured.size()).cwiseProduct(seen.variance.cwiseSqrt());
    const double energy = left.squaredNorm() / static_cast<double>(seen.places());
    fit.observation_rms.push_back(std::sqrt(energy));
    all += energy;
  }
  fit.rms = observations_.empty() ? 0.0 : std::sqrt(all / static_cast<double>(observations_.size()));
}

}  // namespace ballbar
