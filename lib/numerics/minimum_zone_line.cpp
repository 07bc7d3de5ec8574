#include <algorithm>
#include <cstddef>
#include <stdexcept>
#include <vector>

#include "numerics/minimum_zone.hpp"

namespace ballbar {
namespace {

using Eigen::Vector2d;
using Eigen::VectorXd;

double cross(const Vector2d& a, const Vector2d& b) { return a.x() * b.y() - a.y() * b.x(); }

/// Andrew's monotone chain, one side: side = +1 gives the upper hull, -1 the lower one; by rising x.
std::vector<Vector2d> hull(const std::vector<Vector2d>& sorted, double side) {
  std::vector<Vector2d> chain;
  for (const Vector2d& p : sorted) {
    if (!chain.empty() && chain.back().x() == p.x()) {
      if (side * (p.y() - chain.back().y()) <= 0.0) continue;
      chain.pop_back();
    }
    while (chain.size() >= 2 &&
           side * cross(chain.back() - chain[chain.size() - 2], p - chain[chain.size() - 2]) >= 0.0)
      chain.pop_back();
    chain.push_back(p);
  }
  return chain;
}

double slope_between(const Vector2d& a, const Vector2d& b) { return (b.y() - a.y()) / (b.x() - a.x()); }

}  // namespace

MinimumZoneLine minimum_zone_line(const VectorXd& x, const VectorXd& y) {
  if (x.size() != y.size()) throw std::invalid_argument("minimum zone: x and y differ in number");
  if (!x.allFinite() || !y.allFinite()) throw std::invalid_argument("minimum zone: a value is not finite");
  MinimumZoneLine zone;
  if (x.size() < 2) return zone;
  zone.status = FitStatus::kIllConditioned;
  if (x.minCoeff() == x.maxCoeff()) return zone;

  std::vector<Vector2d> points;
  points.reserve(static_cast<std::size_t>(x.size()));
  for (Eigen::Index i = 0; i < x.size(); ++i) points.emplace_back(x[i], y[i]);
  std::sort(points.begin(), points.end(), [](const Vector2d& a, const Vector2d& b) {
    return a.x() != b.x() ? a.x() < b.x() : a.y() < b.y();
  });
  const std::vector<Vector2d> upper = hull(points, 1.0);
  const std::vector<Vector2d> lower = hull(points, -1.0);

  // The width max(y - m x) - min(y - m x) is convex in the slope m. As m rises from -infinity the touching
  // point above moves from the right end to the left, the one below from left to right; the width falls until
  // they pass each other.
  std::size_t above = upper.size() - 1;
  std::size_t below = 0;
  while (lower[below].x() < upper[above].x()) {
    const bool move_above =
        below + 1 == lower.size() || (above > 0 && slope_between(upper[above - 1], upper[above]) <=
                                                       slope_between(lower[below], lower[below + 1]));
    if (move_above) {
      zone.slope = slope_between(upper[above - 1], upper[above]);
      --above;
    } else {
      zone.slope = slope_between(lower[below], lower[below + 1]);
      ++below;
    }
  }
  const VectorXd deviation = y - zone.slope * x;
  zone.status = FitStatus::kOk;
  zone.width = deviation.maxCoeff() - deviation.minCoeff();
  zone.intercept = (deviation.maxCoeff() + deviation.minCoeff()) / 2.0;
  return zone;
}

}  // namespace ballbar
