#include "numerics/reference_circles.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <stdexcept>
#include <vector>

#include "numerics/convex_hull.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix2Xd;
using Eigen::Vector2d;
using Eigen::VectorXd;

constexpr double kRoundingOfRadius = 1e-14;  // of a radius
constexpr double kOnSide = 1e-9;  // of a triangle's height: a centre this far outside counts as on the side

Circle circle_on_diameter(const Vector2d& a, const Vector2d& b) {
  return {(a + b) / 2.0, (b - a).norm() / 2.0};
}

/// How far the farthest of the points lies outside the circle.
double excess(const Circle& circle, const std::vector<Vector2d>& points) {
  double most = -std::numeric_limits<double>::infinity();
  for (const Vector2d& p : points) most = std::max(most, (p - circle.centre).norm() - circle.radius);
  return most;
}

/// The smallest circle of at most three points and one more that lies outside theirs, and the points that
/// carry it.
struct Carried {
  Circle circle;
  std::vector<Vector2d> by;
};

/// Of all circles through the new point and one or two of the others, the smallest that holds all.
Carried carried_by(const std::vector<Vector2d>& others, const Vector2d& added, double size) {
  std::vector<Vector2d> all = others;
  all.push_back(added);
  std::vector<Carried> candidates;
  for (std::size_t i = 0; i < others.size(); ++i) {
    candidates.push_back({circle_on_diameter(others[i], added), {others[i], added}});
    for (std::size_t j = i + 1; j < others.size(); ++j)
      if (const auto circle = circle_through(others[i], others[j], added))
        candidates.push_back({*circle, {others[i], others[j], added}});
  }
  const Carried* best = nullptr;
  for (const Carried& candidate : candidates) {
    if (excess(candidate.circle, all) > 10.0 * kRoundingOfRadius * (size + candidate.circle.radius)) continue;
    if (!best || candidate.circle.radius < best->circle.radius) best = &candidate;
  }
  return best ? *best : Carried{};
}

/// The circle through the corners of a triangle, where its centre lies in the closed triangle.
std::optional<Circle> resting_on(const Vector2d& a, const Vector2d& b, const Vector2d& c) {
  const auto circle = circle_through(a, b, c);
  if (!circle) return std::nullopt;
  const double twice_area = cross(b - a, c - a);
  const Vector2d& m = circle->centre;
  const double least = std::min({cross(b - a, m - a), cross(c - b, m - b), cross(a - c, m - c)},
                                [&](double x, double y) { return x / twice_area < y / twice_area; });
  return least / twice_area >= -kOnSide ? circle : std::nullopt;
}

bool surrounded(const Matrix2Xd& points, const std::vector<Index>& hull) {
  if (hull.size() < 3) return false;
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vector2d a = points.col(hull[i]);
    const Vector2d b = points.col(hull[(i + 1) % hull.size()]);
    if (!(cross(a, b) > kRoundingOfRadius * (b - a).norm())) return false;
  }
  return true;
}

/// The largest resting circle of all points, about the origin inside; nothing where there is none.
std::optional<Circle> largest_resting(const Matrix2Xd& points) {
  const VectorXd squared = points.colwise().squaredNorm();
  if (!(squared.minCoeff() > kRoundingOfRadius * kRoundingOfRadius)) return std::nullopt;
  const Matrix2Xd inverted = points * squared.cwiseInverse().asDiagonal();
  const std::vector<Index> hull = convex_hull(inverted);
  if (!surrounded(inverted, hull)) return std::nullopt;

  std::vector<Circle> circles;
  for (const Triangle& t : farthest_triangles(inverted, hull))
    if (const auto circle = resting_on(points.col(t[0]), points.col(t[1]), points.col(t[2])))
      circles.push_back(*circle);
  std::sort(circles.begin(), circles.end(),
            [](const Circle& a, const Circle& b) { return a.radius > b.radius; });
  std::optional<Circle> best;
  for (const Circle& circle : circles) {
    if (best && circle.radius <= best->radius) break;  // none that follows is larger
    const double clear = (points.colwise() - circle.centre).colwise().norm().minCoeff();
    if (!best || clear > best->radius) best = Circle{circle.centre, clear};
  }
  return best;
}

/// Whether the points lie all around the origin, in each twelfth of a turn.
bool all_around(const Matrix2Xd& points) {
  constexpr int kSectors = 12;
  std::array<bool, kSectors> seen{};
  for (const auto& p : points.colwise()) {
    const double share = std::atan2(p.y(), p.x()) / (2.0 * std::numbers::pi) + 0.5;
    seen[static_cast<std::size_t>(std::min(kSectors - 1, static_cast<int>(share * kSectors)))] = true;
  }
  return std::find(seen.begin(), seen.end(), false) == seen.end();
}

/// The same of many points that are roughly round, from the few that matter: the largest circle of a choice
/// of them is an upper bound; where others lie in it, the nearest of each stretch joins the choice. At the
/// end no point lies in it, and it is the largest of all.
///
/// That the choice's circle bounds the others needs that no circle grows out of the origin: one of which the
/// origin is on the rim is, with points in each twelfth of a turn, smaller than rmax / (2 cos 30 deg).
/// Nothing where that does not hold, or the exchange does not come to its end.
std::optional<Circle> largest_resting_of_many(const Matrix2Xd& points) {
  constexpr Index kStretchesOfCircle = 180;
  constexpr double kRound = 0.7;  // of the largest distance
  constexpr int kMostExchanges = 100;
  constexpr double kClear = 1e-12;  // of a radius: what rounding leaves of a point on the rim
  const VectorXd distance = points.colwise().norm();
  if (distance.minCoeff() < kRound * distance.maxCoeff()) return std::nullopt;
  const Index stretch = (points.cols() + kStretchesOfCircle - 1) / kStretchesOfCircle;
  std::vector<Index> chosen;
  const auto choose = [&](const VectorXd& from_centre, double within) {
    const std::size_t before = chosen.size();
    for (Index begin = 0; begin < points.cols(); begin += stretch) {
      Index nearest = 0;
      const Index count = std::min(stretch, points.cols() - begin);
      if (from_centre.segment(begin, count).minCoeff(&nearest) < within) chosen.push_back(begin + nearest);
    }
    return chosen.size() > before;
  };
  choose(distance, std::numeric_limits<double>::infinity());
  if (!all_around(points(Eigen::all, chosen))) return std::nullopt;
  for (int count = 0; count < kMostExchanges; ++count) {
    const Matrix2Xd few = points(Eigen::all, chosen);
    const std::optional<Circle> circle = largest_resting(few);
    if (!circle) return std::nullopt;
    const VectorXd from_centre = (points.colwise() - circle->centre).colwise().norm();
    if (!choose(from_centre, circle->radius - kClear)) return Circle{circle->centre, from_centre.minCoeff()};
  }
  return std::nullopt;
}

}  // namespace

ReferenceCircle minimum_circumscribed_circle(const Matrix2Xd& points) {
  if (!points.allFinite()) throw std::invalid_argument("circle: a coordinate is not finite");
  ReferenceCircle result;
  if (points.cols() < 2) return result;
  result.status = FitStatus::kOk;
  const Vector2d middle = points.rowwise().mean();
  const Matrix2Xd about = points.colwise() - middle;
  const double size = about.colwise().norm().maxCoeff();
  Carried carried{{about.col(0), 0.0}, {about.col(0)}};
  for (;;) {
    Index far = 0;
    const double distance = (about.colwise() - carried.circle.centre).colwise().norm().maxCoeff(&far);
    if (distance <= carried.circle.radius + kRoundingOfRadius * size) break;
    Carried next = carried_by(carried.by, about.col(far), size);
    if (!(next.circle.radius > carried.circle.radius)) break;  // rounding: nothing outside is left to gain
    carried = std::move(next);
  }
  result.centre = middle + carried.circle.centre;
  result.radius = (about.colwise() - carried.circle.centre).colwise().norm().maxCoeff();
  return result;
}

ReferenceCircle maximum_inscribed_circle(const Matrix2Xd& points) {
  return maximum_inscribed_circle(points, fit_circle(points));
}

ReferenceCircle maximum_inscribed_circle(const Matrix2Xd& points, const CircleFit& fitted) {
  ReferenceCircle result;
  result.status = fitted.status;
  if (fitted.status != FitStatus::kOk) return result;
  result.status = FitStatus::kIllConditioned;
  const Matrix2Xd scaled = (points.colwise() - fitted.centre) / fitted.radius;
  constexpr Index kMany = 2000;
  std::optional<Circle> largest;
  if (scaled.cols() > kMany) largest = largest_resting_of_many(scaled);
  if (!largest) largest = largest_resting(scaled);
  if (!largest) return result;
  result.status = FitStatus::kOk;
  result.centre = fitted.centre + fitted.radius * largest->centre;
  result.radius = fitted.radius * largest->radius;
  return result;
}

Roundness roundness_about(const Matrix2Xd& points, const Vector2d& centre, double radius) {
  Roundness roundness;
  if (points.cols() == 0) return roundness;
  const VectorXd deviation = (points.colwise() - centre).colwise().norm().transpose().array() - radius;
  roundness.peak = deviation.maxCoeff();
  roundness.valley = -deviation.minCoeff();
  roundness.total = roundness.peak + roundness.valley;
  roundness.rms = std::sqrt(deviation.squaredNorm() / static_cast<double>(points.cols()));
  return roundness;
}

}  // namespace ballbar
