#include "physics/derivatives.hpp"

#include <Eigen/LU>
#include <algorithm>
#include <array>

namespace ballbar {
namespace {

constexpr Eigen::Index kLeastSamples = 5;

struct Samples {
  Eigen::Index first = 0;
  Eigen::Index count = 0;
};

/// Moves both ends of the window on; times rise, so they only ever move forward.
Samples around(const Eigen::VectorXd& time, Eigen::Index k, double half, Samples former) {
  const Eigen::Index n = time.size();
  Eigen::Index first = former.first;
  Eigen::Index end = std::max(former.first + former.count, k + 1);
  while (first < k && time(k) - time(first) > half) ++first;
  while (end < n && time(end) - time(k) <= half) ++end;
  return {first, end - first};
}

Samples at_least(Samples samples, Eigen::Index k, Eigen::Index n) {
  if (samples.count >= std::min(kLeastSamples, n)) return samples;
  const Eigen::Index count = std::min(kLeastSamples, n);
  return {std::clamp<Eigen::Index>(k - count / 2, 0, n - count), count};
}

/// The normal equations of the parabola about sample k, in units of the window so that they stay near 1.
void fit(const Motion& motion, Eigen::Index k, Samples use, Derivatives& all) {
  const double scale = motion.time(use.first + use.count - 1) - motion.time(use.first);
  std::array<double, 5> sum{};
  for (Eigen::Index i = use.first; i < use.first + use.count; ++i) {
    const double u = (motion.time(i) - motion.time(k)) / scale;
    double power = 1.0;
    for (double& s : sum) {
      s += power;
      power *= u;
    }
  }
  Eigen::Matrix3d moments;
  moments << sum[0], sum[1], sum[2], sum[1], sum[2], sum[3], sum[2], sum[3], sum[4];
  const Eigen::Matrix3d inverse = moments.inverse();
  const Eigen::Vector3d slope = inverse.row(1) / scale;
  const Eigen::Vector3d curvature = 2.0 * inverse.row(2) / (scale * scale);
  // Differences from the sample itself: a joint that stands still has speed 0 to the last bit.
  for (Eigen::Index i = use.first; i < use.first + use.count; ++i) {
    const double u = (motion.time(i) - motion.time(k)) / scale;
    const double to_speed = slope(0) + u * (slope(1) + u * slope(2));
    const double to_acceleration = curvature(0) + u * (curvature(1) + u * curvature(2));
    for (Eigen::Index j = 0; j < motion.q.rows(); ++j) {
      const double difference = motion.q(j, i) - motion.q(j, k);
      all.speed(j, k) += to_speed * difference;
      all.acceleration(j, k) += to_acceleration * difference;
    }
  }
}

}  // namespace

Derivatives derivatives(const Motion& motion, double window) {
  const Eigen::Index n = motion.time.size();
  Derivatives all{Eigen::MatrixXd::Zero(motion.q.rows(), n), Eigen::MatrixXd::Zero(motion.q.rows(), n)};
  if (n < 3) {
    if (n == 2) all.speed.colwise() = (motion.q.col(1) - motion.q.col(0)) / (motion.time[1] - motion.time[0]);
    return all;
  }
  const double half = window / 2.0 * (1.0 + 1e-9);  // so that an even grid gives windows of one size
  Samples within;
  for (Eigen::Index k = 0; k < n; ++k) {
    within = around(motion.time, k, half, within);
    fit(motion, k, at_least(within, k, n), all);
  }
  return all;
}

}  // namespace ballbar
