#pragma once
/// Straightness of lines, one way and both ways.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "core/run.hpp"
#include "core/spec.hpp"

namespace ballbar {

/// Positions that agree to this are the same point of the line.
inline constexpr double kSamePosition = 1e-6;  ///< [m]

/// A line as straightness optics see it: deviations are perpendicular to the beam.
struct LineFrame {
  Eigen::Vector3d start;  ///< [m] in the robot's base frame
  Eigen::Vector3d along;  ///< unit, from start to end

  /// The world's axis made orthogonal to the line, unit; NaN where the line lies along that axis.
  /// @param axis  'X', 'Y' or 'Z'
  Eigen::Vector3d across(char axis) const;

  /// The world's axes that are not the line's main one, "XZ": along these it is read.
  std::string axes_across() const;

  /// Of n points off the line, + = towards the axis. @param points  3 x n [m] @return n values [m]
  Eigen::VectorXd deviations(const Eigen::Matrix3Xd& points, char axis) const;
};

LineFrame frame_of(const LineSpec& line);

/// One run in one direction of deviation: mean of the readings at each position, by rising position, and the
/// straightness of these points (max - min of the deviation from a line: minimum zone, least squares, end
/// points; metrology.md 2).
/// @param readings  of one axis
/// @return nothing for fewer than three positions
/// @throws std::invalid_argument where axes are mixed or a reading is not finite
std::optional<LineResult> analyse_line(const std::vector<InterferometerReading>& readings);

/// Adds forward - backward to each point that has a partner, with the largest by size (and its sign) and the
/// mean of them. Nothing is added where no positions agree or direction is 0.
/// @param direction  +1 where `line` is the forward run, -1 where it is the backward run
/// @param other_way  points of the run the other way
void add_reversal(LineResult& line, int direction, const std::vector<LinePoint>& other_way);

/// Straightness of a set of readings.
struct Straightness {
  double mz = 0.0;        ///< [m] minimum zone
  double ls = 0.0;        ///< [m] about the least-squares line
  double ep = 0.0;        ///< [m] about the line through the means at the first and at the last position
  double slope_ls = 0.0;  ///< [m/m]
};

/// Straightness of points in any sequence; positions may repeat.
/// @return nothing for fewer than three positions
std::optional<Straightness> straightness_of(const std::vector<LinePoint>& points);

/// Several runs of one line, both ways, in one direction of deviation. "Mean of runs": the mean at each
/// position first.
struct LineBundle {
  std::optional<Straightness> all_runs;  ///< every reading of both ways in one set
  std::optional<Straightness> forward;   ///< every reading of the forward runs in one set
  std::optional<Straightness> forward_mean_of_runs;
  std::optional<Straightness> backward;
  std::optional<Straightness> backward_mean_of_runs;
  std::vector<LinePoint> forward_mean;   ///< by rising position, with reversal where both ways were measured
  std::vector<LinePoint> backward_mean;  ///< likewise
  std::optional<double>
      reversal_max;  ///< [m] mean forward - mean backward, the largest by size, with its sign
  std::optional<double> reversal_mean;  ///< [m]
};

/// @param forward,backward  the points of each run; either may be empty
LineBundle analyse_line_bundle(const std::vector<std::vector<LinePoint>>& forward,
                               const std::vector<std::vector<LinePoint>>& backward);

}  // namespace ballbar
