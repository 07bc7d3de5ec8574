#pragma once
/// The error signatures of a machine tool's ballbar test (metrology.md 1.2) as one weighted least-squares fit
/// on the measured angles of both directions, ranked by their share of the circular error.
///
/// On a robot these are SHAPES, not causes: a robot has no X and Y slides. "Backlash X" says that the trace
/// steps where motion along X turns round, not that an X axis has play. They are given in a frame turned by
/// `frame_angle` against the plane's axes: 0 is the plane's own frame; radial_angle() turns X along the
/// radius from the robot's base axis, in which reversals of its joints lie near the axes
/// (metrology.md 6.1, 6.4).
///
/// dR of each, theta from X, s = +1 counter-clockwise, -1 clockwise, R radius, v feed:
///   radius_change        dR0                                     m
///   scaling_mismatch     R/2 a cos 2theta, a = a_x - a_y         1
///   squareness           -R/2 beta sin 2theta                    rad
///   straightness_x, _y   c/4 sin 3theta, -d/4 cos 3theta         m, bow peak to valley over the diameter
///   three_lobe           s (p cos 3theta + q sin 3theta)         m, hypot(p, q): the part of order 3 that
///   does not repeat
///                        between the directions; the part that does cannot be told from straightness
///   servo_mismatch       s v/2 dtau sin 2theta                   s, tau_x - tau_y
///   backlash_x, _y       s B/2 sgn(sin) cos, -s B/2 sgn(cos) sin m
///   lateral_play_x, _y   -s L/2 |sin|, s L/2 |cos|               m
///   reversal_spike_x, _y h exp(-travel/s0) |cos|, |sin|          m, + outward; travel since motion along the
///   axis turned cyclic_x, _y         a sin(2 pi R cos/pitch + f) cos; y: sin m spiral               g x
///   share of a turn driven              m per turn vibration            rms of what is above order 15,
///   cyclic apart, sensor noise taken off    m
/// master_slave_changeover  h/2 sgn(cos 2theta)               m, steps at 45 degrees; of machines with two
/// motors on an axis
/// All to first order: an error of x across the radius leaves x^2 / 2R more, 0.05 um for 0.1 mm at R = 100
/// mm. The centre offset and e^2/4R that it leaves are removed, not ranked. A radius that shrinks with speed
/// (servo loop) is in radius_change: one feed cannot tell them apart; so is R (a_x + a_y) / 2.

#include <Eigen/Core>
#include <optional>
#include <string>
#include <vector>

#include "metrology/circle_iso.hpp"

namespace ballbar {

/// @param traces  of one repetition: one or both directions, of one ball and one feed
/// @param radius  [m] nominal
/// @param frame_angle  [rad] of X from the plane's first axis
/// @return nothing for fewer than 60 samples
/// @throws std::invalid_argument as driven_path, and for a direction that is not +1 or -1
std::optional<SignatureFit> fit_signatures(const std::vector<CircleTrace>& traces, double radius,
                                           double frame_angle);

/// All of them, as above.
const std::vector<std::string>& signature_names();

/// Unit of a signature's value outside lib/, and the factor from SI: {"um/m", 1e6}.
struct SignatureUnit {
  std::string unit;
  double factor = 1.0;
};
SignatureUnit unit_of(const std::string& signature);

/// Direction in the plane, from its first axis, of the radius from the base's axis (z through the origin of
/// the base frame) to the circle's centre [rad]. Nothing where that radius is less than a hundredth of the
/// distance, or stands upright on the plane.
std::optional<double> radial_angle(const CircleSpec& spec);

}  // namespace ballbar
