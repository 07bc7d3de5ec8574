#include "metrology/circle_iso.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <stdexcept>

#include "core/units.hpp"
#include "numerics/circle_fit.hpp"
#include "numerics/gaussian_filter.hpp"
#include "numerics/harmonics.hpp"
#include "numerics/minimum_zone.hpp"
#include "numerics/noise.hpp"
#include "numerics/reference_circles.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix2Xd;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr Index kFewestSamples = 4;
constexpr double kHopeless = 1e4;  // dilution of an arc that says nothing of the ball's offset

const char* const kShortArc = "the arc is too short to carry its centre";
const char* const kNotAround = "the samples do not surround the centre";
const char* const kNoCircle = "the samples determine no circle";
const char* const kNearLine = "the samples lie nearer to a straight line than to any circle";

Matrix2Xd directions_of(const VectorXd& angle) {
  Matrix2Xd direction(2, angle.size());
  direction.row(0) = angle.array().cos();
  direction.row(1) = angle.array().sin();
  return direction;
}

/// Largest standard deviation of mean, cos and sin, each over that of as many samples spread evenly over a
/// turn.
double dilution(const Matrix2Xd& direction) {
  const auto n = static_cast<double>(direction.cols());
  Matrix3d normal = Matrix3d::Zero();
  normal(0, 0) = n;
  normal.block<2, 1>(1, 0) = direction.rowwise().sum();
  normal.block<1, 2>(0, 1) = normal.block<2, 1>(1, 0).transpose();
  normal.block<2, 2>(1, 1) = direction * direction.transpose();
  const Vector3d variance = normal.inverse().diagonal();
  if (!variance.allFinite() || !(variance.minCoeff() > 0.0)) return std::numeric_limits<double>::infinity();
  return std::sqrt(n * std::max(variance[0], variance.tail<2>().maxCoeff() / 2.0));
}

/// The traces of one ball, and where it is.
struct Bars {
  std::vector<Matrix2Xd> direction;  ///< commanded
  std::vector<VectorXd> length;      ///< [m]
  Vector2d offset = Vector2d::Zero();
};

void check(const VectorXd& angle, const VectorXd& deviation, double radius) {
  if (angle.size() != deviation.size())
    throw std::invalid_argument("circle: angles and deviations differ in number");
  if (!angle.allFinite() || !deviation.allFinite())
    throw std::invalid_argument("circle: an angle or a deviation is not finite");
  if (!(radius > 0.0) || (deviation.size() > 0 && !(deviation.minCoeff() > -radius)))
    throw std::invalid_argument("circle: a radius or a length of the bar is not > 0");
}

/// Gauss-Newton of length = |rho u + e| for one rho and e.
Vector2d offset_of(const Bars& bars, double radius) {
  constexpr int kMostRefits = 30;
  Vector3d unknown(radius, 0.0, 0.0);
  for (int count = 0; count < kMostRefits; ++count) {
    Matrix3d normal = Matrix3d::Zero();
    Vector3d right = Vector3d::Zero();
    for (std::size_t k = 0; k < bars.length.size(); ++k) {
      const Matrix2Xd arm = (unknown[0] * bars.direction[k]).colwise() + unknown.tail<2>();
      const VectorXd modelled = arm.colwise().norm();
      if (!(modelled.minCoeff() > 0.0)) return Vector2d::Zero();
      const Matrix2Xd along = arm * modelled.cwiseInverse().asDiagonal();
      Eigen::Matrix3Xd rows(3, arm.cols());
      rows.row(0) = along.cwiseProduct(bars.direction[k]).colwise().sum();
      rows.bottomRows<2>() = along;
      normal += rows * rows.transpose();
      right += rows * (bars.length[k] - modelled);
    }
    const Vector3d step = normal.inverse() * right;
    unknown += step;
    if (!unknown.allFinite() || unknown.tail<2>().norm() > radius / 2.0) return Vector2d::Zero();
    if (step.norm() <= 1e-12 * radius) break;
  }
  return unknown.tail<2>();
}

Bars bars_of(const std::vector<const CircleTrace*>& traces, double radius) {
  Bars bars;
  Index samples = 0;
  for (const CircleTrace* trace : traces) {
    check(trace->angle, trace->deviation, radius);
    bars.direction.push_back(directions_of(trace->angle));
    bars.length.emplace_back(trace->deviation.array() + radius);
    samples += trace->angle.size();
  }
  Matrix2Xd all(2, samples);
  Index filled = 0;
  for (const Matrix2Xd& d : bars.direction) {
    all.middleCols(filled, d.cols()) = d;
    filled += d.cols();
  }
  if (dilution(all) < kHopeless) bars.offset = offset_of(bars, radius);
  return bars;
}

/// rho u + e, |rho u + e| being the length.
Matrix2Xd path_of(const Bars& bars, std::size_t which) {
  const Matrix2Xd& u = bars.direction[which];
  const Vector2d& e = bars.offset;
  const Eigen::ArrayXd across = (e.x() * u.row(1) - e.y() * u.row(0)).transpose().array();
  const Eigen::ArrayXd along = (bars.length[which].array().square() - across.square()).max(0.0).sqrt();
  const VectorXd rho = along - (u.transpose() * e).array();
  return (u * rho.asDiagonal()).colwise() + e;
}

/// A driven path, filtered where asked for, with its least-squares circle.
struct Path {
  Matrix2Xd points;
  VectorXd angle;  ///< commanded, of the points
  CircleFit fitted;
  double noise = 0.0;  ///< [m] from sample to sample, before the filter
  bool centre_carried = false;
};

/// Radii about the ball's offset, filtered over the commanded angle.
bool filter(Path& path, const Vector2d& centre, double cutoff) {
  const Matrix2Xd arm = path.points.colwise() - centre;
  const VectorXd radius = arm.colwise().norm();
  const FilteredProfile profile = gaussian_filter(path.angle, radius, cutoff);
  if (profile.status != FitStatus::kOk) return false;
  const Matrix2Xd moved = (arm * profile.value.cwiseQuotient(radius).asDiagonal()).colwise() + centre;
  std::vector<Index> kept;
  for (Index i = 0; i < radius.size(); ++i)
    if (profile.defined[static_cast<std::size_t>(i)]) kept.push_back(i);
  if (static_cast<Index>(kept.size()) == radius.size()) {
    path.points = moved;
  } else {
    path.points = moved(Eigen::all, kept).eval();
    path.angle = path.angle(kept).eval();
  }
  return path.angle.size() >= kFewestSamples;
}

std::optional<Path> prepare(const CircleTrace& trace, const Bars& bars, std::size_t which,
                            const CircleSettings& settings) {
  if (trace.angle.size() < kFewestSamples) return std::nullopt;
  Path path;
  path.points = path_of(bars, which);
  path.angle = trace.angle;
  path.noise = sample_noise(trace.deviation);
  if (settings.filter_upr && !filter(path, bars.offset, *settings.filter_upr)) return std::nullopt;
  path.fitted = fit_circle(path.points);
  const bool whole = path.angle.size() == trace.angle.size();
  path.centre_carried =
      path.fitted.status == FitStatus::kOk &&
      (whole ? dilution(bars.direction[which]) <= HarmonicBasis::kWorstDilution : carries_centre(path.angle));
  return path;
}

RoundnessAbout roundness(const Matrix2Xd& points, const Vector2d& centre, double radius) {
  const Roundness about = roundness_about(points, centre, radius);
  return {centre.x(), centre.y(), radius, about.total, about.peak, about.valley, about.rms};
}

void fill_record(const CircleTrace& trace, const Path& path, const CircleSpec& spec,
                 const CircleSettings& settings, CircleFigures& figures) {
  figures.direction = trace.direction;
  figures.nominal_radius = spec.radius;
  figures.feed = trace.feed;
  figures.calculated_feed = trace.calculated_feed;
  figures.normal = spec.normal;
  figures.first_axis = spec.first_axis;
  figures.start_angle = path.angle[0];
  figures.end_angle = path.angle[path.angle.size() - 1];
  figures.filter_upr = settings.filter_upr;
  figures.samples = path.angle.size();
  figures.temperature = trace.temperature;
}

/// What hangs on the least-squares centre.
void fill_about_centre(const Path& path, const CircleSettings& settings, CircleFigures& figures) {
  const double nominal = figures.nominal_radius;
  const CircleFit& fitted = path.fitted;
  figures.lsc = roundness(path.points, fitted.centre, fitted.radius);
  figures.radial_max_ls = fitted.radius + figures.lsc->peak - nominal;
  figures.radial_min_ls = fitted.radius - figures.lsc->valley - nominal;
  // Of the noise alone: shape and slow changes are in the radius itself, not in its uncertainty.
  const double share = fitted.residual_sd > 0.0 ? path.noise / fitted.residual_sd : 0.0;
  figures.radius_deviation = {fitted.radius - nominal, share * std::sqrt(fitted.covariance(2, 2))};
  if (!settings.expansion || !figures.temperature) return;
  const Estimate measured{fitted.radius, figures.radius_deviation->sd};
  const Estimate normalised = radius_at_20(measured, *figures.temperature, *settings.expansion);
  figures.radius_20_deviation = {normalised.value - nominal, normalised.sd};
  figures.expansion = settings.expansion;
}

CircleFigures figures_of(const CircleTrace& trace, const Path& path, const CircleSpec& spec,
                         const CircleSettings& settings) {
  CircleFigures figures;
  fill_record(trace, path, spec, settings, figures);
  const VectorXd length = path.points.colwise().norm();
  figures.radial_max_setup = length.maxCoeff() - spec.radius;
  figures.radial_min_setup = length.minCoeff() - spec.radius;
  const auto refuse = [&](const char* reason, std::initializer_list<const char*> names) {
    for (const char* name : names) figures.not_defined.push_back({name, reason});
  };

  const CircleFit& fitted = path.fitted;
  const bool round = fitted.status == FitStatus::kOk;
  const bool around = [&] {
    if (!path.centre_carried) return false;
    const ReferenceCircle inner = maximum_inscribed_circle(path.points, fitted);
    if (inner.status != FitStatus::kOk) return false;
    figures.mic = roundness(path.points, inner.centre, inner.radius);
    const ReferenceCircle outer = minimum_circumscribed_circle(path.points);
    figures.mcc = roundness(path.points, outer.centre, outer.radius);
    return true;
  }();
  if (!around) refuse(kNotAround, {"mic", "mcc"});
  if (path.centre_carried)
    fill_about_centre(path, settings, figures);
  else
    refuse(kShortArc, {"radial_max_ls", "radial_min_ls", "radius_deviation", "lsc"});
  if (!round) {
    refuse(kNoCircle, {"circular_error_mz", "circular_error_ls", "mzc"});
    return figures;
  }
  const Roundness about_ls = roundness_about(path.points, fitted.centre, fitted.radius);
  figures.circular_error_ls = about_ls.total;
  const MinimumZoneCircle zone = minimum_zone_circle(path.points, fitted);
  if (zone.status != FitStatus::kOk) {
    refuse(kNearLine, {"circular_error_mz", "mzc"});
    return figures;
  }
  figures.circular_error_mz = std::min(zone.width, about_ls.total);
  if (path.centre_carried)
    figures.mzc = roundness(path.points, zone.centre, (zone.outer_radius + zone.inner_radius) / 2.0);
  else
    refuse(kShortArc, {"mzc"});
  return figures;
}

/// Radii by rising angle.
struct Profile {
  std::vector<double> angle, radius;
};

Profile profile_about(const Path& path, const Vector2d& centre, double shift) {
  std::vector<Index> sequence(static_cast<std::size_t>(path.angle.size()));
  std::iota(sequence.begin(), sequence.end(), Index{0});
  std::stable_sort(sequence.begin(), sequence.end(),
                   [&](Index a, Index b) { return path.angle[a] < path.angle[b]; });
  Profile profile;
  for (const Index i : sequence) {
    profile.angle.push_back(path.angle[i] + shift);
    profile.radius.push_back((path.points.col(i) - centre).norm());
  }
  return profile;
}

/// The largest difference at the samples of `one`, each against the line between its neighbours in `other`.
void largest_difference(const Profile& one, const Profile& other, CirclePair& pair) {
  std::size_t next = 0;
  for (std::size_t i = 0; i < one.angle.size(); ++i) {
    const double at = one.angle[i];
    while (next < other.angle.size() && other.angle[next] < at) ++next;
    if (next == other.angle.size()) break;
    const bool exact = other.angle[next] == at;
    if (!exact && next == 0) continue;
    const std::size_t before = exact ? next : next - 1;
    const double step = other.angle[next] - other.angle[before];
    const double share = exact ? 0.0 : (at - other.angle[before]) / step;
    const double there = other.radius[before] + share * (other.radius[next] - other.radius[before]);
    const double difference = std::abs(one.radius[i] - there);
    if (pair.hysteresis && difference <= *pair.hysteresis) continue;
    pair.hysteresis = difference;
    pair.hysteresis_angle = at;
  }
}

void fill_pair(const Path& ccw, const Path& cw, CirclePair& pair) {
  Path both;
  both.points.resize(2, ccw.points.cols() + cw.points.cols());
  both.points << ccw.points, cw.points;
  both.fitted = fit_circle(both.points);
  const bool carried = ccw.centre_carried && cw.centre_carried && both.fitted.status == FitStatus::kOk;
  if (both.fitted.status == FitStatus::kOk) {
    const MinimumZoneCircle zone = minimum_zone_circle(both.points, both.fitted);
    const double about_ls = roundness_about(both.points, both.fitted.centre, both.fitted.radius).total;
    pair.circular_error_b_ls = about_ls;
    if (zone.status == FitStatus::kOk)
      pair.circular_error_b = std::min(zone.width, about_ls);
    else
      pair.not_defined.push_back({"circular_error_b", kNearLine});
  } else {
    pair.not_defined.push_back({"circular_error_b", kNoCircle});
    pair.not_defined.push_back({"circular_error_b_ls", kNoCircle});
  }
  if (pair.ccw.radius_deviation && pair.cw.radius_deviation) {
    const Estimate& one = *pair.ccw.radius_deviation;
    const Estimate& other = *pair.cw.radius_deviation;
    pair.radial_error_d = {(one.value + other.value) / 2.0, std::hypot(*one.sd, *other.sd) / 2.0};
  } else {
    pair.not_defined.push_back({"radial_error_d", kShortArc});
  }
  const Vector2d centre = carried ? both.fitted.centre : Vector2d::Zero();
  const double shift = kTurn * std::round((ccw.angle.mean() - cw.angle.mean()) / kTurn);
  const Profile one = profile_about(ccw, centre, 0.0);
  const Profile other = profile_about(cw, centre, shift);
  largest_difference(one, other, pair);
  largest_difference(other, one, pair);
  if (!pair.hysteresis) pair.not_defined.push_back({"hysteresis", "the two arcs have no part in common"});
  for (const Profile& profile : {one, other})
    for (const double radius : profile.radius)
      pair.positional_tolerance =
          std::max(pair.positional_tolerance, 2.0 * std::abs(radius - pair.ccw.nominal_radius));
  pair.radial_max_setup = std::max(pair.ccw.radial_max_setup, pair.cw.radial_max_setup);
  pair.radial_min_setup = std::min(pair.ccw.radial_min_setup, pair.cw.radial_min_setup);
}

}  // namespace

Matrix2Xd driven_path(const VectorXd& angle, const VectorXd& deviation, double radius) {
  CircleTrace trace;
  trace.angle = angle;
  trace.deviation = deviation;
  return path_of(bars_of({&trace}, radius), 0);
}

std::vector<VectorXd> motion_deviations(const std::vector<CircleTrace>& traces, double radius) {
  std::vector<const CircleTrace*> all;
  all.reserve(traces.size());
  for (const CircleTrace& trace : traces) all.push_back(&trace);
  const Bars bars = bars_of(all, radius);
  std::vector<VectorXd> deviations;
  for (std::size_t k = 0; k < traces.size(); ++k) {
    const Matrix2Xd about = path_of(bars, k).colwise() - bars.offset;
    deviations.emplace_back(about.cwiseProduct(bars.direction[k]).colwise().sum().transpose().array() -
                            radius);
  }
  return deviations;
}

Estimate radius_at_20(const Estimate& radius, double temperature, double expansion) {
  constexpr double kReference = 20.0;  // degC, ISO 1
  const double grown = 1.0 + expansion * (temperature - kReference);
  Estimate at_20{radius.value / grown, radius.sd};
  if (at_20.sd) *at_20.sd /= grown;
  return at_20;
}

bool carries_centre(const VectorXd& angle) {
  return angle.size() >= kFewestSamples && dilution(directions_of(angle)) <= HarmonicBasis::kWorstDilution;
}

std::optional<CircleFigures> circle_figures(const CircleTrace& trace, const CircleSpec& spec,
                                            const CircleSettings& settings) {
  const Bars bars = bars_of({&trace}, spec.radius);
  const std::optional<Path> path = prepare(trace, bars, 0, settings);
  if (!path) return std::nullopt;
  return figures_of(trace, *path, spec, settings);
}

std::optional<CirclePair> join(const CircleTrace& ccw, const CircleTrace& cw, const CircleSpec& spec,
                               const CircleSettings& settings) {
  if (ccw.direction != 1 || cw.direction != -1)
    throw std::invalid_argument("circle: a pair is one counter-clockwise and one clockwise trace");
  const Bars bars = bars_of({&ccw, &cw}, spec.radius);
  const std::optional<Path> one = prepare(ccw, bars, 0, settings);
  const std::optional<Path> other = prepare(cw, bars, 1, settings);
  if (!one || !other) return std::nullopt;
  CirclePair pair;
  pair.ccw = figures_of(ccw, *one, spec, settings);
  pair.cw = figures_of(cw, *other, spec, settings);
  fill_pair(*one, *other, pair);
  return pair;
}

}  // namespace ballbar
