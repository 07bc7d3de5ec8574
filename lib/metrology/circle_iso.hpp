#pragma once
/// Circles by ISO 230-4: one direction, and both directions of one repetition joined into one test result.
///
/// Figures are of the driven path: each sample lies at its bar length in the direction of the bar, which is
/// the commanded angle turned by the ball's offset. (A trace plotted at the commanded angle differs by
/// offset^2 / radius: 25 nm for 0.05 mm, 2.5 um for 0.5 mm, at 100 mm.) Definitions: metrology.md 2, written
/// from general knowledge of ISO 230-4:2005, H of ISO 230-4:1996, and ISO 12181; not the standards' wording.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "core/result.hpp"
#include "core/spec.hpp"

namespace ballbar {

/// The measured arc of one run, and the conditions that ISO 230-4 wants on record.
struct CircleTrace {
  Eigen::VectorXd angle;  ///< n values [rad], without jumps, of the measured arc only, in sequence of time
  Eigen::VectorXd deviation;                   ///< n values [m], bar length - radius
  int direction = 0;                           ///< +1 counter-clockwise, -1 clockwise
  double feed = 0.0;                           ///< [m/s] programmed, 0 = not known
  std::optional<double> temperature;           ///< [degC]
  std::optional<double> calculated_feed = {};  ///< [m/s] as calculated_feed() of arc.hpp; goes on record
};

struct CircleSettings {
  std::optional<double> filter_upr;      ///< Gaussian filter before all figures but the counts; nothing: none
  std::optional<double> expansion = {};  ///< [1/K] of what drives the circle, for R20; nothing: no R20
};

/// The points of the driven path [m] about the ball: length of the bar, in its direction. The ball's offset e
/// is that of the least-squares fit of length = |rho u(angle) + e| with one rho; the points' direction hangs
/// on it to first order in e / radius only, so an arc too short to carry e exactly does no harm.
/// @return 2 x n
/// @throws std::invalid_argument for other sizes, a value that is not finite, or a length that is not > 0
Eigen::Matrix2Xd driven_path(const Eigen::VectorXd& angle, const Eigen::VectorXd& deviation, double radius);

/// The radius of the driven motion - nominal radius [m], one list per trace, with the ball's offset, common
/// to all traces, removed: rho - radius of bar length = |rho u + e|. What the offset's estimate leaves of e.u
/// is a first harmonic.
/// @throws std::invalid_argument as driven_path
std::vector<Eigen::VectorXd> motion_deviations(const std::vector<CircleTrace>& traces, double radius);

/// Whether angles carry a centre: no coefficient of mean, cos and sin has a standard deviation more than
/// HarmonicBasis::kWorstDilution times that of a full turn's. About 125 deg of even samples do.
bool carries_centre(const Eigen::VectorXd& angle);

/// R20 = R / (1 + expansion (temperature - 20)): the radius that the circle would have at 20 degC, the bar's
/// length being right at the temperature of the test (metrology.md 1.1). That of the bar itself is not
/// taken off. The standard deviation is that of R: how well temperature and expansion are known is not in it.
/// @param radius       [m]
/// @param temperature  [degC]
/// @param expansion    [1/K]
Estimate radius_at_20(const Estimate& radius, double temperature, double expansion);

/// What an arc defines, by its length:
///  - F about the set-up centre: always.
///  - G: wherever a circle is determined; but on an arc that does not carry its centre G says only what no
///  shift of the
///    centre and change of radius imitates. That is so in the standard too; set-up G = F max - F min then
///    says more.
///  - least-squares centre, radius (and D), F about it, and roundness by least squares: an arc that carries
///  its centre.
///  - maximum inscribed and minimum circumscribed circle: samples all around, no gap of half a turn or more.
///  - R20: where a temperature and an expansion are given, as the least-squares radius.
///  - with a filter: all of the part that the filter leaves (gaussian_filter.hpp).
/// @return nothing for fewer than 4 samples, or a filter that the samples do not carry
/// @throws std::invalid_argument as driven_path
std::optional<CircleFigures> circle_figures(const CircleTrace& trace, const CircleSpec& spec,
                                            const CircleSettings& settings = {});

/// Joins counter-clockwise and clockwise of one repetition. H compares the radii about the common
/// least-squares centre (the set-up centre where the arc does not carry one) at every sample of both, between
/// samples linearly.
///
/// Positional tolerance: width of the band, symmetrical about a circle of nominal radius, that holds the
/// paths of both directions: 2 max |radius - nominal| about the same centre as H. Ballbar 20 prints a figure
/// of this name; no public text that defines it was found, so this one is derived: the profile tolerance of
/// ISO 1101 that the circle keeps, with size error and reversals and without the place of the ball.
/// @throws std::invalid_argument where a direction is not what it is given as, or as driven_path
std::optional<CirclePair> join(const CircleTrace& ccw, const CircleTrace& cw, const CircleSpec& spec,
                               const CircleSettings& settings = {});

}  // namespace ballbar
