#include <algorithm>
#include <cmath>

#include "physics/effects.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr double kReach = 5.0;  // sigmas: what lies further has less than 1e-6 of the weight
constexpr int kNodes = 21;      // over both reaches: every half sigma, at which sums of a Gaussian are exact

/// The cubics through four neighbouring samples, as weights of these samples.
class Cubics {
 public:
  static constexpr Index kPoints = 4;

  explicit Cubics(const VectorXd& time) : time_(time), share_(kPoints, time.size() - kPoints + 1) {
    share_.setOnes();
    for (Index first = 0; first < share_.cols(); ++first)
      for (Index i = 0; i < kPoints; ++i)
        for (Index j = 0; j < kPoints; ++j)
          if (j != i) share_(i, first) /= time_[first + i] - time_[first + j];
  }

  /// The first of the samples about t: two on either side, the nearest at the ends. `from` is not behind it.
  Index first_of(double t, Index from) const {
    while (from + 1 < share_.cols() && time_[from + kPoints / 2] < t) ++from;
    return from;
  }

  /// What the samples from `first` on weigh at t.
  Eigen::Array4d at(Index first, double t) const {
    const Eigen::Array4d away = t - time_.segment<kPoints>(first).array();
    const double low = away[0] * away[1], high = away[2] * away[3];
    return Eigen::Array4d(away[1] * high, away[0] * high, away[3] * low, away[2] * low) * share_.col(first);
  }

 private:
  const VectorXd& time_;
  Eigen::Array4Xd share_;  ///< of each sample of a cubic: 1 / product of the distances to the others
};

void path_smoothing_command(const Effect& effect, Motion& motion) {
  const double sigma = effect.values[0];
  const Index n = motion.time.size();
  if (sigma == 0.0 || n < Cubics::kPoints) return;
  const double first = motion.time[0], last = motion.time[n - 1];
  const VectorXd sigmas = VectorXd::LinSpaced(kNodes, -kReach, kReach);
  const VectorXd weight = (-sigmas.array().square() / 2.0).exp().matrix();
  const Cubics cubics(motion.time);
  const Eigen::MatrixXd asked = motion.q;
  VectorXd plain(n), tilted(n);  // weights of the samples from `begin` on
  Index begin = 0;
  for (Index k = 0; k < n; ++k) {
    begin = cubics.first_of(std::max(first, motion.time[k] - kReach * sigma), begin);
    const Index most =
        std::min(n - begin, cubics.first_of(std::min(last, motion.time[k] + kReach * sigma), begin) - begin +
                                Cubics::kPoints);
    plain.head(most).setZero();
    tilted.head(most).setZero();
    double sum = 0.0, w1 = 0.0, w2 = 0.0;
    Index at = begin;
    for (int i = 0; i < kNodes; ++i) {
      const double wanted = motion.time[k] + sigma * sigmas[i];
      const double t = std::clamp(wanted, first, last);
      // Beyond the ends nothing is known; the line through what is left gives the value.
      if (!(std::abs(wanted - t) < 1e-9 * sigma)) continue;
      at = cubics.first_of(t, at);
      const double w = weight[i];
      const Eigen::Array4d share = w * cubics.at(at, t);
      plain.segment<Cubics::kPoints>(at - begin).array() += share;
      tilted.segment<Cubics::kPoints>(at - begin).array() += sigmas[i] * share;
      sum += w;
      w1 += w * sigmas[i];
      w2 += w * sigmas[i] * sigmas[i];
    }
    const double spread = sum * w2 - w1 * w1;
    motion.q.col(k).noalias() =
        asked.middleCols(begin, most) * ((w2 * plain.head(most) - w1 * tilted.head(most)) / spread);
  }
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
