#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <optional>
#include <stdexcept>
#include <vector>

#include "numerics/convex_hull.hpp"
#include "numerics/minimum_zone.hpp"

// In units of the set's size, about its mean.

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix2Xd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kInfinite = std::numeric_limits<double>::infinity();
constexpr double kRoundingOfStrip = 1e-13;

using Side = std::array<Index, 2>;

/// Each side of the triangles once.
std::vector<Side> sides_of(const std::vector<Triangle>& triangles) {
  std::vector<Side> sides;
  for (const Triangle& t : triangles)
    for (std::size_t k = 0; k < 3; ++k) {
      const auto [a, b] = std::minmax(t[k], t[(k + 1) % 3]);
      sides.push_back({a, b});
    }
  std::sort(sides.begin(), sides.end());
  sides.erase(std::unique(sides.begin(), sides.end()), sides.end());
  return sides;
}

/// The perpendicular bisector of two points: centre(t) = middle + t normal. A point whose foot is `along` and
/// whose distance from the middle is d lies at the squared distance t^2 + d^2 - 2 t along from the centre.
struct Bisector {
  Vector2d middle, normal;
  double half_squared = 0.0;  ///< squared half of the distance between the two
  double begin = -kInfinite;  ///< the part on which no other point is farther than the two
  double end = kInfinite;
};

/// Nothing where another point is farther everywhere, or but for rounding.
std::optional<Bisector> bisector_of(const Matrix2Xd& points, const std::vector<Index>& hull,
                                    const Side& side) {
  const Vector2d a = points.col(side[0]);
  const Vector2d b = points.col(side[1]);
  Bisector line;
  line.middle = (a + b) / 2.0;
  line.normal = Vector2d(a.y() - b.y(), b.x() - a.x()).normalized();
  line.half_squared = (b - a).squaredNorm() / 4.0;
  for (const Index i : hull) {
    if (i == side[0] || i == side[1]) continue;
    const Vector2d p = points.col(i) - line.middle;
    const double along = p.dot(line.normal);
    const double outside = p.squaredNorm() - line.half_squared;
    if (along == 0.0 && outside > 0.0) return std::nullopt;
    const double bound = outside / (2.0 * along);
    if (along > 0.0) line.begin = std::max(line.begin, bound);
    if (along < 0.0) line.end = std::min(line.end, bound);
  }
  if (std::isinf(line.begin)) {  // all others on the other side: look that way
    line.normal = -line.normal;
    line.begin = -line.end;
    line.end = kInfinite;
  }
  return line.begin <= line.end ? std::optional(line) : std::nullopt;
}

struct Candidate {
  Vector2d centre = Vector2d::Zero();
  double width = kInfinite;
};

/// The least width of a centre on the bisector at which another point becomes the nearest, or at an end: in
/// between the width has no minimum. And what the width comes to as the centre goes away for ever.
struct AlongBisector {
  Candidate least;
  double far_away = kInfinite;
};

AlongBisector search(const Matrix2Xd& points, const Bisector& line) {
  const Matrix2Xd from_middle = points.colwise() - line.middle;
  const VectorXd along = from_middle.transpose() * line.normal;
  const VectorXd squared = from_middle.colwise().squaredNorm();
  AlongBisector found;
  const auto consider = [&](double t, Index nearest) {
    const double outer = std::sqrt(t * t + line.half_squared);
    const double inner = std::sqrt(std::max(0.0, t * t + squared[nearest] - 2.0 * t * along[nearest]));
    // Not outer - inner, of which little is left when both are large.
    const double width = (line.half_squared - squared[nearest] + 2.0 * t * along[nearest]) / (outer + inner);
    if (width < found.least.width) found.least = {line.middle + t * line.normal, width};
  };

  double t = line.begin;
  Index nearest = 0;
  (squared - 2.0 * t * along).minCoeff(&nearest);
  consider(t, nearest);
  for (;;) {
    // The next to be the nearest has its foot farther on.
    double next = kInfinite;
    Index by = -1;
    for (Index i = 0; i < along.size(); ++i) {
      if (!(along[i] > along[nearest])) continue;
      const double meets = (squared[i] - squared[nearest]) / (2.0 * (along[i] - along[nearest]));
      if (meets > next || (meets == next && along[i] <= along[by])) continue;
      next = meets;
      by = i;
    }
    if (by < 0 || next >= line.end) break;
    t = std::max(t, next);
    nearest = by;
    consider(t, nearest);
  }
  if (std::isinf(line.end))
    found.far_away = along.maxCoeff();
  else
    consider(line.end, nearest);
  return found;
}

}  // namespace

MinimumZoneCircle minimum_zone_circle_everywhere(const Matrix2Xd& points) {
  if (!points.allFinite()) throw std::invalid_argument("circle: a coordinate is not finite");
  MinimumZoneCircle zone;
  if (points.cols() < 3) return zone;
  zone.status = FitStatus::kIllConditioned;
  const Vector2d mean = points.rowwise().mean();
  const double size = (points.colwise() - mean).colwise().norm().maxCoeff();
  if (!(size > 0.0)) return zone;
  const Matrix2Xd scaled = (points.colwise() - mean) / size;
  const std::vector<Index> hull = convex_hull(scaled);
  if (hull.size() < 3) return zone;

  Candidate best;
  double strip = kInfinite;
  for (const Side& side : sides_of(farthest_triangles(scaled, hull))) {
    const std::optional<Bisector> line = bisector_of(scaled, hull, side);
    if (!line) continue;
    const AlongBisector found = search(scaled, *line);
    if (found.least.width < best.width) best = found.least;
    strip = std::min(strip, found.far_away);
  }
  if (strip <= best.width + kRoundingOfStrip) return zone;

  zone.status = FitStatus::kOk;
  zone.centre = mean + size * best.centre;
  const VectorXd distance = (scaled.colwise() - best.centre).colwise().norm();
  zone.width = size * best.width;
  zone.outer_radius = size * distance.maxCoeff();
  zone.inner_radius = zone.outer_radius - zone.width;
  return zone;
}

}  // namespace ballbar
