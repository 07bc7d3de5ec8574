#include "metrology/circle.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/units.hpp"
#include "numerics/circle_fit.hpp"
#include "numerics/minimum_zone.hpp"
#include "numerics/noise.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::Matrix2Xd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr int kMostSteps = 60;
constexpr double kConverged = 1e-13;  // of a step of e, in radii: rounding

/// The trace with the ball's position e removed.
struct Motion {
  Vector2d e = Vector2d::Zero();  ///< [m]
  VectorXd radius;                ///< [m] rho of each sample
  VectorXd along;                 ///< [m] rho + e.u, the part of the bar along the commanded direction
  Vector2d first;                 ///< [m] first harmonic of rho: cos, sin
};

/// Nothing where e is so far off that a bar cannot reach its sample.
std::optional<Motion> motion_about(const Vector2d& e, const Matrix2Xd& direction, const VectorXd& length,
                                   const HarmonicBasis& basis) {
  Motion motion;
  motion.e = e;
  const VectorXd across = e.x() * direction.row(1).transpose() - e.y() * direction.row(0).transpose();
  const VectorXd squared = length.cwiseAbs2() - across.cwiseAbs2();
  if (!(squared.minCoeff() > 0.0)) return std::nullopt;
  motion.along = squared.cwiseSqrt();
  motion.radius = motion.along - direction.transpose() * e;
  motion.first = basis.coefficients(motion.radius).segment<2>(1);
  return motion;
}

/// Newton's method on "rho has no first harmonic"; d rho / d e = -(rho u + e) / along. Steps are halved while
/// they lead astray.
std::optional<Motion> remove_eccentricity(const Matrix2Xd& direction, const VectorXd& length, double radius,
                                          const HarmonicBasis& basis) {
  std::optional<Motion> motion = motion_about(Vector2d::Zero(), direction, length, basis);
  for (int count = 0; motion && count < kMostSteps; ++count) {
    Matrix2d slope;
    for (int k = 0; k < 2; ++k) {
      const VectorXd change = motion->radius.array() * direction.row(k).transpose().array() + motion->e[k];
      slope.col(k) = -basis.coefficients(change.cwiseQuotient(motion->along)).segment<2>(1);
    }
    Vector2d step = -slope.inverse() * motion->first;
    if (!step.allFinite()) return std::nullopt;
    const bool last = step.norm() <= kConverged * radius;
    std::optional<Motion> next = motion_about(motion->e + step, direction, length, basis);
    while (!last && (!next || next->first.norm() >= motion->first.norm())) {
      step /= 2.0;
      if (step.norm() <= kConverged * radius) return std::nullopt;
      next = motion_about(motion->e + step, direction, length, basis);
    }
    motion = std::move(next);
    if (last) return motion;
  }
  return std::nullopt;
}

void fill_plotted_shape(const Matrix2Xd& direction, const VectorXd& length, double radius,
                        const CircleFit& circle, CircleResult& result) {
  const Matrix2Xd points = direction * length.asDiagonal();
  const VectorXd distance = (points.colwise() - circle.centre).colwise().norm();
  result.eccentricity_x = circle.centre.x();
  result.eccentricity_y = circle.centre.y();
  result.radial_max = distance.maxCoeff() - radius;
  result.radial_min = distance.minCoeff() - radius;
  result.circular_deviation = result.radial_max - result.radial_min;
  result.circular_deviation_mz = result.circular_deviation;
  // At most as wide, by definition; so rounding shall not make it wider.
  if (const MinimumZoneCircle zone = minimum_zone_circle(points); zone.status == FitStatus::kOk)
    result.circular_deviation_mz = std::min(zone.width, result.circular_deviation);
}

void fill_harmonics(const HarmonicFit& fit, const Vector2d& e, CircleResult& result) {
  result.mean_radius_deviation = {fit.mean(), std::sqrt(fit.covariance(0, 0))};
  result.noise = sample_noise(fit.residual);
  result.residual = fit.residual_sd;
  result.harmonics = harmonics_of(fit);
  Harmonic& first = result.harmonics.front();
  first.cos = e.x();
  first.sin = e.y();
  result.eccentricity_sd = std::sqrt((first.var_cos + first.var_sin) / 2.0);
}

const Harmonic* second_order(const CircleResult& circle) {
  return circle.harmonics.size() >= 2 ? &circle.harmonics[1] : nullptr;
}

/// The standard deviation of a vector's component along the unit vector (c, s).
double sd_along(const Harmonic& h, double c, double s) {
  return std::sqrt(std::max(0.0, c * c * h.var_cos + s * s * h.var_sin + 2.0 * c * s * h.cov_cos_sin));
}

/// An angle folded into [0, period).
double folded(double angle, double period) {
  const double rest = std::fmod(angle, period);
  const double positive = rest < 0.0 ? rest + period : rest;
  return positive < period ? positive : 0.0;  // a tiny negative rest rounds up to the period
}

}  // namespace

std::vector<Harmonic> harmonics_of(const HarmonicFit& fit) {
  std::vector<Harmonic> harmonics;
  for (int k = 1; k <= fit.order; ++k) {
    const Index c = Index{2} * k - 1;
    const Index s = c + 1;
    harmonics.push_back(
        {k, fit.cos(k), fit.sin(k), fit.covariance(c, c), fit.covariance(s, s), fit.covariance(c, s)});
  }
  return harmonics;
}

std::optional<CircleResult> analyse_circle(const VectorXd& angle, const VectorXd& deviation, double radius,
                                           int max_order) {
  if (angle.size() != deviation.size())
    throw std::invalid_argument("circle: angles and deviations differ in number");
  if (!angle.allFinite() || !deviation.allFinite())
    throw std::invalid_argument("circle: a sample is not finite");
  if (!(radius > 0.0)) throw std::invalid_argument("circle: the radius is not positive");

  const HarmonicBasis basis(angle, max_order);
  const VectorXd length = deviation.array() + radius;
  if (basis.order() < 1 || !(length.minCoeff() > 0.0)) return std::nullopt;
  Matrix2Xd direction(2, angle.size());
  direction << angle.array().cos().transpose().matrix(), angle.array().sin().transpose().matrix();

  const CircleFit circle = fit_circle(direction * length.asDiagonal());
  const std::optional<Motion> motion = remove_eccentricity(direction, length, radius, basis);
  if (circle.status != FitStatus::kOk || !motion) return std::nullopt;

  CircleResult result;
  fill_plotted_shape(direction, length, radius, circle, result);
  fill_harmonics(basis.fit(motion->radius.array() - radius), motion->e, result);
  return result;
}

std::optional<Estimate> ovality(const CircleResult& circle) {
  const Harmonic* h = second_order(circle);
  if (!h) return std::nullopt;
  const double amplitude = std::hypot(h->cos, h->sin);
  const double mean_sd = std::sqrt((h->var_cos + h->var_sin) / 2.0);
  return Estimate{amplitude,
                  amplitude > 0.0 ? sd_along(*h, h->cos / amplitude, h->sin / amplitude) : mean_sd};
}

std::optional<Estimate> ovality_axis(const CircleResult& circle) {
  const Harmonic* h = second_order(circle);
  if (!h) return std::nullopt;
  const double nothing_known = kPi / std::sqrt(12.0);
  const double amplitude = std::hypot(h->cos, h->sin);
  if (!(amplitude > 0.0)) return Estimate{0.0, nothing_known};
  const double sd = sd_along(*h, -h->sin / amplitude, h->cos / amplitude) / (2.0 * amplitude);
  return Estimate{folded(std::atan2(h->sin, h->cos) / 2.0, kPi), std::min(sd, nothing_known)};
}

Estimate eccentricity(const CircleResult& circle) {
  return {std::hypot(circle.eccentricity_x, circle.eccentricity_y), circle.eccentricity_sd};
}

Estimate eccentricity_direction(const CircleResult& circle) {
  const double nothing_known = kTurn / std::sqrt(12.0);
  const double amplitude = std::hypot(circle.eccentricity_x, circle.eccentricity_y);
  if (!(amplitude > 0.0)) return {0.0, nothing_known};
  return {folded(std::atan2(circle.eccentricity_y, circle.eccentricity_x), kTurn),
          std::min(circle.eccentricity_sd / amplitude, nothing_known)};
}

}  // namespace ballbar
