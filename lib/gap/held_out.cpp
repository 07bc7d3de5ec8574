#include "gap/held_out.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

#include "gap/shape_freedom.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr int kStepsToPlace = 6;

/// Clocks are let go last: far from where the ball stands they would take up what it should.
GapFit placed_first(const GapFitter& fitter, const GapFit& start, GapPriors priors) {
  GapPriors held = priors;
  held.shift = held.bar_scale = 0.0;
  return fitter.fit(fitter.fit(start, held, false, kStepsToPlace), priors, false, kStepsToPlace);
}

/// What the set-up leaves open and the shift of the clocks, nothing else.
GapFit with_set_up(const GapFitter& fitter, const GapFit& start) {
  GapPriors priors;
  priors.zero = priors.bar_zero = priors.bar_scale = priors.effect = 0.0;
  return placed_first(fitter, start, priors);
}

/// Takes what formulas leave open, as it was fitted, off the recordings: it is frozen too.
void take_off_shape(const GapFitter& fitter, const GapFit& fit, std::vector<Observation>& held,
                    bool& outside) {
  if (fit.shape.size() == 0) return;
  const Linearised at = fitter.linearise(fit, false);
  for (std::size_t i = 0; i < held.size(); ++i) {
    const Tangent& tangent = at.tangents[i];
    if (fit.curve) {
      Drive drive = tangent.drive();
      const VectorXd driver = driver_of(*fit.curve, tangent, drive);
      const double room = 0.02 * (fit.curve->to - fit.curve->from);
      if (driver.minCoeff() < fit.curve->from - room || driver.maxCoeff() > fit.curve->to + room)
        outside = true;
    }
    held[i].measured -= held[i].transform(shape_columns(tangent, fit)) * fit.shape;
  }
}

/// [m] rms of what the standard deviations of a fit make of a prediction, beside what set-up and clocks take
/// up.
/// @param held  fitter of what is predicted
/// @param at    there, with the effects, curve and shape of `fit`
double uncertainty_of(const GapFitter& held, const GapFit& at, const GapFit& fit) {
  const Linearised here = held.linearise(at, true);
  const Layout fitted(fit.state), placed(at.state);
  Index physics = here.shape.cols();
  for (const NamedEffect& named : fit.named) physics += named.candidate.width();
  if (fit.covariance.rows() != fitted.effects + physics) return 0.0;  // nothing was fitted
  // Of the fit's parameters those that hold elsewhere: zeros, bar, effects, shape.
  std::vector<Index> which = fitted.shared();
  const auto shared = static_cast<Index>(which.size());
  for (Index k = 0; k < physics; ++k) which.push_back(fitted.effects + k);
  const MatrixXd covariance = fit.covariance(which, which);
  MatrixXd columns(held.rows(), shared + physics);
  columns.leftCols(shared) = here.baseline(Eigen::all, placed.shared());
  Index next = shared;
  for (const NamedEffect& named : at.named) {
    columns.middleCols(next, named.candidate.width()) =
        held.columns(here, named.candidate, named.coefficients);
    next += named.candidate.width();
  }
  columns.rightCols(here.shape.cols()) = here.shape;
  const MatrixXd own = here.baseline(Eigen::all, placed.own());
  const VectorXd own_sd = held.baseline_sd(GapPriors{})(placed.own());
  MatrixXd normal = own.transpose() * own;
  normal.diagonal() += own_sd.cwiseAbs2().cwiseInverse();
  columns -= own * normal.llt().solve(own.transpose() * columns);
  const VectorXd variance = (columns * covariance).cwiseProduct(columns).rowwise().sum();
  double energy = 0.0;
  for (std::size_t i = 0; i < held.observations().size(); ++i) {
    const Observation& seen = held.observations()[i];
    energy += variance.segment(here.begin[i], seen.variance.size()).dot(seen.variance) /
              static_cast<double>(seen.places());
  }
  return std::sqrt(energy / static_cast<double>(held.observations().size()));
}

}  // namespace

std::vector<std::string> runs_of(const std::vector<Observation>& observations) {
  std::vector<std::string> runs;
  for (std::size_t i = 0; i < observations.size(); ++i) {
    const Observation& seen = observations[i];
    const bool again = std::any_of(
        observations.begin(), observations.begin() + static_cast<std::ptrdiff_t>(i),
        [&](const Observation& o) {
          return o.instrument.axis != seen.instrument.axis && o.series == seen.series && o.runs == seen.runs;
        });
    if (!again) runs.insert(runs.end(), seen.runs.begin(), seen.runs.end());
  }
  return runs;
}

GapFit as_configured(const GapModel& model, const std::vector<Observation>& observations) {
  const GapFitter fitter(model, observations);
  GapFit fit;
  fit.state = model.start(observations);
  GapPriors priors;
  priors.zero = 0.0;
  return placed_first(fitter, fit, priors);
}

std::vector<FitTrace> traces_of(const std::vector<Observation>& observations, const GapFit& before,
                                const GapFit& after, bool held_out) {
  std::vector<FitTrace> traces;
  Index at = 0;
  for (const Observation& seen : observations) {
    const Index n = seen.measured.size();
    const VectorXd sd = seen.variance.cwiseSqrt();
    const auto predicted = [&](const GapFit& fit) -> VectorXd {
      return seen.transform.inverse(seen.measured - fit.residual.segment(at, n).cwiseProduct(sd));
    };
    FitTrace trace{seen.runs,
                   seen.test,
                   seen.series,
                   seen.direction,
                   held_out,
                   seen.feed,
                   seen.conditions.payload,
                   seen.instrument.kind,
                   seen.instrument.axis,
                   seen.place,
                   seen.transform.inverse(seen.measured),
                   predicted(before),
                   predicted(after)};
    const bool bar = seen.instrument.is_bar();
    Eigen::MatrixXd set_up(seen.places(), bar ? 3 : 2);
    set_up.col(0).setOnes();
    if (bar) {
      set_up.col(1) = seen.place.array().cos();
      set_up.col(2) = seen.place.array().sin();
    } else {
      set_up.col(1) = seen.place;
    }
    const VectorXd off = set_up * set_up.colPivHouseholderQr().solve(trace.after);
    for (VectorXd* each : {&trace.measured, &trace.before, &trace.after}) *each -= off;
    traces.push_back(std::move(trace));
    at += n;
  }
  return traces;
}

FitFigures held_out_figures(const GapModel& model, const std::vector<Observation>& held, const GapFit& fit,
                            bool& outside, std::vector<FitTrace>* traces) {
  FitFigures figures;
  figures.runs = runs_of(held);
  GapFit frozen = fit;
  frozen.state = model.start(held);
  frozen.state.bar_zero = fit.state.bar_zero;
  frozen.state.bar_scale = fit.state.bar_scale;
  GapFit nominal = frozen;
  nominal.named.clear();
  nominal.curve.reset();
  nominal.shape.resize(0);
  const GapFit before = with_set_up(GapFitter(model, held), nominal);
  figures.before = before.rms;
  frozen.state.zero = fit.state.zero;
  std::vector<Observation> left = held;
  double uncertainty = 0.0;
  {
    const GapFitter fitter(model, held);
    const GapFit placed = with_set_up(fitter, frozen);
    GapFit at = placed;
    at.shape = fit.shape;
    uncertainty = uncertainty_of(fitter, at, fit);
    take_off_shape(fitter, at, left, outside);
    frozen.state = placed.state;
  }
  const GapFit after = with_set_up(GapFitter(model, left), frozen);
  figures.after = after.rms;
  if (traces)
    for (FitTrace& trace : traces_of(held, before, after, true)) traces->push_back(std::move(trace));
  double floor = 0.0;
  for (const Observation& seen : held) floor += seen.variance.sum() / static_cast<double>(seen.places());
  figures.floor = std::sqrt(floor / static_cast<double>(held.size()));
  figures.expected = std::hypot(figures.floor, uncertainty);
  return figures;
}

}  // namespace ballbar
