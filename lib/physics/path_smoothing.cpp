#include <limits>

#include "numerics/interpolate.hpp"
#include "physics/effects.hpp"

namespace ballbar {
namespace {

constexpr double kReach = 5.0;  // sigmas: what lies further has less than 1e-6 of the weight
constexpr double kAnyWidth = std::numeric_limits<double>::infinity();
constexpr int kNodes = 21;  // over both reaches: every half sigma, at which sums of a Gaussian are exact

void path_smoothing_command(const Effect& effect, Motion& motion) {
  const double sigma = effect.values[0];
  const Eigen::Index n = motion.time.size();
  if (sigma == 0.0 || n < 2) return;
  const double first = motion.time[0], last = motion.time[n - 1];
  const Eigen::VectorXd sigmas = Eigen::VectorXd::LinSpaced(kNodes, -kReach, kReach);
  const Eigen::VectorXd weight = (-sigmas.array().square() / 2.0).exp().matrix();
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(n);
  Eigen::VectorXd w1 = sum, w2 = sum;
  Eigen::MatrixXd q0 = Eigen::MatrixXd::Zero(motion.q.rows(), n);
  Eigen::MatrixXd q1 = q0;
  for (int i = 0; i < kNodes; ++i) {
    const Eigen::VectorXd at = (motion.time.array() + sigma * sigmas[i]).max(first).min(last);
    const Eigen::MatrixXd there = interpolate(motion.time, motion.q, at, kAnyWidth, Interpolation::kCubic);
    // Beyond the ends nothing is known; the line through what is left gives the value.
    const Eigen::ArrayXd known =
        ((motion.time.array() + sigma * sigmas[i] - at.array()).abs() < 1e-9 * sigma).cast<double>();
    const Eigen::ArrayXd w = weight[i] * known;
    sum.array() += w;
    w1.array() += w * sigmas[i];
    w2.array() += w * sigmas[i] * sigmas[i];
    q0 += there * w.matrix().asDiagonal();
    q1 += there * (w * sigmas[i]).matrix().asDiagonal();
  }
  const Eigen::ArrayXd spread = sum.array() * w2.array() - w1.array().square();
  motion.q = q0 * (w2.array() / spread).matrix().asDiagonal();
  motion.q -= q1 * (w1.array() / spread).matrix().asDiagonal();
}

}  // namespace

/// Every joint's command is convolved with a Gaussian of sigma = time: zero phase, q + time^2 / 2 q'' for
/// slow motions. A circle of radius R at angular speed w loses R (1 - exp(-w^2 time^2 / 2)). Even, grows with
/// speed squared. Between samples the command is the cubic
/// through its neighbours. Simplified: joints, not the tool
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
          .command = path_smoothing_command};
}

}  // namespace ballbar
