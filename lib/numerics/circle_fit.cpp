#include "numerics/circle_fit.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <stdexcept>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix2Xd;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kMostSteps = 300;
constexpr double kConverged = 1e-14;  // of a step, where the points have size one: rounding
constexpr double kCostRounding =
    1e-12;  // the cost is flat at its minimum; a step that leaves it alike is welcome
constexpr double kLargestRadius = 1e7;  // where the points have size one: a straight line

using Rows = Eigen::Matrix<double, Eigen::Dynamic, 3>;

/// One row per point: d(distance - radius) / d(centre x, centre y, radius).
Rows jacobian(const Matrix2Xd& points, const Vector3d& circle) {
  Rows rows(points.cols(), 3);
  for (Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector2d arm = points.col(i) - circle.head<2>();
    const double length = arm.norm();
    rows.row(i).head<2>() =
        length > 0.0 ? Eigen::RowVector2d(-arm.transpose() / length) : Eigen::RowVector2d::Zero();
    rows(i, 2) = -1.0;
  }
  return rows;
}

VectorXd residual_of(const Matrix2Xd& points, const Vector3d& circle) {
  return (points.colwise() - circle.head<2>()).colwise().norm().transpose().array() - circle[2];
}

/// Kasa's circle, linear in its unknowns: |p|^2 = 2 c.p + (r^2 - |c|^2). False where the points lie on a
/// line.
bool algebraic_circle(const Matrix2Xd& points, Vector3d& circle) {
  Rows rows(points.cols(), 3);
  rows.leftCols<2>() = 2.0 * points.transpose();
  rows.col(2).setOnes();
  Eigen::ColPivHouseholderQR<Rows> qr(rows);
  qr.setThreshold(1e-12);
  if (qr.rank() < 3) return false;
  const Vector3d solution = qr.solve(points.colwise().squaredNorm().transpose());
  circle << solution.head<2>(), std::sqrt(std::max(0.0, solution[2] + solution.head<2>().squaredNorm()));
  return circle.allFinite() && circle[2] > 0.0;
}

/// Damped Gauss-Newton. True where it came to rest on a circle that the points determine.
bool refine(const Matrix2Xd& points, Vector3d& circle) {
  double damping = 0.0;
  VectorXd residual = residual_of(points, circle);
  for (int step_count = 0; step_count < kMostSteps; ++step_count) {
    const Index added = damping > 0.0 ? 3 : 0;
    Rows system(points.cols() + added, 3);
    system.topRows(points.cols()) = jacobian(points, circle);
    if (added > 0) system.bottomRows<3>() = std::sqrt(damping) * Matrix3d::Identity();
    VectorXd right = VectorXd::Zero(points.cols() + added);
    right.head(points.cols()) = -residual;
    const Vector3d step = system.colPivHouseholderQr().solve(right);
    if (!step.allFinite()) return false;
    const Vector3d next = circle + step;
    const VectorXd next_residual = residual_of(points, next);
    if (next_residual.squaredNorm() <= residual.squaredNorm() * (1.0 + kCostRounding) + 1e-30) {
      circle = next;
      residual = next_residual;
      damping = damping < 1e-9 ? 0.0 : damping / 10.0;
      if (step.norm() <= kConverged * (1.0 + std::abs(circle[2]))) return circle[2] < kLargestRadius;
    } else {
      damping = std::max(10.0 * damping, 1e-6 * static_cast<double>(points.cols()));
      if (step.norm() <= kConverged) return circle[2] < kLargestRadius;
    }
    if (circle[2] > kLargestRadius) return false;
  }
  return false;
}

}  // namespace

CircleFit fit_circle(const Matrix2Xd& points) {
  if (!points.allFinite()) throw std::invalid_argument("circle: a coordinate is not finite");
  CircleFit fit;
  const Index n = points.cols();
  if (n < 3) return fit;
  fit.status = FitStatus::kIllConditioned;
  const Eigen::Vector2d middle = points.rowwise().mean();
  const Matrix2Xd centred = points.colwise() - middle;
  const double scale = std::sqrt(centred.squaredNorm() / static_cast<double>(n));
  if (!(scale > 0.0)) return fit;
  const Matrix2Xd scaled = centred / scale;

  Vector3d circle;
  if (!algebraic_circle(scaled, circle) || !refine(scaled, circle)) return fit;
  Eigen::ColPivHouseholderQR<Rows> qr(jacobian(scaled, circle));
  qr.setThreshold(1e-12);
  if (qr.rank() < 3) return fit;

  fit.status = FitStatus::kOk;
  fit.centre = middle + scale * circle.head<2>();
  fit.radius = scale * circle[2];
  fit.residual = scale * residual_of(scaled, circle);
  if (n == 3) return fit;
  fit.residual_sd = std::sqrt(fit.residual.squaredNorm() / static_cast<double>(n - 3));
  const Matrix3d r = qr.matrixR().topRows<3>().triangularView<Eigen::Upper>();
  const Matrix3d r_inverse = r.inverse();
  const Matrix3d unit =
      qr.colsPermutation() * (r_inverse * r_inverse.transpose()) * qr.colsPermutation().transpose();
  fit.covariance = fit.residual_sd * fit.residual_sd * unit;
  return fit;
}

}  // namespace ballbar
