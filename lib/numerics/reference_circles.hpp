#pragma once
/// The two one-sided reference circles of ISO 12181, and roundness about any reference circle. The two-sided
/// ones are fit_circle (least squares) and minimum_zone_circle.

#include <Eigen/Core>

#include "numerics/circle_fit.hpp"
#include "numerics/fit_status.hpp"

namespace ballbar {

struct ReferenceCircle {
  FitStatus status = FitStatus::kTooFewPoints;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< [unit of the points]
  double radius = 0.0;                               ///< [unit of the points]
};

/// The smallest circle that holds all points (metrology.md 2, "MCC"). Always defined, for points on a line
/// too. Exact: the point that lies farthest outside joins the two or three that carry the circle; the circle
/// grows with every exchange, so there is an end. kTooFewPoints below two.
/// @param points  2 x n
/// @throws std::invalid_argument where a coordinate is not finite
ReferenceCircle minimum_circumscribed_circle(const Eigen::Matrix2Xd& points);

/// The largest circle that holds no point, rests on three points all around it (its centre in the closed
/// triangle of them), and surrounds the least-squares centre (metrology.md 2, "MIC"): of a trace that is
/// roughly round, the largest plug gauge that fits inside. Without the second condition no circle would be
/// the largest; without the third it could be any gap between neighbouring points.
///
/// Exact: inversion about the least-squares centre makes these circles those through three points that hold
/// all others, which are found all at once (farthest-point Voronoi diagram of the convex hull, Skyum 1991,
/// O(n log n)). Status as fit_circle; kIllConditioned too where the points do not surround the least-squares
/// centre (an arc of half a turn or less), or no such circle rests on three points.
/// @param points  2 x n
/// @throws std::invalid_argument where a coordinate is not finite
ReferenceCircle maximum_inscribed_circle(const Eigen::Matrix2Xd& points);

/// The same, where fit_circle(points) is known already.
ReferenceCircle maximum_inscribed_circle(const Eigen::Matrix2Xd& points, const CircleFit& fitted);

/// Roundness of points about a reference circle (ISO 12181; the names are the standard's, RONt, RONp, RONv,
/// RONq).
struct Roundness {
  double total = 0.0;   ///< peak + valley = largest - smallest distance from the centre
  double peak = 0.0;    ///< largest distance from the centre - radius
  double valley = 0.0;  ///< radius - smallest distance from the centre
  double rms = 0.0;     ///< root mean square of (distance - radius), every point counting alike
};

/// All zero for no points.
Roundness roundness_about(const Eigen::Matrix2Xd& points, const Eigen::Vector2d& centre, double radius);

}  // namespace ballbar
