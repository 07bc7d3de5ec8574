#pragma once
/// Repetitions of one test and direction: mean and scatter of the harmonics, path accuracy and repeatability.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/result.hpp"
#include "numerics/hotelling.hpp"

namespace ballbar {

/// One order over n repetitions, as the vector (a_k, b_k): its length alone would hide that it turned.
struct RepeatedHarmonic {
  int order = 0;
  std::vector<Eigen::Vector2d> values;  ///< [m] one per repetition: cos, sin
  VectorSample sample;                  ///< [m], [m^2] mean and 2x2 covariance of them
};

/// The orders 1, 2, ... that all repetitions hold.
/// @param runs  the harmonics of each repetition: orders 1..K without holes, as in CircleResult
/// @throws std::invalid_argument where orders are missing or out of sequence
std::vector<RepeatedHarmonic> repeat_harmonics(const std::vector<std::vector<Harmonic>>& runs);

/// Has an order moved since the baseline? Hotelling's T^2 of two samples.
/// @return nothing where the repetitions are too few: together less than four, or one of both has none
std::optional<T2Test> drift_of(const RepeatedHarmonic& series, const RepeatedHarmonic& baseline);

/// One repetition on its measured arc.
struct RadialTrace {
  std::vector<double> angle;      ///< [rad] of the robot's motion; rising or falling; NaN where not known
  std::vector<double> deviation;  ///< [m] one per angle: bar length - nominal length
};

/// Mean path of n repetitions and its scatter, at `angle`.
struct RadialPath {
  int runs = 0;
  std::vector<double> angle;  ///< [rad] of the grid
  std::vector<double> mean;   ///< [m] of the deviations at each angle
  std::vector<double> sd;     ///< [m] of a single run at each angle, over n - 1; empty for one run

  /// AT_r = max |mean|: path accuracy of ISO 9283 as a radial projection, about the ball: where the ball was
  /// set is in it.
  double accuracy = 0.0;
  double accuracy_angle = 0.0;  ///< [rad] where

  /// The same about the mean path's own centre: without its first harmonic, the ball's set-up. To first order
  /// in eccentricity e; what is left out is at most e^2 / 2 R.
  double accuracy_centred = 0.0;

  /// RT_r = max 3 sd: path repeatability of ISO 9283 as a radial projection. Nothing for one run. The bar's
  /// own noise is in it.
  std::optional<double> repeatability;
  double repeatability_angle = 0.0;  ///< [rad] where
};

/// Path accuracy and repeatability on a common grid of angles (metrology.md 2, ISO 9283:1998, n = 10 there).
/// Both are *radial projections*: a bar sees its own direction only, not the deviation along the path or out
/// of its plane. The standard's own AT is at least AT_r.
///
/// The grid is `points` angles in the middles of as many equal parts of the arc that all runs share; each run
/// is interpolated linearly. Angles that a run does not have within kWidestHole are left out.
/// @param points  > 0
/// @return nothing for no run, or where the runs share no arc
/// @throws std::invalid_argument for other sizes or a deviation that is not finite
std::optional<RadialPath> radial_path(const std::vector<RadialTrace>& runs, int points = 360);

inline constexpr double kWidestHole = 0.09;  ///< [rad] between two samples: some 5 degrees

}  // namespace ballbar
