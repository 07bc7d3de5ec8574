#pragma once
/// What an instrument reads of the tool point, and what its set-up leaves open.

#include <Eigen/Core>

#include "core/spec.hpp"

namespace ballbar {

struct Instrument {
  TestKind kind = TestKind::kCircle;
  Eigen::Vector3d origin = Eigen::Vector3d::Zero();  ///< [m] programmed centre, in the base frame
  double radius = 0.0;                               ///< [m] nominal length of the bar

  bool is_bar() const { return kind == TestKind::kCircle; }
};

/// The reading of a perfect instrument, and how it changes with the tool point.
struct Sight {
  Eigen::VectorXd reading;  ///< [m] n
  Eigen::MatrixXd along;    ///< n x 3: unit vectors along which a movement of the tool point is read in full
};

/// A bar reads |point - ball| - radius.
/// @param points      3 x n [m] in the base frame
/// @param set_up      [m] the ball, from the programmed centre
/// @param ball_moved  3 x n [m] of the ball since then
Sight sight_of(const Instrument& instrument, Eigen::Matrix3Xd points, const Eigen::Vector3d& set_up,
               const Eigen::Matrix3Xd& ball_moved);

/// What a set-up leaves open: n x 3, of the reading by each of its three numbers.
Eigen::MatrixXd set_up_columns(const Instrument& instrument, const Eigen::MatrixXd& along);

}  // namespace ballbar
