#include "physics/derivatives.hpp"

#include <Eigen/LU>
#include <algorithm>

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

}  // namespace

Derivatives derivatives(const Motion& motion, double window) {
  const Eigen::Index n = motion.time.size();
  Derivatives all{Eigen::MatrixXd::Zero(motion.q.rows(), n), Eigen::MatrixXd::Zero(motion.q.rows(), n)};
  if (n < 3) {
    if (n == 2) all.speed.colwise() = (motion.q.col(1) - motion.q.col(0)) / (motion.time(1) - motion.time(0));
    return all;
  }
  const double half = window / 2.0 * (1.0 + 1e-9);  // so that an even grid gives windows of one size
  Samples within;
  Eigen::Matrix<double, Eigen::Dynamic, 3> powers;
  Eigen::Matrix<double, Eigen::Dynamic, 2> weights;
  for (Eigen::Index k = 0; k < n; ++k) {
    within = around(motion.time, k, half, within);
    const Samples use = at_least(within, k, n);
    // In units of the window, so that the moments stay near 1.
    const double scale = motion.time(use.first + use.count - 1) - motion.time(use.first);
    powers.resize(use.count, 3);
    powers.col(0).setOnes();
    powers.col(1) = (motion.time.segment(use.first, use.count).array() - motion.time(k)) / scale;
    powers.col(2) = powers.col(1).cwiseAbs2();
    const Eigen::Matrix3d moments = powers.transpose() * powers;
    const Eigen::Matrix3d inverse = moments.inverse();
    weights.noalias() = powers * inverse.rightCols<2>();
    weights.col(0) /= scale;
    weights.col(1) *= 2.0 / (scale * scale);
    // Differences from the sample itself: a joint that stands still has speed 0 to the last bit.
    for (Eigen::Index i = 0; i < use.count; ++i) {
      const auto difference = motion.q.col(use.first + i) - motion.q.col(k);
      all.speed.col(k) += weights(i, 0) * difference;
      all.acceleration.col(k) += weights(i, 1) * difference;
    }
  }
  return all;
}

}  // namespace ballbar
