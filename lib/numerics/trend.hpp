#pragma once
/// Where a figure is going: robust level, scatter and slope, and control charts against a baseline.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <utility>

namespace ballbar {

/// The middle value; the mean of the two in the middle of an even number.
/// @throws std::invalid_argument for no values
double median(std::span<const double> values);

/// 1.4826 median |x - median|: the standard deviation of normal values, whatever a few outliers do.
/// @throws std::invalid_argument for no values
double median_spread(std::span<const double> values);

struct RobustSlope {
  double slope = 0.0;  ///< [unit of y per unit of x]
  double low = 0.0;    ///< confidence interval of the slope
  double high = 0.0;
  double intercept = 0.0;  ///< median of y - slope x
};

/// Theil-Sen: the median of the slopes of all pairs, with the distribution-free confidence interval of Sen
/// (1968): the slopes of rank (N -+ z sqrt(n (n - 1) (2 n + 5) / 18)) / 2 among N. Pairs of one x are left
/// out.
/// @param z  quantile of the normal distribution: 1.96 for 95 %
/// @return nothing for fewer than five points or where all x are alike
/// @throws std::invalid_argument where the sizes differ
std::optional<RobustSlope> theil_sen(std::span<const double> x, std::span<const double> y, double z = 1.96);

/// Exponentially weighted mean, z_i = w x_i + (1 - w) z_(i-1) from z_0 = mean, and how far it is from the
/// mean in its own standard deviations, sd sqrt(w / (2 - w) (1 - (1 - w)^(2 n))) (Roberts 1959).
/// @param weight  w in (0, 1]
/// @return (value, distance)
std::pair<double, double> ewma(std::span<const double> values, double mean, double sd, double weight);

/// Cumulative sums of Page (1954) in standard deviations: up = max(0, up + (x - mean) / sd - allowance), down
/// likewise.
/// @return (up, down), both >= 0
std::pair<double, double> cusum(std::span<const double> values, double mean, double sd, double allowance);

/// The same of vectors (Crosier 1988): the sum is shortened by `allowance` at each step, lengths being
/// sqrt(v' covariance^-1 v).
/// @return the length of the sum
double vector_cusum(std::span<const Eigen::Vector2d> vectors, const Eigen::Vector2d& mean,
                    const Eigen::Matrix2d& covariance, double allowance);

}  // namespace ballbar
