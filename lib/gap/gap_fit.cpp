#include "gap/gap_fit.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <utility>

#include "gap/ball_fit.hpp"
#include "gap/shape_freedom.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// More is no bar: while effects are missing, a fit would take it for one.
constexpr double kLargestBarScale = 0.01;

/// Between which values each parameter before `shape` stays.
struct Bounds {
  VectorXd low, high;
};

Bounds bounds_of(const GapFit& fit, Index parameters) {
  constexpr double kNone = std::numeric_limits<double>::infinity();
  Bounds bounds{VectorXd::Constant(parameters, -kNone), VectorXd::Constant(parameters, kNone)};
  const Layout layout(fit.state);
  bounds.low[layout.bar + 1] = -kLargestBarScale;
  bounds.high[layout.bar + 1] = kLargestBarScale;
  const Index shifts = layout.effects - layout.shift;
  bounds.low.segment(layout.shift, shifts).setConstant(-kLargestTimeShift);
  bounds.high.segment(layout.shift, shifts).setConstant(kLargestTimeShift);
  Index at = layout.effects;
  for (const NamedEffect& named : fit.named) {
    if (named.candidate.positive) bounds.low[at] = 0.0;
    if (named.candidate.width() > 1 && named.candidate.curved) {
      bounds.low[at + 1] = kLeastShape;
      bounds.high[at + 1] = kMostShape;
    }
    at += named.candidate.width();
  }
  return bounds;
}

/// Solves normal * x = right between bounds: what would leave them stays at them, and the others go where
/// they belong with it there.
VectorXd solve_within(const MatrixXd& normal, const VectorXd& right, const VectorXd& low,
                      const VectorXd& high) {
  VectorXd x = VectorXd::Zero(right.size());
  std::vector<Index> free(static_cast<std::size_t>(right.size())), held;
  std::iota(free.begin(), free.end(), Index{0});
  for (;;) {
    const VectorXd rest = right(free) - normal(free, held) * x(held);
    const VectorXd found = MatrixXd(normal(free, free)).llt().solve(rest);
    x(free) = found;
    std::vector<Index> inside;
    for (const Index i : free) {
      if (x[i] >= low[i] && x[i] <= high[i]) {
        inside.push_back(i);
      } else if (std::isfinite(x[i])) {
        x[i] = std::clamp(x[i], low[i], high[i]);
        held.push_back(i);
      }
    }
    if (inside.size() + held.size() < static_cast<std::size_t>(x.size()))
      return VectorXd::Constant(x.size(), NAN);
    if (inside.size() == free.size()) return x;
    free = std::move(inside);
  }
}

/// The same fit with other values of all its parameters.
GapFit with_values(GapFit fit, const VectorXd& values) {
  const Layout layout(fit.state);
  fit.state.zero = values.head(layout.zeros);
  for (std::size_t i = 0; i < fit.state.set_up.size(); ++i)
    fit.state.set_up[i] = values.segment<3>(layout.set_up + 3 * static_cast<Index>(i));
  fit.state.bar_zero = values[layout.bar];
  fit.state.bar_scale = values[layout.bar + 1];
  for (std::size_t i = 0; i < fit.state.shift.size(); ++i)
    fit.state.shift[i] = values[layout.shift + static_cast<Index>(i)];
  Index at = layout.effects;
  for (NamedEffect& named : fit.named) {
    named.coefficients = values.segment(at, named.candidate.width());
    at += named.candidate.width();
  }
  fit.shape = values.tail(values.size() - at);
  return fit;
}

}  // namespace

Layout::Layout(const GapState& state)
    : zeros(state.zero.size()),
      set_up(zeros),
      bar(set_up + 3 * static_cast<Index>(state.set_up.size())),
      shift(bar + 2),
      effects(shift + static_cast<Index>(state.shift.size())) {}

std::vector<Index> Layout::shared() const {
  std::vector<Index> which;
  for (Index i = 0; i < zeros; ++i) which.push_back(i);
  for (Index i = bar; i < shift; ++i) which.push_back(i);
  return which;
}

std::vector<Index> Layout::own() const {
  std::vector<Index> which;
  for (Index i = set_up; i < bar; ++i) which.push_back(i);
  for (Index i = shift; i < effects; ++i) which.push_back(i);
  return which;
}

VectorXd baseline_of(const GapState& state) {
  const Layout layout(state);
  VectorXd all(layout.effects);
  all.head(layout.zeros) = state.zero;
  for (std::size_t i = 0; i < state.set_up.size(); ++i)
    all.segment<3>(layout.set_up + 3 * static_cast<Index>(i)) = state.set_up[i];
  all[layout.bar] = state.bar_zero;
  all[layout.bar + 1] = state.bar_scale;
  for (std::size_t i = 0; i < state.shift.size(); ++i)
    all[layout.shift + static_cast<Index>(i)] = state.shift[i];
  return all;
}

Index GapFitter::rows() const {
  Index rows = 0;
  for (const Observation& seen : observations_) rows += seen.measured.size();
  return rows;
}

VectorXd GapFitter::baseline_sd(const GapPriors& priors) const {
  const Layout layout(model_.start(observations_));
  VectorXd sd(layout.effects);
  sd.head(layout.zeros).setConstant(priors.zero);
  sd.segment(layout.set_up, layout.bar - layout.set_up).setConstant(priors.ball);
  for (const Observation& seen : observations_)
    if (!seen.instrument.is_bar())
      sd.segment<3>(layout.set_up + Index{3} * seen.set_up).setConstant(priors.optics);
  sd[layout.bar] = priors.bar_zero;
  sd[layout.bar + 1] = priors.bar_scale;
  sd.tail(layout.effects - layout.shift).setConstant(priors.shift);
  return sd;
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
  const Layout layout(state);
  const Index joints = layout.zeros;
  all.baseline = MatrixXd::Zero(rows(), layout.effects);
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
    values.col(6 + joints) = by_shift(built, at, state);
    if (all.shape.cols() > 0) values.rightCols(all.shape.cols()) = shape_columns(at, fit);
    const MatrixXd white = whitened(i, values);
    all.residual.segment(row, n) = seen.measured.cwiseQuotient(seen.variance.cwiseSqrt()) - white.col(0);
    all.baseline.block(row, 0, n, joints) = white.middleCols(1, joints);
    all.baseline.block(row, layout.set_up + Index{3} * seen.set_up, n, 3) = white.middleCols(1 + joints, 3);
    all.baseline.block(row, layout.bar, n, 2) = white.middleCols(4 + joints, 2);
    all.baseline.block(row, layout.shift + static_cast<Index>(i), n, 1) = white.col(6 + joints);
    if (all.shape.cols() > 0) all.shape.middleRows(row, n) = white.rightCols(all.shape.cols());
    row += n;
  }
  return all;
}

/// [m/s] of the reading. What follows the motors hangs on their past, not on the clock: a later reading is
/// one of motors that have moved on.
VectorXd GapFitter::by_shift(const AsBuilt& built, const Tangent& at, const GapState& state) {
  constexpr double kStep = 0.2e-3;  // [s]: ripple has turned by a twentieth of a radian
  VectorXd moved = at.joint.cwiseProduct(at.speed).rowwise().sum();
  Drive now = at.drive();
  for (const Effect& effect : built.effects()) {
    if (!effect.kind->deflection || at.at_rest) continue;
    const auto bent = [&](double by) {
      const Motion other{at.motor.time, at.motor.q + by * now.speed()};
      Drive drive(other, *at.loads);
      return effect.kind->deflection(effect, drive);
    };
    moved +=
        (bent(kStep) - bent(-kStep))(at.sample).cwiseProduct(at.joint.col(effect.joint - 1)) / (2.0 * kStep);
  }
  return at.bar ? (1.0 + state.bar_scale) * moved : moved;
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
  constexpr double kLeastShare = 0.01;  // of a step
  constexpr double kMostDamping = 1e10;
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
    Index shape = at.baseline.cols();
    for (const NamedEffect& named : best.named) shape += named.candidate.width();
    const Index total = shape + at.shape.cols();
    MatrixXd columns(rows(), total);
    VectorXd sd(total), value = VectorXd::Zero(total);  // of shape: found anew in each step
    columns.leftCols(at.baseline.cols()) = at.baseline;
    sd.head(at.baseline.cols()) = base_sd;
    value.head(at.baseline.cols()) = baseline_of(best.state);
    Index next = at.baseline.cols();
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
    normal = MatrixXd(normal.selfadjointView<Eigen::Lower>());
    const Bounds bounds = bounds_of(best, total);
    VectorXd low(total), high(total);
    for (Index i = 0; i < total; ++i) {
      low[i] = sd[i] > 0.0 ? (bounds.low[i] - value[i]) / sd[i] : -1.0;
      high[i] = sd[i] > 0.0 ? (bounds.high[i] - value[i]) / sd[i] : 1.0;
    }
    const VectorXd right = columns.transpose() * at.residual - in_sd;
    const MatrixXd covariance = normal.llt().solve(MatrixXd::Identity(total, total));
    if (!covariance.allFinite()) break;
    GapFit trial = best;
    bool helped = false;
    const auto try_step = [&](const VectorXd& change, double share) {
      if (!change.allFinite()) return;
      VectorXd by = sd.cwiseProduct(change);
      by.head(shape) *= share;
      trial = with_values(best, (value + by).cwiseMax(bounds.low).cwiseMin(bounds.high));
      const VectorXd by_shape = at.shape * trial.shape;
      const VectorXd residual = residual_of(trial) - by_shape;
      helped = residual.allFinite() && residual.squaredNorm() + prior_cost(trial) <
                                           (at.residual - by_shape).squaredNorm() + prior_cost(best) + 1e-6;
    };
    const VectorXd change = solve_within(normal, right, low, high);
    for (double share = 1.0; share > kLeastShare && !helped; share /= 2.0) try_step(change, share);
    const bool settled =
        change.cwiseQuotient(covariance.diagonal().cwiseSqrt()).head(shape).cwiseAbs().maxCoeff() < kSettled;
    // A direction that hardly shows at first order, as that of the ball across the circle's plane, makes all
    // shares of a step too long: damped in standard deviations of the prior (Levenberg), it is held first.
    for (double damping = 1.0; damping < kMostDamping && !helped && !settled; damping *= 10.0) {
      MatrixXd damped = normal;
      damped.diagonal().head(shape).array() += damping;
      try_step(solve_within(damped, right, low, high), 1.0);
    }
    if (helped) best = std::move(trial);
    best.covariance = sd.asDiagonal() * covariance * sd.asDiagonal();
    if (settled || !helped) break;
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
