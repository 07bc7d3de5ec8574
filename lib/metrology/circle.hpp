#pragma once
/// One circle in the standards' words.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/result.hpp"
#include "numerics/harmonics.hpp"

namespace ballbar {

/// Orders 1..K of a fit, each with its covariance.
std::vector<Harmonic> harmonics_of(const HarmonicFit& fit);

/// Two descriptions of one trace, each exact in its own terms.
///
/// The shape as plotted: each sample at (radius + deviation) in the direction of its angle. Its geometric
/// least-squares circle gives eccentricity_x, _y, circular_deviation, radial_max and radial_min (metrology.md
/// 2); circular_deviation_mz is the minimum zone of the same points.
///
/// The motion: the angle is that of the robot's commanded motion about the programmed centre, not the
/// direction of the bar. With the ball off by e the bar reads length = |rho(angle) u(angle) + e|, u = (cos,
/// sin). The e is solved for which rho = -e.u + sqrt(length^2 - (e x u)^2) holds no first harmonic; order 1
/// of the harmonics is that e, and the mean, all other orders and the noise are those of rho - radius. So an
/// eccentric ball leaves neither mean nor ovality behind, where the plain harmonics of the deviation hold e^2
/// / 4R of each. Standard deviations hold to first order in e / radius.
///
/// @param angle      n values [rad] of the measured arc only, in sequence of time
/// @param deviation  n values [m], bar length - radius
/// @param radius     [m] nominal, > 0
/// @return nothing where the samples determine no circle: fewer than 4, an arc too short for the first
///         harmonic, a bar of no length, or lengths that no circle comes near (eccentricity beyond the
///         radius)
/// @throws std::invalid_argument for other sizes, a value that is not finite, or a radius that is not > 0
std::optional<CircleResult> analyse_circle(const Eigen::VectorXd& angle, const Eigen::VectorXd& deviation,
                                           double radius, int max_order = 30);

/// Amplitude of order 2 [m]: half of what pure ovality spreads the radius from its largest to its smallest.
/// Nothing where the arc did not carry order 2.
std::optional<Estimate> ovality(const CircleResult& circle);

/// Direction of the long axis of order 2, arg(a2 + i b2) / 2 [rad], 0 <= axis < pi. Its sd is at most that of
/// a direction of which nothing is known, pi / sqrt(12).
std::optional<Estimate> ovality_axis(const CircleResult& circle);

/// Distance of the least-squares centre from the nominal one [m].
Estimate eccentricity(const CircleResult& circle);

/// Direction of the least-squares centre [rad], 0 <= direction < 2 pi. Its sd is at most 2 pi / sqrt(12).
Estimate eccentricity_direction(const CircleResult& circle);

}  // namespace ballbar
