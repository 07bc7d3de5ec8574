#pragma once
/// What was found in a Run. SI inside; names with units are made in pipeline/catalogue only.

#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <vector>

#include "core/circle_figures.hpp"
#include "core/estimate.hpp"
#include "core/run.hpp"

namespace ballbar {

/// One order of deviation = sum a_k cos(k angle) + b_k sin(k angle), with its 2x2 covariance.
struct Harmonic {
  int order = 0;
  double cos = 0.0;          ///< [m] a_k
  double sin = 0.0;          ///< [m] b_k
  double var_cos = 0.0;      ///< [m^2]
  double var_sin = 0.0;      ///< [m^2]
  double cov_cos_sin = 0.0;  ///< [m^2]
};

struct CircleResult {
  Estimate mean_radius_deviation;      ///< [m] order 0 about the centre that was removed
  double eccentricity_x = 0.0;         ///< [m] least-squares centre, along the plane's first axis
  double eccentricity_y = 0.0;         ///< [m] along normal x first axis
  double eccentricity_sd = 0.0;        ///< [m] of each component
  double circular_deviation = 0.0;     ///< [m] max - min about the least-squares centre
  double circular_deviation_mz = 0.0;  ///< [m] the smallest possible (minimum-zone centre)
  double radial_max = 0.0;             ///< [m] from the nominal radius, about the least-squares centre
  double radial_min = 0.0;             ///< [m]
  double noise = 0.0;  ///< [m] standard deviation from sample to sample: the instrument's, not the robot's
  double residual =
      0.0;  ///< [m] standard deviation of what all fitted orders leave: reversals, ripple, noise
  std::vector<Harmonic>
      harmonics;  ///< orders 1..K without holes; order 1 = the eccentricity that was removed
};

/// Gap = measured - predicted, of one circle, with the ball where the model fits best: a ball that stands
/// elsewhere is the set-up's, not the robot's.
struct CircleGap {
  Estimate mean;               ///< [m] order 0
  double rms = 0.0;            ///< [m] about the mean
  double largest = 0.0;        ///< [m] about the mean, the largest by size over a degree, with its sign
  double largest_angle = 0.0;  ///< [rad] where that is, within the measured arc
  /// [s] so much later than their times say the bar's samples were taken; removed. Only where it was fitted.
  std::optional<Estimate> time_shift;
  std::vector<Harmonic>
      harmonics;  ///< orders 1..K without holes; order 1 = the ball's place, which was removed
};

/// The same of a line, with the alignment of the optics (offset and slope) that fits best.
struct LineGap {
  double rms = 0.0;               ///< [m]
  double largest = 0.0;           ///< [m] the largest by size, with its sign
  double largest_position = 0.0;  ///< [m] where that is
};

struct LinePoint {
  double position = 0.0;           ///< [m] along the line, from its start
  double deviation = 0.0;          ///< [m] mean of the readings at this position
  std::optional<double> reversal;  ///< [m] forward - backward, where the run the other way has a reading here
  std::optional<double> predicted = {};  ///< [m] the model's deviation, aligned as the optics were
};

/// Straightness of one line in one direction of deviation.
struct LineResult {
  char axis = 'X';
  std::vector<LinePoint> points;        ///< by rising position
  double straightness_mz = 0.0;         ///< [m] minimum zone
  double straightness_ls = 0.0;         ///< [m] about the least-squares line
  double straightness_ep = 0.0;         ///< [m] about the line through the end points
  double slope_ls = 0.0;                ///< [m/m]
  std::optional<double> reversal_max;   ///< [m] forward - backward, the largest by size, with its sign
  std::optional<double> reversal_mean;  ///< [m]
  std::optional<LineGap> gap;
};

/// A result as rules, lists, SQL and JSON see it: labels, and numbers by name with unit. One per circle, one
/// per axis of a line.
struct Record {
  std::string robot, test, kind, series, axis, status, angle_source, source, plane, predicted_from;
  int direction = 0;
  int repetition = 0;
  std::int64_t started_us = 0;
  std::map<std::string, Estimate> values;
  std::map<std::string, std::string> words;  ///< of a diagnosis: verdict, effect, effect_kind; else none
  std::vector<Record> parts;                 ///< of a diagnosis: its findings; else none
  bool operator==(const Record&) const = default;
};

/// What only both directions of one repetition tell. Found with the run that completes them.
struct CircleTest {
  CirclePair figures;
  std::optional<SignatureFit> signatures;         ///< in the plane's own frame
  std::optional<SignatureFit> radial_signatures;  ///< X along the radius from the base's axis, where there is
                                                  ///< one in the plane
};

struct RunResult {
  /// "ok", or one word for what is wrong; figures may be there all the same, but rules do not see them. How
  /// the run ended: "aborted", "no_end", "no_begin", "marks_lost", "producer_restarted", "interrupted",
  /// "too_long". What was recorded: "too_few_samples", "arc_incomplete", "line_incomplete",
  /// "path_not_simple", "wrong_path", "no_direction", "wrong_direction", "no_joints", "no_bar",
  /// "implausible", "failed".
  std::string status = "ok";
  std::string message;  ///< for people: what is wrong where status is not "ok", else what the arc does not
                        ///< define and why, and a feed that is not the programmed one
  std::string angle_source;  ///< "joints", "time" or ""
  std::string source;        ///< "bar", "joints" (virtual ballbar) or "interferometer"
  std::string plane;         ///< circles: as plane_name() of metrology/arc.hpp
  std::int64_t samples = 0;  ///< in the measured arc, or readings of the line
  int direction = 0;         ///< the Run's, or found from the joints where the Run does not know it

  std::vector<double>
      angle;  ///< [rad] unwrapped, one per bar sample of the Run; NaN where not known; empty where none is
  std::size_t arc_begin = 0;  ///< the measured arc: bar samples [arc_begin, arc_end)
  std::size_t arc_end = 0;

  std::optional<CircleResult> circle;           ///< of an arc that carries its centre
  std::optional<CircleFigures> circle_figures;  ///< by ISO 230-4, of any arc
  std::optional<CircleTest> circle_test;        ///< where the run the other way was there already
  std::vector<LineResult> lines;                ///< by axis

  std::string predicted_from;  ///< "joints", "command", or "" where the model predicts nothing
  std::vector<double>
      predicted;  ///< [m] bar deviation that the model predicts, one per bar sample, the ball where
                  ///< it fits best; NaN outside the arc or where not known; empty where none is
  std::optional<CircleGap> circle_gap;
};

}  // namespace ballbar
