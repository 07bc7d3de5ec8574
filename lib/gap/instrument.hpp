#pragma once
/// What an instrument reads of the tool point, and what its set-up leaves open.

#include <Eigen/Core>

#include "core/spec.hpp"

namespace ballbar {

struct Instrument {
  TestKind kind = TestKind::kCircle;
  Eigen::Vector3d origin =
      Eigen::Vector3d::Zero();  ///< [m] in the base frame: a circle's programmed centre, a line's start
  double radius = 0.0;          ///< circles: [m] nominal length of the bar
  Eigen::Vector3d across = Eigen::Vector3d::Zero();  ///< lines: unit, the direction that is read
  double length = 0.0;                               ///< lines: [m]
  char axis = ' ';                                   ///< lines: 'X', 'Y' or 'Z', as the instrument calls it

  bool is_bar() const { return kind == TestKind::kCircle; }
};

/// The reading of a perfect instrument, and how it changes with the tool point.
struct Sight {
  Eigen::VectorXd reading;  ///< [m] n
  Eigen::MatrixXd along;    ///< n x 3: unit vectors along which a movement of the tool point is read in full
};

/// A bar reads |point - ball| - radius; straightness optics read across . (point - start), and beside it how
/// they were aligned: offset + rise s, where s goes from -1 at the line's start to +1 at its end.
/// @param points      3 x n [m] in the base frame
/// @param place       n [m] of a line; not used of a circle
/// @param set_up      [m] of a circle: the ball, from the programmed centre; of a line: offset, rise, 0
/// @param ball_moved  3 x n [m] of the ball since then; not used of a line
Sight sight_of(const Instrument& instrument, Eigen::Matrix3Xd points, const Eigen::VectorXd& place,
               const Eigen::Vector3d& set_up, const Eigen::Matrix3Xd& ball_moved);

/// What a set-up leaves open: n x 3, of the reading by each of its three numbers.
/// @param along  of the Sight there
Eigen::MatrixXd set_up_columns(const Instrument& instrument, const Eigen::VectorXd& place,
                               const Eigen::MatrixXd& along);

}  // namespace ballbar
