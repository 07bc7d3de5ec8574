#include "numerics/trend.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <cmath>
#include <stdexcept>
#include <vector>

namespace ballbar {
namespace {

double nth(std::vector<double>& values, std::size_t n) {
  std::nth_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(n), values.end());
  return values[n];
}

double median_of(std::vector<double>& values) {
  const std::size_t half = values.size() / 2;
  const double upper = nth(values, half);
  if (values.size() % 2 == 1) return upper;
  return 0.5 *
         (upper + *std::max_element(values.begin(), values.begin() + static_cast<std::ptrdiff_t>(half)));
}

}  // namespace

double median(std::span<const double> values) {
  if (values.empty()) throw std::invalid_argument("median: no values");
  std::vector<double> copy(values.begin(), values.end());
  return median_of(copy);
}

double median_spread(std::span<const double> values) {
  constexpr double kNormal = 1.482602218505602;  // 1 / quantile 3/4 of the normal distribution
  const double centre = median(values);
  std::vector<double> away;
  for (const double v : values) away.push_back(std::abs(v - centre));
  return kNormal * median_of(away);
}

std::optional<RobustSlope> theil_sen(std::span<const double> x, std::span<const double> y, double z) {
  if (x.size() != y.size()) throw std::invalid_argument("theil_sen: sizes differ");
  constexpr std::size_t kLeast = 5;
  const std::size_t n = x.size();
  if (n < kLeast) return std::nullopt;
  std::vector<double> slopes;
  slopes.reserve(n * (n - 1) / 2);
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      if (x[j] != x[i]) slopes.push_back((y[j] - y[i]) / (x[j] - x[i]));
  if (slopes.empty()) return std::nullopt;
  RobustSlope fit;
  fit.slope = median_of(slopes);
  const auto count = static_cast<double>(n);
  const auto pairs = static_cast<double>(slopes.size());
  const double width = z * std::sqrt(count * (count - 1.0) * (2.0 * count + 5.0) / 18.0);
  const auto rank = [&](double at) { return static_cast<std::size_t>(std::clamp(at, 0.0, pairs - 1.0)); };
  fit.low = nth(slopes, rank(std::floor((pairs - width) / 2.0) - 1.0));
  fit.high = nth(slopes, rank(std::ceil((pairs + width) / 2.0)));
  std::vector<double> rest;
  for (std::size_t i = 0; i < n; ++i) rest.push_back(y[i] - fit.slope * x[i]);
  fit.intercept = median_of(rest);
  return fit;
}

std::pair<double, double> ewma(std::span<const double> values, double mean, double sd, double weight) {
  if (!(weight > 0.0 && weight <= 1.0)) throw std::invalid_argument("ewma: weight outside (0, 1]");
  double level = mean;
  for (const double v : values) level = weight * v + (1.0 - weight) * level;
  const double left = std::pow(1.0 - weight, 2.0 * static_cast<double>(values.size()));
  const double own_sd = sd * std::sqrt(weight / (2.0 - weight) * (1.0 - left));
  return {level, own_sd > 0.0 ? (level - mean) / own_sd : 0.0};
}

std::pair<double, double> cusum(std::span<const double> values, double mean, double sd, double allowance) {
  double up = 0.0;
  double down = 0.0;
  for (const double v : values) {
    up = std::max(0.0, up + (v - mean) / sd - allowance);
    down = std::max(0.0, down + (mean - v) / sd - allowance);
  }
  return {up, down};
}

double vector_cusum(std::span<const Eigen::Vector2d> vectors, const Eigen::Vector2d& mean,
                    const Eigen::Matrix2d& covariance, double allowance) {
  const Eigen::Matrix2d inverse = covariance.inverse();
  const auto length = [&](const Eigen::Vector2d& v) { return std::sqrt(v.dot(inverse * v)); };
  Eigen::Vector2d sum = Eigen::Vector2d::Zero();
  for (const Eigen::Vector2d& v : vectors) {
    sum += v - mean;
    const double size = length(sum);
    sum *= size > allowance ? 1.0 - allowance / size : 0.0;
  }
  return length(sum);
}

}  // namespace ballbar
