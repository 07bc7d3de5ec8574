#pragma once
/// The convex hull of points in a plane, and which of its corners are farthest where.

#include <Eigen/Core>
#include <array>
#include <optional>
#include <vector>

namespace ballbar {

struct Circle {
  Eigen::Vector2d centre = Eigen::Vector2d::Zero();
  double radius = 0.0;
};

/// > 0 where b lies counter-clockwise of a.
inline double cross(const Eigen::Vector2d& a, const Eigen::Vector2d& b) {
  return a.x() * b.y() - a.y() * b.x();
}

/// The circle through three points; nothing where they lie on a line.
std::optional<Circle> circle_through(const Eigen::Vector2d& a, const Eigen::Vector2d& b,
                                     const Eigen::Vector2d& c);

/// Corners of the convex hull, counter-clockwise, none on a side (Andrew's chain).
/// @param points  2 x n, n >= 1
std::vector<Eigen::Index> convex_hull(const Eigen::Matrix2Xd& points);

using Triangle = std::array<Eigen::Index, 3>;

/// All triangles of corners of a convex polygon whose circumcircles hold the polygon: their centres are the
/// corners of the farthest-point Voronoi diagram, their sides its sides. The corner with the largest circle
/// through itself and its neighbours makes one with them, and the others are those of the polygon without it
/// (Skyum 1991, O(h log h)).
/// @param points  2 x n
/// @param hull    of the points, as convex_hull() gives it
std::vector<Triangle> farthest_triangles(const Eigen::Matrix2Xd& points,
                                         const std::vector<Eigen::Index>& hull);

}  // namespace ballbar
