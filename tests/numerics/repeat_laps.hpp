#pragma once
/// Laps that differ by white noise and by noise that wanders from sample to sample.

#include <Eigen/Core>
#include <cmath>
#include <random>

namespace ballbar {

struct RepeatLaps {
  double white_sd, slow_sd, correlation;  ///< AR(1): correlation of neighbours, sd in the long run

  /// @return samples x laps, each lap begun afresh
  Eigen::MatrixXd draw(std::mt19937_64& random, Eigen::Index samples, Eigen::Index laps) const {
    std::normal_distribution<double> normal;
    Eigen::MatrixXd all(samples, laps);
    for (Eigen::Index lap = 0; lap < laps; ++lap) {
      double slow = slow_sd * normal(random);
      for (Eigen::Index i = 0; i < samples; ++i) {
        all(i, lap) = slow + white_sd * normal(random);
        slow = correlation * slow + slow_sd * std::sqrt(1.0 - correlation * correlation) * normal(random);
      }
    }
    return all;
  }
};

}  // namespace ballbar
