#pragma once
/// Volumetric analysis: circles in three planes of one set-up, as Ballbar 20 takes them (metrology.md 1.1),
/// give squareness of all pairs of axes and scaling of all axes in one fit.

#include <array>
#include <optional>
#include <string>
#include <vector>

#include "core/estimate.hpp"
#include "metrology/circle_iso.hpp"

namespace ballbar {

/// One direction in one plane of the base frame, or any other plane.
struct PlaneTrace {
  std::string test;  ///< traces of one test have one place of the ball
  CircleSpec spec;   ///< radius, normal and first axis count
  CircleTrace trace;
};

struct Volumetric {
  /// X, Y, Z: (distance driven - distance commanded) / distance commanded along the axis. All three hold an
  /// error of the bar's length alike; their differences do not.
  std::array<Estimate, 3> scaling;
  /// XY, YZ, ZX [rad]: by how much the angle between the two axes is more than 90 degrees.
  std::array<Estimate, 3> squareness;
  double residual = 0.0;  ///< [m] rms of what these six, the balls' places and the directions leave
};

inline constexpr std::array<const char*, 3> kAxes{"x", "y", "z"};
inline constexpr std::array<const char*, 3> kAxisPairs{"xy", "yz", "zx"};

/// Linear least squares over all traces: with u the unit vector to the commanded point, u = (x, y, z),
///   dR = R (a_x x^2 + a_y y^2 + a_z z^2 - b_xy x y - b_yz y z - b_zx z x)
/// in a plane XY that is R (a_x + a_y) / 2 + R (a_x - a_y) / 2 cos 2theta - R b_xy / 2 sin 2theta, the mean,
/// scaling mismatch and squareness of metrology.md 1.2. Each test has a ball's place of its own, and what
/// changes sign with the direction up to order 2 (servo mismatch, and of backlash and lateral play that part)
/// is taken out, so a test counts only where it was driven both ways. A rigid turn is not seen. A ball that
/// stands out of the plane by e reads as scaling of e^2 / 2R^2, 2 um/m for 0.3 mm at 150 mm. On a robot
/// these are shapes of the volume about the ball: it has no X, Y and Z slides.
///
/// Standard deviations are those of the residual, its correlation along a trace counted, as of one trace each
/// way and plane: what the model leaves repeats with every repetition, so these do not narrow it.
///
/// @param traces  of balls of one set-up; repetitions and arcs of any length that carry their centre
/// @return nothing where the planes with both directions do not tell all six apart: there must be three
/// @throws std::invalid_argument as plane_of, driven_path, and for a direction that is not +1 or -1
std::optional<Volumetric> analyse_volumetric(const std::vector<PlaneTrace>& traces);

/// The plane that has this plane_name(), where its normal and first axis are axes of the base frame, with a
/// radius and nothing else. Nothing for other names.
std::optional<CircleSpec> plane_named(const std::string& name, double radius);

}  // namespace ballbar
