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
#include "numerics/minimum_zone.hpp"
#include "numerics/reference_circles.hpp"

namespace ballbar {

/// The measured arc of one run, and the conditions that ISO 230-4 wants on record.
struct CircleTrace {
  Eigen::VectorXd angle;  ///< n values [rad], without jumps, of the measured arc only, in sequence of time
  Eigen::VectorXd deviation;          ///< n values [m], bar length - radius
  int direction = 0;                  ///< +1 counter-clockwise, -1 clockwise
  double feed = 0.0;                  ///< [m/s], 0 = not known
  std::optional<double> temperature;  ///< [degC]
};

/// Why a figure is absent.
struct NotDefined {
  std::string figure;  ///< name of the field
  std::string reason;  ///< one sentence
  bool operator==(const NotDefined&) const = default;
};

/// Roundness about one of the reference circles (ISO 12181).
struct RoundnessAbout {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< [m] from the ball, in the plane's axes
  double radius = 0.0;                               ///< [m]; the middle of the zone for minimum zone
  Roundness roundness;                               ///< [m]
};

/// One direction.
struct CircleFigures {
  // the record
  int direction = 0;
  double nominal_radius = 0.0;        ///< [m]
  double feed = 0.0;                  ///< [m/s]
  Vec3 normal{};                      ///< of the plane, in the base frame
  Vec3 first_axis{};                  ///< angle 0
  double start_angle = 0.0;           ///< [rad] of the first sample
  double end_angle = 0.0;             ///< [rad] of the last sample
  std::optional<double> filter_upr;   ///< cut-off of the Gaussian filter; nothing: not filtered
  std::int64_t samples = 0;           ///< that the figures are of
  std::optional<double> temperature;  ///< [degC]

  // the figures
  std::optional<double> circular_error_mz;   ///< [m] G, least radial separation of two concentric circles
  bool circular_error_proved = false;        ///< no narrower pair exists (minimum_zone.hpp)
  std::optional<double> circular_error_ls;   ///< [m] G about the least-squares centre
  double radial_max_setup = 0.0;             ///< [m] F max, about the set-up centre: the ball
  double radial_min_setup = 0.0;             ///< [m] F min, likewise
  std::optional<double> radial_max_ls;       ///< [m] F max, about the least-squares centre
  std::optional<double> radial_min_ls;       ///< [m] F min, likewise
  std::optional<Estimate> radius_deviation;  ///< [m] least-squares radius - nominal
  std::optional<RoundnessAbout> lsc, mzc, mic, mcc;
  std::vector<NotDefined> not_defined;
};

/// Both directions of one repetition.
struct CirclePair {
  CircleFigures ccw, cw;
  std::optional<double> circular_error_b;  ///< [m] G(b), least radial separation that holds both paths
  bool circular_error_b_proved = false;
  std::optional<double> circular_error_b_ls;  ///< [m] the same about the common least-squares centre
  std::optional<Estimate> radial_error_d;     ///< [m] D, mean of both least-squares radii - nominal
  std::optional<double> hysteresis;           ///< [m] H (1996), largest difference of the radii at one angle
  double hysteresis_angle = 0.0;              ///< [rad] where
  double radial_max_setup = 0.0;              ///< [m] F max of both
  double radial_min_setup = 0.0;              ///< [m] F min of both
  std::vector<NotDefined> not_defined;        ///< of the pair; those of one direction are there
};

struct CircleSettings {
  std::optional<double> filter_upr;  ///< Gaussian filter before all figures but the counts; nothing: none
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

/// What an arc defines, by its length:
///  - F about the set-up centre: always.
///  - G: wherever a circle is determined; but on an arc that does not carry its centre G says only what no
///  shift of the
///    centre and change of radius imitates. That is so in the standard too; set-up G = F max - F min then
///    says more.
///  - least-squares centre, radius (and D), F about it, and roundness by least squares: an arc that carries
///  its centre.
///  - maximum inscribed and minimum circumscribed circle: samples all around, no gap of half a turn or more.
///  - with a filter: all of the part that the filter leaves (gaussian_filter.hpp).
/// @return nothing for fewer than 4 samples, or a filter that the samples do not carry
/// @throws std::invalid_argument as driven_path
std::optional<CircleFigures> circle_figures(const CircleTrace& trace, const CircleSpec& spec,
                                            const CircleSettings& settings = {});

/// Joins counter-clockwise and clockwise of one repetition. H compares the radii about the common
/// least-squares centre (the set-up centre where the arc does not carry one) at every sample of both, between
/// samples linearly.
/// @throws std::invalid_argument where a direction is not what it is given as, or as driven_path
std::optional<CirclePair> join(const CircleTrace& ccw, const CircleTrace& cw, const CircleSpec& spec,
                               const CircleSettings& settings = {});

}  // namespace ballbar
