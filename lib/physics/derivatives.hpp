#pragma once
/// Speeds and accelerations of a motion, whether a smooth command or a recording with rounded readings.

#include <Eigen/Core>

#include "physics/motion.hpp"

namespace ballbar {

struct Derivatives {
  Eigen::MatrixXd speed;         ///< [rad/s] joints x n
  Eigen::MatrixXd acceleration;  ///< [rad/s^2] joints x n
};

/// Slope and curvature at each sample of the parabola through the samples within half a window on either side
/// (least squares; at least the 5 nearest), so exact for quadratic motions on any time grid. Readings rounded
/// to sigma give accelerations to sigma sqrt(720 / n) / window^2, n = samples in the window; a sine of
/// angular frequency w loses (w window)^2 / 40 of its speed. Source: A. Savitzky, M. J. E. Golay, Anal. Chem.
/// 36 (1964) 1627-1639, on uneven times.
/// @param window  [s]; 80 ms lose 0.1 % of the speed at 300 mm/s on a 100 mm circle; 125 Hz give 11 readings
/// readings
Derivatives derivatives(const Motion& motion, double window = 0.08);

}  // namespace ballbar
