#include <algorithm>
#include <cmath>

#include "physics/effects.hpp"

namespace ballbar {
namespace {

constexpr double kReach = 5.0;  // sigmas: what lies further has less than 1e-6 of the weight

/// Value at t of the line that fits the samples best under the Gaussian's weights. On an even grid that is
/// the weighted mean; on any grid, and at the ends, it leaves a straight motion as it is.
Eigen::VectorXd smoothed(const Motion& motion, Eigen::Index first, Eigen::Index end, double t, double sigma) {
  const Eigen::Index n = motion.time.size();
  double w0 = 0.0, w1 = 0.0, w2 = 0.0;
  Eigen::VectorXd q0 = Eigen::VectorXd::Zero(motion.q.rows());
  Eigen::VectorXd q1 = q0;
  for (Eigen::Index i = first; i < end; ++i) {
    const double u = (motion.time(i) - t) / sigma;
    const double share = motion.time(std::min(i + 1, n - 1)) - motion.time(std::max<Eigen::Index>(i - 1, 0));
    const double w = share * std::exp(-u * u / 2.0);
    w0 += w;
    w1 += w * u;
    w2 += w * u * u;
    q0 += w * motion.q.col(i);
    q1 += w * u * motion.q.col(i);
  }
  const double spread = w0 * w2 - w1 * w1;
  if (spread < 1e-9 * w0 * w0) return q0 / w0;  // the Gaussian is narrower than the grid
  return (w2 * q0 - w1 * q1) / spread;
}

void command(const Effect& effect, Motion& motion) {
  const double sigma = effect.values[0];
  const Eigen::Index n = motion.time.size();
  if (sigma == 0.0 || n < 2) return;
  Eigen::MatrixXd q(motion.q.rows(), n);
  Eigen::Index first = 0, end = 0;
  for (Eigen::Index k = 0; k < n; ++k) {
    while (motion.time(first) < motion.time(k) - kReach * sigma) ++first;
    while (end < n && motion.time(end) <= motion.time(k) + kReach * sigma) ++end;
    q.col(k) = smoothed(motion, first, end, motion.time(k), sigma);
  }
  motion.q = std::move(q);
}

}  // namespace

/// Every joint's command is convolved with a Gaussian of sigma = time: zero phase, q + time^2 / 2 q'' for
/// slow motions. A circle of radius R at angular speed w loses R (1 - exp(-w^2 time^2 / 2)). Even, grows with
/// speed squared. A grid coarser than 1.6 time smooths less than it should. Simplified: joints, not the tool
/// point, are smoothed; controllers differ in that.
/// Source: physics-gap.md 3, row 7.
EffectKind path_smoothing() {
  return {.name = "path_smoothing",
          .parameters = {{.name = "time_ms",
                          .si = 1e-3,
                          .typical = 20.0,
                          .least = 0.0,
                          .most = 1000.0,
                          .meaning = "sigma of the Gaussian over time"}},
          .meaning = "the controller rounds the path: circles shrink with speed squared",
          .source = "Slamani, Nubiola, Bonev, Ind. Robot 39 (2012) 57; convolution with a Gaussian",
          .command = command};
}

}  // namespace ballbar
