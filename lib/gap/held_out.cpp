#include "gap/held_out.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <utility>

#include "gap/shape_freedom.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Ball and shift, nothing else.
GapPriors set_up_only() {
  GapPriors priors;
  priors.zero = priors.bar_zero = priors.bar_scale = priors.effect = 0.0;
  return priors;
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
  return fitter.fit(fit, priors, false, 6);
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
  const GapFit before = GapFitter(model, held).fit(nominal, set_up_only(), false, 6);
  figures.before = before.rms;
  frozen.state.zero = fit.state.zero;
  std::vector<Observation> left = held;
  {
    const GapFitter fitter(model, held);
    const GapFit placed = fitter.fit(frozen, set_up_only(), false, 6);
    GapFit at = placed;
    at.shape = fit.shape;
    take_off_shape(fitter, at, left, outside);
    frozen.state = placed.state;
  }
  const GapFit after = GapFitter(model, left).fit(frozen, set_up_only(), false, 6);
  figures.after = after.rms;
  if (traces)
    for (FitTrace& trace : traces_of(held, before, after, true)) traces->push_back(std::move(trace));
  double floor = 0.0;
  for (const Observation& seen : held) floor += seen.variance.sum() / static_cast<double>(seen.places());
  figures.floor = std::sqrt(floor / static_cast<double>(held.size()));
  return figures;
}

}  // namespace ballbar
