#include "numerics/line_fit.hpp"

#include <cmath>
#include <stdexcept>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

void check(const VectorXd& x, const VectorXd& y) {
  if (x.size() != y.size()) throw std::invalid_argument("line: x and y differ in number");
  if (!x.allFinite() || !y.allFinite()) throw std::invalid_argument("line: a value is not finite");
}

}  // namespace

LineFit fit_line(const VectorXd& x, const VectorXd& y) {
  check(x, y);
  LineFit fit;
  const Index n = x.size();
  if (n < 2) return fit;
  fit.status = FitStatus::kIllConditioned;
  // About the means: the two unknowns are then independent, and nothing is lost to large coordinates.
  const double x_mean = x.mean();
  const double y_mean = y.mean();
  const VectorXd dx = x.array() - x_mean;
  const double power = dx.squaredNorm();
  const double rounding = 1e-14 * (std::abs(x_mean) + dx.cwiseAbs().maxCoeff());
  if (power <= rounding * rounding * static_cast<double>(n)) return fit;
  fit.status = FitStatus::kOk;
  const VectorXd dy = y.array() - y_mean;
  fit.slope = dx.dot(dy) / power;
  fit.intercept = y_mean - fit.slope * x_mean;
  if (n == 2) return fit;
  fit.residual_sd = std::sqrt((dy - fit.slope * dx).squaredNorm() / static_cast<double>(n - 2));
  const double variance = fit.residual_sd * fit.residual_sd;
  const double of_slope = variance / power;
  fit.covariance << variance / static_cast<double>(n) + x_mean * x_mean * of_slope, -x_mean * of_slope,
      -x_mean * of_slope, of_slope;
  return fit;
}

LineFit end_point_line(const VectorXd& x, const VectorXd& y, double same_x) {
  check(x, y);
  LineFit fit;
  if (x.size() < 2) return fit;
  const double first = x.minCoeff();
  const double last = x.maxCoeff();
  fit.status = FitStatus::kIllConditioned;
  if (!(last - first > same_x)) return fit;
  const auto mean_of = [&](const auto& chosen) -> Eigen::Vector2d {
    const VectorXd weight = chosen.template cast<double>();
    return Eigen::Vector2d(weight.dot(x), weight.dot(y)) / weight.sum();
  };
  const Eigen::Vector2d begin = mean_of(x.array() <= first + same_x);
  const Eigen::Vector2d end = mean_of(x.array() >= last - same_x);
  fit.status = FitStatus::kOk;
  fit.slope = (end.y() - begin.y()) / (end.x() - begin.x());
  fit.intercept = begin.y() - fit.slope * begin.x();
  return fit;
}

double range_about(double slope, const VectorXd& x, const VectorXd& y) {
  check(x, y);
  if (x.size() == 0) return 0.0;
  const VectorXd deviation = y - slope * x;
  return deviation.maxCoeff() - deviation.minCoeff();
}

}  // namespace ballbar
