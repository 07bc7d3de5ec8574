#pragma once
/// Repetitions of a line both ways: the figures of ISO 230-2 over the points, what separates the two bundles,
/// and the poses of the stops after ISO 9283.

#include <optional>
#include <vector>

#include "core/result.hpp"

namespace ballbar {

/// Runs of one line in one direction of travel and of deviation; each by rising position.
using LineRuns = std::vector<std::vector<LinePoint>>;

/// One point of the line, over the runs. Deviations are about the reference line.
struct BidirectionalPoint {
  double position = 0.0;       ///< [m]
  double forward = 0.0;        ///< [m] mean deviation of the forward runs
  double forward_sd = 0.0;     ///< [m] of a single run, over n - 1
  double backward = 0.0;       ///< [m]
  double backward_sd = 0.0;    ///< [m]
  double reversal = 0.0;       ///< [m] B_i = forward - backward
  double repeatability = 0.0;  ///< [m] R_i = max(2 s_f + 2 s_b + |B_i|, 4 s_f, 4 s_b)
};

/// The figures of ISO 230-2:2014 (metrology.md 2), formed with the *straightness* deviation, perpendicular to
/// the line, in place of the positioning deviation along it, for which the standard defines them. So they are
/// no positioning accuracy, and not to be held against one.
struct BidirectionalFigures {
  std::vector<BidirectionalPoint> points;  ///< where both ways were measured at least twice
  double reference_slope = 0.0;         ///< [m/m] of the line that was taken off both ways alike, see below
  double reversal = 0.0;                ///< [m] B = max |B_i|
  double reversal_mean = 0.0;           ///< [m] mean of B_i, with its sign
  double forward_repeatability = 0.0;   ///< [m] max 4 s_i
  double backward_repeatability = 0.0;  ///< [m]
  double repeatability = 0.0;           ///< [m] R = max R_i
  double forward_systematic_deviation = 0.0;   ///< [m] range of the forward means
  double backward_systematic_deviation = 0.0;  ///< [m]
  double systematic_deviation = 0.0;           ///< [m] E: range of the means of both ways together
  double mean_bidirectional_deviation = 0.0;   ///< [m] M: range of (forward + backward) / 2
  double forward_accuracy = 0.0;               ///< [m] max(mean + 2 s) - min(mean - 2 s)
  double backward_accuracy = 0.0;              ///< [m]
  double accuracy = 0.0;                       ///< [m] A: the same over both ways
};

/// The optics' zero and slope are arbitrary, so the least-squares line through (forward + backward) / 2 is
/// taken off both ways alike; reversal and repeatability do not feel it.
/// @return nothing where fewer than three points were measured twice both ways (five times in the standard)
/// @throws std::invalid_argument where a reading is not finite
std::optional<BidirectionalFigures> bidirectional_figures(const LineRuns& forward, const LineRuns& backward);

/// What separates the two bundles: the difference of the mean paths, forward - backward, as a constant, a
/// slope and the rest. Constant and slope are least squares over the points; the three are orthogonal, so
/// their shares of the mean square of the difference add to 1.
struct BundleDifference {
  int points = 0;      ///< positions that both ways have
  Estimate constant;   ///< [m] reversal in the middle of the points: lost motion across the line
  Estimate slope;      ///< [m/m] the bundles are turned against each other
  double shape = 0.0;  ///< [m] rms of what both leave
  /// [m] rms of that which the scatter of the runs alone would leave, nearly; nothing where a way has one run
  std::optional<double> shape_by_chance = {};
  double constant_share = 0.0;  ///< 0..1
  double slope_share = 0.0;     ///< 0..1
  double shape_share = 0.0;     ///< 0..1
};

/// The sd of constant and slope are from run to run: each run's own least-squares constant and slope. They
/// are absent for fewer than two runs a way, or where a run lacks one of the points. All shares are 0 where
/// the bundles are the same.
/// @return nothing for fewer than three points that both ways have
std::optional<BundleDifference> difference_of(const LineRuns& forward, const LineRuns& backward);

/// One stop of the line in one direction of travel.
struct StopPose {
  double position = 0.0;  ///< [m]
  int direction = 0;      ///< +1 forward, -1 backward
  int runs = 0;           ///< that stopped here
  double accuracy = 0.0;  ///< [m] AP = |mean - reference line|
  std::optional<double>
      repeatability;  ///< [m] RP = mean + 3 sd of the distances from the mean; from two runs
};

/// Pose accuracy and repeatability of ISO 9283 (metrology.md 2) at each stop, as a *projection* on the one
/// direction of deviation that was measured, or on the plane of two where the same runs measured both: the
/// deviation along the line, which straightness optics do not see, is not in it. Commanded is the
/// least-squares line of all readings of both ways, for the optics have no zero of their own; so an offset or
/// a tilt of the whole line is not in it either.
/// @param forward,backward                 deviations of each run
/// @param forward_across,backward_across   of the same runs, perpendicular to that; all empty where it was
/// not
///                                         measured
/// @return by direction (forward first), then position; empty for fewer than three positions
/// @throws std::invalid_argument where a second direction belongs to another number of runs, or a reading is
///         not finite
std::vector<StopPose> stop_poses(const LineRuns& forward, const LineRuns& backward,
                                 const LineRuns& forward_across = {}, const LineRuns& backward_across = {});

}  // namespace ballbar
