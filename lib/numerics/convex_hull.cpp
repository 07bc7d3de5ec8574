#include "numerics/convex_hull.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>
#include <queue>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix2Xd;
using Eigen::Vector2d;

/// A corner of what is left of a convex polygon, by the circle through it and its neighbours.
struct Corner {
  double radius = 0.0;
  double straightness = 0.0;  ///< minus the cosine of the angle at the corner
  std::size_t at = 0;
  unsigned version = 0;
  bool operator<(const Corner& other) const {
    return radius != other.radius ? radius < other.radius : straightness < other.straightness;
  }
};

}  // namespace

std::optional<Circle> circle_through(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  const Vector2d ab = b - a;
  const Vector2d ac = c - a;
  const double twice_area = cross(ab, ac);
  if (twice_area == 0.0) return std::nullopt;
  const double p = ab.squaredNorm();
  const double q = ac.squaredNorm();
  const Vector2d arm = Vector2d(ac.y() * p - ab.y() * q, ab.x() * q - ac.x() * p) / (2.0 * twice_area);
  if (!arm.allFinite()) return std::nullopt;
  return Circle{a + arm, arm.norm()};
}

std::vector<Index> convex_hull(const Matrix2Xd& points) {
  std::vector<Index> sorted(static_cast<std::size_t>(points.cols()));
  std::iota(sorted.begin(), sorted.end(), Index{0});
  std::sort(sorted.begin(), sorted.end(), [&](Index a, Index b) {
    return points(0, a) != points(0, b) ? points(0, a) < points(0, b) : points(1, a) < points(1, b);
  });
  std::vector<Index> hull;
  const auto add = [&](Index next, std::size_t floor) {
    while (hull.size() >= floor + 2) {
      const Vector2d last = points.col(hull.back());
      const Vector2d before = points.col(hull[hull.size() - 2]);
      if (cross(last - before, points.col(next) - last) > 0.0) break;
      hull.pop_back();
    }
    hull.push_back(next);
  };
  for (const Index i : sorted) add(i, 0);
  const std::size_t lower = hull.size() - 1;
  for (auto i = sorted.rbegin() + 1; i != sorted.rend(); ++i) add(*i, lower);
  hull.pop_back();
  return hull;
}

std::vector<Triangle> farthest_triangles(const Matrix2Xd& points, const std::vector<Index>& hull) {
  const std::size_t n = hull.size();
  std::vector<std::size_t> before(n);
  std::vector<std::size_t> after(n);
  for (std::size_t i = 0; i < n; ++i) {
    before[i] = (i + n - 1) % n;
    after[i] = (i + 1) % n;
  }
  std::vector<unsigned> version(n, 0);
  std::priority_queue<Corner> corners;
  const auto push = [&](std::size_t i) {
    const Vector2d p = points.col(hull[i]);
    const Vector2d back = points.col(hull[before[i]]) - p;
    const Vector2d on = points.col(hull[after[i]]) - p;
    const auto circle = circle_through(p, p + back, p + on);
    const double radius = circle ? circle->radius : std::numeric_limits<double>::infinity();
    corners.push({radius, -back.dot(on) / (back.norm() * on.norm()), i, version[i]});
  };
  for (std::size_t i = 0; i < n; ++i) push(i);
  std::vector<Triangle> found;
  for (std::size_t left = n; left > 2;) {
    const Corner corner = corners.top();
    corners.pop();
    if (corner.version != version[corner.at]) continue;
    const std::size_t back = before[corner.at];
    const std::size_t on = after[corner.at];
    found.push_back({hull[back], hull[corner.at], hull[on]});
    ++version[corner.at];
    after[back] = on;
    before[on] = back;
    for (const std::size_t i : {back, on}) {
      ++version[i];
      push(i);
    }
    --left;
  }
  return found;
}

}  // namespace ballbar
