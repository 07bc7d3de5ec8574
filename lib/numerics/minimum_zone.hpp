#pragma once
/// The narrowest zone that holds all points: between two concentric circles, or between two parallel lines.

#include <Eigen/Core>

#include "numerics/circle_fit.hpp"
#include "numerics/fit_status.hpp"

namespace ballbar {

struct MinimumZoneCircle {
  FitStatus status = FitStatus::kTooFewPoints;
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();  ///< [unit of the points]
  double outer_radius = 0.0;                         ///< [unit of the points]
  double inner_radius = 0.0;                         ///< [unit of the points]
  double width = 0.0;                                ///< outer - inner
};

/// The least radial separation of two concentric circles that hold all points between them, of all centres of
/// the plane (metrology.md 2, "MZC").
///
/// A minimum touches the outer circle in two points and the inner one in two, alternating around the centre.
/// The nearest is found by exact linear minimax problems (exchange of the reference points, O(n) each) about
/// a centre that moves until the condition holds. Then all other centres are excluded by bounds; where they
/// cannot be, minimum_zone_circle_everywhere() tells. Status as fit_circle; kIllConditioned too where two
/// parallel lines are no farther apart than any two such circles: the points lie nearer to a line.
/// @param points  2 x n
/// @throws std::invalid_argument where a coordinate is not finite
MinimumZoneCircle minimum_zone_circle(const Eigen::Matrix2Xd& points);

/// The same, where fit_circle(points) is known already.
MinimumZoneCircle minimum_zone_circle(const Eigen::Matrix2Xd& points, const CircleFit& circle);

/// The same by trying every centre that can be a minimum, without bounds or iteration: those where a side of
/// the farthest-point Voronoi diagram crosses one of the nearest-point diagram (Ebara et al. 1989). Along a
/// side of the first the second is a lower envelope of straight lines. O(h n m), h corners of the convex
/// hull, m points that are nearest to some point of a side.
/// @param points  2 x n
/// @throws std::invalid_argument where a coordinate is not finite
MinimumZoneCircle minimum_zone_circle_everywhere(const Eigen::Matrix2Xd& points);

struct MinimumZoneLine {
  FitStatus status = FitStatus::kTooFewPoints;
  double slope = 0.0;      ///< [unit of y per unit of x]
  double intercept = 0.0;  ///< [unit of y] of the middle of the zone, at x = 0
  double width = 0.0;      ///< [unit of y] along y
};

/// The least width along y of a strip that holds all points: exact, by convex hull and calipers (metrology.md
/// 2, "MZS"). kTooFewPoints below two points, kIllConditioned where all x are alike.
/// @param x,y  n values each, any sequence
/// @throws std::invalid_argument where the sizes differ or a value is not finite
MinimumZoneLine minimum_zone_line(const Eigen::VectorXd& x, const Eigen::VectorXd& y);

}  // namespace ballbar
