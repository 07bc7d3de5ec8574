#pragma once
/// Angles of a circle's samples, and which of them lie on the measured arc.

#include <Eigen/Core>
#include <cstddef>
#include <optional>
#include <string>

#include "core/spec.hpp"
#include "core/units.hpp"

namespace ballbar {

/// A path that is further from the configured circle, or goes back further, is not this test.
inline constexpr double kOffPath = 3e-3;                  ///< [m] across, along the normal, and of the radius
inline constexpr double kBackwards = 5.0 * kRadPerDeg;    ///< within the arc: it is driven once, one way
inline constexpr double kLargestHole = 5.0 * kRadPerDeg;  ///< of the arc without a sample
inline constexpr double kLongestJointGap = 0.25;          ///< [s] over wider holes in JOINTS nothing is known

/// The plane of a circle, right-handed: e2 = normal x e1. Angle 0 lies on e1, + is counter-clockwise about
/// the normal.
struct CirclePlane {
  Eigen::Vector3d centre;  ///< [m] in the robot's base frame
  Eigen::Vector3d normal;  ///< unit
  Eigen::Vector3d e1;      ///< unit: first_axis made orthogonal to the normal
  Eigen::Vector3d e2;      ///< unit
};

/// @throws std::invalid_argument where the normal is zero or first_axis lies along it
CirclePlane plane_of(const CircleSpec& spec);

/// The plane as ISO names it where it is one of the base frame's: "XY" (normal +Z, angle 0 on +X), "YZ" (+X,
/// +Y), "ZX" (+Y, +Z); "ZX, normal Y, angle 0 on X" for another sense or first axis; else "normal (0.6, 0,
/// 0.8), angle 0 on Y". Three decimals.
/// @throws std::invalid_argument as plane_of
std::string plane_name(const CircleSpec& spec);

/// atan2((p-c).e2, (p-c).e1) of each point, without jumps: each angle is less than half a turn from the one
/// before. Source: design.md 3.
/// @param points  3 x n, [m] tool points in the base frame; columns that are not finite are points not known
/// @return n angles [rad]; NaN where the point is not known
Eigen::VectorXd angles_on_circle(const Eigen::Matrix3Xd& points, const CircleSpec& spec);

/// The bar alone: angle rises (or falls) with time at feed / radius, the middle of the run on the middle of
/// the arc. The marks lie about equally far outside the motion on both sides, so the middle is the safest
/// point of a run. Where feed is 0, or would need a time for arc and overshoots that differs from the run's
/// by more than a tenth, the rate comes from the run's own duration.
/// @param time       [s] of each bar sample
/// @param begin,end  [s] of the run, on the same clock
/// @param direction  +1 or -1
/// @param feed       [m/s] programmed, 0 = not known
/// @return one angle per time [rad]; all NaN where direction is 0 or the run has no duration
Eigen::VectorXd angles_at_constant_feed(const Eigen::VectorXd& time, double begin, double end,
                                        const CircleSpec& spec, int direction, double feed);

/// Mean speed of a motion round the circle: arc length over the time between its ends, those of the first and
/// the last angle that is known. Ballbar 20's calculated feed rate.
/// @param angle  n values [rad], without jumps; NaN where not known
/// @param time   n values [s]
/// @return [m/s]; nothing where fewer than two angles are known or no time passes between them
/// @throws std::invalid_argument for other sizes
std::optional<double> calculated_feed(const Eigen::VectorXd& angle, const Eigen::VectorXd& time,
                                      double radius);

/// The samples [begin, end) on the measured arc [arc_start, arc_start + arc_sweep), and how well they cover
/// it.
struct Arc {
  std::size_t begin = 0;
  std::size_t end = 0;
  double coverage = 0.0;  ///< share of the sweep, 0..1, without the holes wider than five usual steps (and
                          ///< 1/360 of the sweep)
  double largest_hole = 0.0;  ///< [rad] widest part of the arc without a sample, its ends included
};

/// Finds the measured arc in a run of either direction, and shifts the angles by the multiple of a turn that
/// brings the middle of the driven path nearest to the middle of the arc. Both ends of the arc count a
/// hundredth of a mean step earlier, so that of two samples a turn apart on the ends of a full circle exactly
/// one is taken, in either direction.
/// @param angle  [rad] of consecutive samples, without jumps; NaN before and after where not known. Shifted
/// in place
Arc find_arc(Eigen::Ref<Eigen::VectorXd> angle, const CircleSpec& spec);

}  // namespace ballbar
