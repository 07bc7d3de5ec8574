#include "metrology/signatures.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <iterator>

#include "core/units.hpp"
#include "metrology/arc.hpp"
#include "metrology/signature_columns.hpp"
#include "numerics/harmonics.hpp"
#include "numerics/resolved_fit.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using signature::Samples;
using signature::Term;

constexpr Index kFewestOfSignatures = 60;
constexpr double kStandsOut = 8.0;  // standard deviations of a changeover
const char* const kChangeover = "master_slave_changeover";
const char* const kCentre = "centre_offset";
const char* const kVibration = "vibration";

double range(const VectorXd& values) { return values.maxCoeff() - values.minCoeff(); }

/// max - min about the least-squares centre, to first order: the ball's offset is removed already.
double circular_error_of(const Samples& samples, const VectorXd& deviation) {
  MatrixXd columns(deviation.size(), 3);
  columns << VectorXd::Ones(deviation.size()), samples.cos.matrix(), samples.sin.matrix();
  const VectorXd ones = VectorXd::Ones(deviation.size());
  const ResolvedFit centre = fit_resolved(columns, deviation, ones);
  return range(deviation - columns.rightCols<2>() * centre.coefficients.tail<2>());
}

/// Terms side by side.
struct Model {
  std::vector<Term> terms;
  std::vector<Index> first;  ///< column of each term
  MatrixXd columns;
};

Model model_of(std::vector<Term> terms) {
  Model model;
  Index p = 0;
  for (const Term& term : terms) {
    model.first.push_back(p);
    p += term.columns.cols();
  }
  model.columns.resize(terms.front().columns.rows(), p);
  for (std::size_t k = 0; k < terms.size(); ++k)
    model.columns.middleCols(model.first[k], terms[k].columns.cols()) = terms[k].columns;
  model.terms = std::move(terms);
  return model;
}

VectorXd part_of(const Model& model, const ResolvedFit& fit, std::size_t k) {
  const Term& term = model.terms[k];
  return term.columns * fit.coefficients.segment(model.first[k], term.columns.cols());
}

/// By how much the trace changes with the parameters that were searched for: a column each.
MatrixXd parameter_columns(const Samples& samples, const std::vector<signature::SearchedTerm>& searched,
                           const Model& model, const ResolvedFit& fit) {
  constexpr double kStep = 1e-4;  // of the parameter
  const std::size_t first = model.terms.size() - searched.size();
  MatrixXd columns(model.columns.rows(), static_cast<Index>(searched.size()));
  for (std::size_t k = 0; k < searched.size(); ++k) {
    const double parameter = searched[k].term.parameter;
    const double step = kStep * parameter;
    const MatrixXd change = signature::searched_term(samples, searched[k].kind, parameter + step).columns -
                            signature::searched_term(samples, searched[k].kind, parameter - step).columns;
    columns.col(static_cast<Index>(k)) =
        change * fit.coefficients.segment(model.first[first + k], change.cols()) / (2.0 * step);
  }
  return columns;
}

/// Searched parameters are estimates like the others: their columns join those of the terms for the
/// covariance, wherever they can be told apart from them.
void widen_covariance(const Samples& samples, const std::vector<signature::SearchedTerm>& searched,
                      const Model& model, ResolvedFit& fit) {
  if (searched.empty()) return;
  const MatrixXd more = parameter_columns(samples, searched, model, fit);
  const Index p = model.columns.cols();
  MatrixXd all(model.columns.rows(), p + more.cols());
  all << model.columns, more;
  const ResolvedFit wider = fit_resolved(all, samples.deviation, samples.weight);
  for (Index i = 0; i < p; ++i)
    for (Index j = 0; j < p; ++j)
      if (fit.told_apart(static_cast<int>(i)) && fit.told_apart(static_cast<int>(j)) &&
          wider.told_apart(static_cast<int>(i)) && wider.told_apart(static_cast<int>(j)))
        fit.covariance(i, j) = wider.covariance(i, j);
}

/// The model is of first order: an error of x across the radius leaves x^2 / 2R. What is across is not seen,
/// but is of the size of what is along; its square is taken to spread evenly over the unknowns.
void widen_by_second_order(const Samples& samples, const Model& model, ResolvedFit& fit) {
  const auto p = static_cast<double>(model.columns.cols());
  const auto counted = static_cast<double>((samples.weight.array() > 0.0).count());
  const VectorXd left = samples.weight.cwiseSqrt().cwiseProduct(fit.residual);
  const double variance = fit.inflation * left.squaredNorm() / std::max(1.0, counted - p);
  const Eigen::ArrayXd about_mean = samples.deviation.array() - samples.deviation.mean();
  const double squares = (about_mean.square() / (2.0 * samples.radius)).square().sum();
  if (variance > 0.0) fit.covariance *= 1.0 + squares / (p * variance);
}

constexpr Index kEnough = 3000;         // samples of one direction, for the fit
constexpr Index kEnoughToSearch = 800;  // likewise, for the scans: eight of the fastest wave

/// Whether the steps of the last of these terms stand out of the noise and of what else is there.
bool stands_out(const Samples& samples, const Model& model,
                const std::vector<signature::SearchedTerm>& searched, ResolvedFit fit) {
  widen_covariance(samples, searched, model, fit);
  widen_by_second_order(samples, model, fit);
  for (std::size_t k = 0; k < model.terms.size(); ++k) {
    if (model.terms[k].name != kChangeover) continue;
    const Index column = model.first[k];
    return fit.told_apart(static_cast<int>(column)) &&
           std::abs(fit.coefficients[column]) > kStandsOut * std::sqrt(fit.covariance(column, column));
  }
  return false;
}

/// What was fitted: linear terms, those that were searched for, and a changeover where it stands out of a fit
/// whose search knew of it; a search that does not takes its steps for waves.
struct Fitted {
  std::vector<signature::SearchedTerm> searched;
  Model model;
  ResolvedFit fit;
};

Fitted fitted(const Samples& samples, const Samples& rough, bool changeover) {
  Fitted found;
  std::vector<Term> linear = signature::linear_terms(rough), terms = signature::linear_terms(samples);
  if (changeover) {
    linear.push_back(signature::changeover_term(rough));
    terms.push_back(signature::changeover_term(samples));
  }
  found.searched = signature::search(rough, linear);
  for (const signature::SearchedTerm& each : found.searched)
    terms.push_back(signature::searched_term(samples, each.kind, each.term.parameter));
  found.model = model_of(std::move(terms));
  found.fit = fit_resolved(found.model.columns, samples.deviation, samples.weight);
  if (changeover && !stands_out(samples, found.model, found.searched, found.fit))
    return fitted(samples, rough, false);
  widen_covariance(samples, found.searched, found.model, found.fit);
  widen_by_second_order(samples, found.model, found.fit);
  return found;
}

/// Names of terms whose columns are in a group, by group; groups that share a term are one.
std::vector<std::vector<std::size_t>> term_groups(const Model& model, const ResolvedFit& fit) {
  std::vector<std::vector<std::size_t>> groups;
  for (const std::vector<int>& columns : fit.groups) {
    std::vector<std::size_t> members;
    for (std::size_t k = 0; k < model.terms.size(); ++k) {
      const Index end = model.first[k] + model.terms[k].columns.cols();
      if (std::any_of(columns.begin(), columns.end(), [&](int j) { return j >= model.first[k] && j < end; }))
        members.push_back(k);
    }
    for (auto other = groups.begin(); other != groups.end();) {
      const bool shared = std::any_of(members.begin(), members.end(), [&](std::size_t m) {
        return std::find(other->begin(), other->end(), m) != other->end();
      });
      if (shared) {
        members.insert(members.end(), other->begin(), other->end());
        other = groups.erase(other);
      } else {
        ++other;
      }
    }
    std::sort(members.begin(), members.end());
    members.erase(std::unique(members.begin(), members.end()), members.end());
    groups.push_back(std::move(members));
  }
  return groups;
}

/// Value and standard deviation of a term: its coefficient, or the length of its vector.
void fill_value(const Model& model, const ResolvedFit& fit, std::size_t k, Signature& found) {
  const Index at = model.first[k];
  const Index count = model.terms[k].columns.cols();
  const VectorXd vector = fit.coefficients.segment(at, count);
  const MatrixXd covariance = fit.covariance.block(at, at, count, count);
  if (count == 1) {
    found.value = vector[0];
    found.sd = std::sqrt(covariance(0, 0));
    return;
  }
  const double length = vector.norm();
  const VectorXd along = length > 0.0
                             ? VectorXd(vector / length)
                             : VectorXd::Constant(count, 1.0 / std::sqrt(static_cast<double>(count)));
  found.value = length;
  found.sd = std::sqrt(std::max(0.0, along.dot(covariance * along)));
}

/// rms of the waves that the search found and of what is left, less the sensor's noise. Its standard
/// deviation holds what the noise does to both.
Signature vibration_of(const Samples& samples, const VectorXd& waves, const VectorXd& left) {
  const auto n = static_cast<double>(left.size());
  const double white = samples.noise * samples.noise;
  const double rest = std::max(0.0, left.squaredNorm() / n - white);
  const double power = waves.squaredNorm() / n + rest;
  Signature vibration;
  vibration.name = kVibration;
  vibration.value = std::sqrt(power);
  // The noise's own variance is known from second differences to some 1.6 of white noise's sqrt(2/n).
  const double of_noise = white * std::sqrt(2.0 / n) * std::hypot(1.0, 1.6);
  const double of_rest = rest * std::sqrt(2.0 * autocorrelation_inflation(left) / n);
  const double of_waves = 2.0 * std::sqrt(waves.squaredNorm() / n * white / n);
  const double sd_power = std::hypot(std::hypot(of_noise, of_rest), of_waves);
  vibration.sd = power > sd_power ? sd_power / (2.0 * *vibration.value) : std::sqrt(sd_power);
  vibration.span = std::hypot(waves.squaredNorm() > 0.0 ? range(waves) : 0.0, 2.0 * std::sqrt(2.0 * rest));
  return vibration;
}

void fill_groups(const Model& model, const ResolvedFit& fit, SignatureFit& result,
                 std::vector<bool>& grouped) {
  for (const std::vector<std::size_t>& members : term_groups(model, fit)) {
    SignatureGroup group;
    VectorXd sum = VectorXd::Zero(model.columns.rows());
    for (const std::size_t k : members) {
      grouped[k] = true;
      group.names.push_back(model.terms[k].name);
      if (model.terms[k].name != kCentre) sum += part_of(model, fit, k);
    }
    group.span = range(sum);
    group.share = result.circular_error > 0.0 ? group.span / result.circular_error : 0.0;
    result.not_told_apart.push_back(std::move(group));
  }
}

/// Signatures that were looked for and not found.
void fill_absent(SignatureFit& result) {
  for (const char* name : {"reversal_spike_x", "reversal_spike_y", "cyclic_x", "cyclic_y", kChangeover}) {
    const auto known = [&](const Signature& s) { return s.name == name; };
    const auto in_group = [&](const SignatureGroup& g) {
      return std::find(g.names.begin(), g.names.end(), name) != g.names.end();
    };
    if (std::none_of(result.signatures.begin(), result.signatures.end(), known) &&
        std::none_of(result.not_told_apart.begin(), result.not_told_apart.end(), in_group))
      result.not_defined.push_back({name, "nothing of this shape stands out of the noise"});
  }
}

}  // namespace

std::optional<SignatureFit> fit_signatures(const std::vector<CircleTrace>& traces, double radius,
                                           double frame_angle) {
  const auto samples_with = [&](Index enough) {
    std::vector<CircleTrace> few;
    few.reserve(traces.size());
    for (const CircleTrace& trace : traces) few.push_back(signature::thinned(trace, enough));
    return signature::samples_of(few, radius, frame_angle);
  };
  const Samples samples = samples_with(kEnough);
  if ((samples.weight.array() > 0.0).count() < kFewestOfSignatures) return std::nullopt;
  const Fitted all = fitted(samples, samples_with(kEnoughToSearch), true);
  const Model& model = all.model;
  const ResolvedFit& fit = all.fit;

  SignatureFit result;
  result.frame_angle = frame_angle;
  result.circular_error = circular_error_of(samples, samples.deviation);
  std::vector<bool> grouped(model.terms.size(), false);
  fill_groups(model, fit, result, grouped);
  VectorXd waves = VectorXd::Zero(samples.deviation.size());
  const auto add = [&](Signature found, const VectorXd& part) {
    found.share = result.circular_error > 0.0 ? found.span / result.circular_error : 0.0;
    found.without = circular_error_of(samples, samples.deviation - part);
    result.signatures.push_back(std::move(found));
  };
  for (std::size_t k = 0; k < model.terms.size(); ++k) {
    const Term& term = model.terms[k];
    if (term.name == kCentre || grouped[k]) continue;
    const VectorXd part = part_of(model, fit, k);
    if (term.name == kVibration) {
      waves += part;
      continue;
    }
    Signature found;
    found.name = term.name;
    fill_value(model, fit, k, found);
    found.span = range(part);
    if (term.name.starts_with("reversal_spike")) found.detail = term.parameter;
    if (term.name.starts_with("cyclic")) found.detail = kTurn * radius / term.parameter;
    add(std::move(found), part);
  }
  add(vibration_of(samples, waves, fit.residual), waves);
  const auto n = static_cast<double>(samples.deviation.size());
  result.residual = std::sqrt((waves + fit.residual).squaredNorm() / n);
  if (!(samples.feed > 0.0)) result.not_defined.push_back({"servo_mismatch", "the feed is not known"});
  fill_absent(result);
  std::stable_sort(result.signatures.begin(), result.signatures.end(),
                   [](const Signature& a, const Signature& b) { return a.share > b.share; });
  std::stable_sort(result.not_told_apart.begin(), result.not_told_apart.end(),
                   [](const SignatureGroup& a, const SignatureGroup& b) { return a.share > b.share; });
  return result;
}

const std::vector<std::string>& signature_names() {
  static const std::vector<std::string> names{
      "radius_change",  "scaling_mismatch", "squareness",       "straightness_x", "straightness_y",
      "three_lobe",     "servo_mismatch",   "backlash_x",       "backlash_y",     "lateral_play_x",
      "lateral_play_y", "reversal_spike_x", "reversal_spike_y", "cyclic_x",       "cyclic_y",
      "spiral",         kChangeover,        kVibration};
  return names;
}

SignatureUnit unit_of(const std::string& signature) {
  if (signature == "scaling_mismatch") return {"ppm", 1e6};
  if (signature == "squareness") return {"um/m", 1e6};
  if (signature == "servo_mismatch") return {"ms", 1e3};
  return {"um", 1.0 / kMetresPerUm};
}

std::optional<double> radial_angle(const CircleSpec& spec) {
  constexpr double kLeast = 0.01;
  const CirclePlane plane = plane_of(spec);
  const Eigen::Vector3d radial(plane.centre.x(), plane.centre.y(), 0.0);
  const double along = radial.dot(plane.e1);
  const double across = radial.dot(plane.e2);
  if (!(radial.norm() > kLeast * plane.centre.norm())) return std::nullopt;
  if (!(std::hypot(along, across) > kLeast * radial.norm())) return std::nullopt;
  return std::atan2(across, along);
}

}  // namespace ballbar
