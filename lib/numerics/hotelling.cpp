#include "numerics/hotelling.hpp"

#include <Eigen/LU>
#include <cmath>
#include <stdexcept>

namespace ballbar {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;

/// Sum of (v - m)(v - m)'.
Matrix2d scatter_about(const Vector2d& centre, std::span<const Vector2d> vectors) {
  Matrix2d sum = Matrix2d::Zero();
  for (const Vector2d& v : vectors) sum += (v - centre) * (v - centre).transpose();
  return sum;
}

/// weight d' (scatter / dof)^-1 d
std::optional<T2Test> test_of(const Vector2d& difference, const Matrix2d& scatter, int dof, double weight) {
  constexpr double kFlat = 1e-12;  // smaller over larger spread, squared: rounding
  if (dof < 2) return std::nullopt;
  const double size = scatter.trace();
  if (!(scatter.determinant() > kFlat * size * size)) return std::nullopt;
  T2Test test;
  test.dof = dof;
  test.t2 = weight * dof * difference.dot(scatter.inverse() * difference);
  test.p_value = t2_p_value(test.t2, dof);
  return test;
}

}  // namespace

std::optional<Matrix2d> VectorSample::covariance_of_mean() const {
  if (!covariance) return std::nullopt;
  return Matrix2d(*covariance / static_cast<double>(count));
}

VectorSample sample_of(std::span<const Vector2d> vectors) {
  if (vectors.empty()) throw std::invalid_argument("hotelling: no vectors");
  VectorSample sample;
  sample.count = vectors.size();
  for (const Vector2d& v : vectors) {
    if (!v.allFinite()) throw std::invalid_argument("hotelling: a vector is not finite");
    sample.mean += v;
  }
  const auto n = static_cast<double>(vectors.size());
  sample.mean /= n;
  if (vectors.size() >= 2) sample.covariance = scatter_about(sample.mean, vectors) / (n - 1.0);
  return sample;
}

std::optional<T2Test> hotelling_one_sample(std::span<const Vector2d> vectors, const Vector2d& known) {
  if (vectors.empty()) return std::nullopt;
  const Vector2d centre = sample_of(vectors).mean;
  return test_of(centre - known, scatter_about(centre, vectors), static_cast<int>(vectors.size()) - 1,
                 static_cast<double>(vectors.size()));
}

std::optional<T2Test> hotelling_two_sample(std::span<const Vector2d> series,
                                           std::span<const Vector2d> baseline) {
  if (series.empty() || baseline.empty()) return std::nullopt;
  const Vector2d mean = sample_of(series).mean;
  const Vector2d before = sample_of(baseline).mean;
  const auto n1 = static_cast<double>(series.size());
  const auto n2 = static_cast<double>(baseline.size());
  return test_of(mean - before, scatter_about(mean, series) + scatter_about(before, baseline),
                 static_cast<int>(series.size() + baseline.size()) - 2, n1 * n2 / (n1 + n2));
}

double t2_p_value(double t2, int dof) {
  if (!(t2 >= 0.0) || dof < 2) throw std::invalid_argument("hotelling: t2 < 0 or dof < 2");
  return std::exp(-(dof - 1) / 2.0 * std::log1p(t2 / dof));
}

double t2_limit(double alpha, int dof) {
  if (!(alpha > 0.0 && alpha <= 1.0) || dof < 2)
    throw std::invalid_argument("hotelling: alpha outside (0, 1] or dof < 2");
  return dof * std::expm1(-2.0 / (dof - 1) * std::log(alpha));
}

}  // namespace ballbar
