#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <optional>
#include <vector>

#include "numerics/convex_hull.hpp"
#include "numerics/minimum_zone.hpp"

// All in units of the least-squares radius, about the least-squares centre.

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix2Xd;
using Eigen::Matrix3d;
using Eigen::Vector2d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kRoundingOfDistance = 1e-14;  // of a distance
constexpr double kStationary = 1e-12;          // of a width that no small step lowers
constexpr double kReach = 4.0;                 // half the side of the square in which the proof searches
constexpr int kMostBoxes = 20000;
constexpr Index kMostWitnesses = 64;
constexpr Index kStretches = 150;

struct Extremes {
  Index far = 0;
  Index near = 0;
  double outer = 0.0;
  double inner = 0.0;
  double width() const { return outer - inner; }
};

Extremes extremes_about(const Matrix2Xd& points, const Vector2d& centre) {
  Extremes found;
  const VectorXd distance = (points.colwise() - centre).colwise().norm();
  // Value first, place second: each pass by itself is several times faster than one for both.
  found.outer = distance.maxCoeff();
  found.inner = distance.minCoeff();
  found.far = std::find(distance.begin(), distance.end(), found.outer) - distance.begin();
  found.near = std::find(distance.begin(), distance.end(), found.inner) - distance.begin();
  return found;
}

/// A lower bound of the linearised width after a move: height - slope . move. Of one pair of points, or of
/// the trust region.
struct Cut {
  Vector2d slope = Vector2d::Zero();
  double height = 0.0;
  Index far = -1;  ///< -1: trust region
  Index near = -1;
};

/// The least linearised width, reached after `move`, and the three cuts that hold it there.
struct LinearMinimum {
  Vector2d move = Vector2d::Zero();
  double width = 0.0;
  std::array<Cut, 3> cuts;
};

/// Meets three cuts in one point. False where they do not bound the width from below (the origin is outside
/// the triangle of their slopes).
bool meet(LinearMinimum& at) {
  Matrix3d rows;
  Vector3d heights;
  for (int k = 0; k < 3; ++k) {
    const Cut& cut = at.cuts[static_cast<std::size_t>(k)];
    rows.row(k) << 1.0, cut.slope.x(), cut.slope.y();
    heights[k] = cut.height;
  }
  const Eigen::FullPivLU<Matrix3d> lu(rows);
  if (!lu.isInvertible()) return false;
  const Vector3d weights = lu.inverse().transpose() * Vector3d::UnitX();  // sum 1, sum of weight x slope 0
  if (weights.minCoeff() < -kRoundingOfDistance) return false;
  const Vector3d solution = lu.solve(heights);
  at.width = solution[0];
  at.move = solution.tail<2>();
  return true;
}

/// Brings in a cut that the present minimum violates; one of the three goes. The width never falls.
bool exchange(LinearMinimum& at, const Cut& cut) {
  std::optional<LinearMinimum> best;
  for (std::size_t out = 0; out < 3; ++out) {
    LinearMinimum candidate = at;
    candidate.cuts[out] = cut;
    if (meet(candidate) && (!best || candidate.width > best->width)) best = candidate;
  }
  if (best) at = *best;
  return best.has_value();
}

/// Minimises max(d - u.move) - min(d - u.move), exactly: the dual simplex method with three cuts.
LinearMinimum linear_minimum(const Matrix2Xd& points, const Vector2d& centre, double trust) {
  constexpr double kSteep = 10.0;  // steeper than any pair (2)
  Matrix2Xd direction = points.colwise() - centre;
  const VectorXd distance = direction.colwise().norm();
  for (Index i = 0; i < points.cols(); ++i)
    if (distance[i] > 0.0) direction.col(i) /= distance[i];

  LinearMinimum at;
  for (int k = 0; k < 3; ++k) {
    const double angle = 2.0 * std::numbers::pi * k / 3.0;
    at.cuts[static_cast<std::size_t>(k)] = {-kSteep * Vector2d(std::cos(angle), std::sin(angle)),
                                            -kSteep * trust, -1, -1};
  }
  meet(at);
  for (int rounds = 0; rounds < 1000; ++rounds) {
    const VectorXd after = distance - direction.transpose() * at.move;
    Cut cut;
    const double width = after.maxCoeff(&cut.far) - after.minCoeff(&cut.near);
    if (width <= at.width + kRoundingOfDistance) break;
    cut.slope = direction.col(cut.far) - direction.col(cut.near);
    cut.height = distance[cut.far] - distance[cut.near];
    if (!exchange(at, cut)) break;
  }
  return at;
}

/// A centre that no small move improves.
struct LocalMinimum {
  Vector2d centre = Vector2d::Zero();
  Extremes at;
  bool stationary = false;
  double unrivalled = 0.0;  ///< no centre nearer than this is better
  std::vector<Index> touching;
};

/// The width rises by at least `sharpness` per unit away from the centre (least distance of the origin from
/// the sides of the triangle of slopes), less what the inner distances bend: distance^2 / (2 (inner -
/// distance)).
double unrivalled_within(const LinearMinimum& linear, double inner) {
  double sharpness = 2.0;
  for (std::size_t k = 0; k < 3; ++k) {
    const Vector2d a = linear.cuts[k].slope;
    const Vector2d side = linear.cuts[(k + 1) % 3].slope - a;
    const double length = side.norm();
    sharpness =
        length > 0.0 ? std::min(sharpness, std::abs(a.x() * side.y() - a.y() * side.x()) / length) : 0.0;
  }
  return 2.0 * sharpness * inner / (1.0 + 2.0 * sharpness);
}

LocalMinimum descend(const Matrix2Xd& points, const Vector2d& start) {
  LocalMinimum found;
  found.centre = start;
  found.at = extremes_about(points, start);
  for (int rounds = 0; rounds < 200; ++rounds) {
    const LinearMinimum linear = linear_minimum(points, found.centre, 0.3);
    found.stationary = found.at.width() - linear.width <= kStationary;
    found.touching.clear();
    for (const Cut& cut : linear.cuts)
      if (cut.far >= 0) found.touching.insert(found.touching.end(), {cut.far, cut.near});
    found.unrivalled = found.touching.size() == 6 ? unrivalled_within(linear, found.at.inner) : 0.0;
    bool moved = false;
    // At rest to rounding, halving a step that did not help is wasted work.
    const double least_share = found.stationary ? 0.2 : 1e-12;
    for (double share = 1.0; !moved && share > least_share; share /= 2.0) {
      const Vector2d next = found.centre + share * linear.move;
      const Extremes at = extremes_about(points, next);
      moved = at.width() < found.at.width();
      if (moved) {
        found.centre = next;
        found.at = at;
      }
    }
    if (!moved) break;
  }
  return found;
}

/// The farthest and the nearest point of each of some hundred stretches of the sequence: the few that can
/// matter, but for a small move.
Matrix2Xd outline(const Matrix2Xd& points) {
  std::vector<Index> chosen;
  const Index stretch = points.cols() / kStretches;
  for (Index begin = 0; begin < points.cols(); begin += stretch) {
    const Index count = std::min(stretch, points.cols() - begin);
    const Extremes at = extremes_about(points.middleCols(begin, count), Vector2d::Zero());
    chosen.insert(chosen.end(), {begin + at.far, begin + at.near});
  }
  return points(Eigen::all, chosen);
}

struct Box {
  Vector2d middle;
  double half = 0.0;
};

/// What is known of the plane outside: a better centre, or none, or too hard to say.
struct Rival {
  std::optional<Vector2d> centre;
  bool excluded = false;
};

/// The width anywhere within `reach` of `middle` is at least this: an extreme pair's difference changes by no
/// more than the angle between their directions, which itself opens by at most asin(reach / distance) each.
double least_width(const Extremes& at, const Matrix2Xd& points, const Vector2d& middle, double reach) {
  const Vector2d far = points.col(at.far) - middle;
  const Vector2d near = points.col(at.near) - middle;
  if (!(at.inner > 0.0)) return at.width() - 2.0 * reach;
  const double apart = (far / at.outer - near / at.inner).norm();
  const double opening = std::numbers::pi / 2.0 * reach * (1.0 / at.outer + 1.0 / at.inner);
  return at.width() - reach * std::min(2.0, apart + opening);
}

/// A few of the points: fewer only lower the width, so that a bound from them holds.
using Witnesses = Matrix2Xd;

Witnesses witnesses_of(const Matrix2Xd& points, const LocalMinimum& best) {
  std::vector<Index> chosen = best.touching;
  const Index stride = std::max<Index>(1, points.cols() / kMostWitnesses);
  for (Index i = 0; i < points.cols(); i += stride) chosen.push_back(i);
  return points(Eigen::all, chosen);
}

/// The width about any centre outside the square is at least this. From far away it is that of a strip of
/// parallel lines, less what the nearest point's place across the sight adds to its distance: across^2 / (2
/// distance) at most.
double least_width_outside(const Witnesses& witnesses) {
  const std::vector<Index> hull = convex_hull(witnesses);
  if (hull.size() < 3) return 0.0;
  double strip = std::numeric_limits<double>::infinity();
  for (std::size_t i = 0; i < hull.size(); ++i) {
    const Vector2d corner = witnesses.col(hull[i]);
    const Vector2d side = witnesses.col(hull[(i + 1) % hull.size()]) - corner;
    double deepest = 0.0;
    for (const Index k : hull) deepest = std::max(deepest, cross(side, witnesses.col(k) - corner));
    strip = std::min(strip, deepest / side.norm());
  }
  const Vector2d mean = witnesses.rowwise().mean();
  const double size = (witnesses.colwise() - mean).colwise().norm().maxCoeff();
  const double nearest = kReach - mean.norm() - size;
  return nearest > 0.0 ? strip - size * size / (2.0 * nearest) : 0.0;
}

/// Branch and bound over the square.
Rival search_rival(const Matrix2Xd& points, const Witnesses& witnesses, const LocalMinimum& best) {
  const double to_beat = best.at.width() - kStationary;

  std::vector<Box> boxes{{Vector2d::Zero(), kReach}};
  for (int seen = 0; seen < kMostBoxes; ++seen) {
    if (boxes.empty()) return {std::nullopt, true};
    const Box box = boxes.back();
    boxes.pop_back();
    const double reach = std::numbers::sqrt2 * box.half;
    if ((box.middle - best.centre).norm() + reach <= best.unrivalled) continue;
    const Extremes at = extremes_about(witnesses, box.middle);
    if (least_width(at, witnesses, box.middle, reach) >= to_beat) continue;
    if (at.width() < to_beat && extremes_about(points, box.middle).width() < to_beat)
      return {box.middle, false};
    for (const double x : {-0.5, 0.5})
      for (const double y : {-0.5, 0.5})
        boxes.push_back({box.middle + box.half * Vector2d(x, y), box.half / 2.0});
  }
  return {};
}

}  // namespace

MinimumZoneCircle minimum_zone_circle(const Matrix2Xd& points) {
  return minimum_zone_circle(points, fit_circle(points));
}

MinimumZoneCircle minimum_zone_circle(const Matrix2Xd& points, const CircleFit& circle) {
  MinimumZoneCircle zone;
  zone.status = circle.status;
  if (circle.status != FitStatus::kOk) return zone;
  const Matrix2Xd scaled = (points.colwise() - circle.centre) / circle.radius;

  // Of many points, most of the way is gone with few.
  const bool many = scaled.cols() > 10 * kStretches;
  const Vector2d start = many ? descend(outline(scaled), Vector2d::Zero()).centre : Vector2d(0.0, 0.0);
  LocalMinimum best = descend(scaled, start);
  while (best.at.width() > kStationary) {  // nothing is narrower than nothing
    const Witnesses witnesses = witnesses_of(scaled, best);
    const Rival rival = search_rival(scaled, witnesses, best);
    if (rival.centre) {  // each is narrower than the one before by kStationary, so this ends
      best = descend(scaled, *rival.centre);
      continue;
    }
    if (best.stationary && rival.excluded && least_width_outside(witnesses) >= best.at.width()) break;
    return minimum_zone_circle_everywhere(points);
  }
  zone.centre = circle.centre + circle.radius * best.centre;
  zone.outer_radius = circle.radius * best.at.outer;
  zone.inner_radius = circle.radius * best.at.inner;
  zone.width = circle.radius * best.at.width();
  return zone;
}

}  // namespace ballbar
