#include "numerics/reference_circles.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <numbers>
#include <numeric>
#include <optional>
#include <random>
#include <vector>

#include "numerics/minimum_zone.hpp"
#include "numerics/nist_circles.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix2d;
using Eigen::Matrix2Xd;
using Eigen::Vector2d;

struct Extent {
  double least, most;
};

/// Distances of the points from a centre. By plain loops: the twins try some hundred million of them.
Extent extent_about(const std::vector<Vector2d>& points, const Vector2d& centre) {
  Extent extent{1e300, 0.0};
  for (const Vector2d& p : points) {
    const double d = std::hypot(p.x() - centre.x(), p.y() - centre.y());
    extent.least = std::min(extent.least, d);
    extent.most = std::max(extent.most, d);
  }
  return extent;
}

/// Where the perpendicular bisectors of two pairs cross; nothing where they are parallel.
std::optional<Vector2d> crossing(const Vector2d& a, const Vector2d& b, const Vector2d& c, const Vector2d& d) {
  const Vector2d n = b - a;
  const Vector2d m = d - c;
  const double across = n.x() * m.y() - n.y() * m.x();
  if (std::abs(across) < 1e-12) return std::nullopt;
  const double p = (b.squaredNorm() - a.squaredNorm()) / 2.0;
  const double q = (d.squaredNorm() - c.squaredNorm()) / 2.0;
  return Vector2d((p * m.y() - q * n.y()) / across, (q * n.x() - p * m.x()) / across);
}

/// The smallest circle that holds all points is one of those on two points' line as diameter, or through
/// three.
double brute_force_circumscribed(const std::vector<Vector2d>& points) {
  double best = 1e300;
  const std::size_t n = points.size();
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j) {
      best = std::min(best, extent_about(points, (points[i] + points[j]) / 2.0).most);
      for (std::size_t k = j + 1; k < n; ++k)
        if (const auto centre = crossing(points[i], points[j], points[i], points[k]))
          best = std::min(best, extent_about(points, *centre).most);
    }
  return best;
}

/// The largest of all empty circles through three points that surround their centre, about the given point.
/// Zero for none. "Surround" by the signs of the three sub-triangles' areas, with the tolerance of the
/// header's "closed".
double brute_force_inscribed(const std::vector<Vector2d>& points, const Vector2d& about) {
  double best = 0.0;
  const std::size_t n = points.size();
  const auto area = [](const Vector2d& a, const Vector2d& b, const Vector2d& c) {
    return (b.x() - a.x()) * (c.y() - a.y()) - (b.y() - a.y()) * (c.x() - a.x());
  };
  for (std::size_t i = 0; i < n; ++i)
    for (std::size_t j = i + 1; j < n; ++j)
      for (std::size_t k = j + 1; k < n; ++k) {
        const Vector2d &a = points[i], &b = points[j], &c = points[k];
        const auto m = crossing(a, b, a, c);
        if (!m) continue;
        const double whole = area(a, b, c);
        if (area(a, b, *m) / whole < -1e-9 || area(b, c, *m) / whole < -1e-9 ||
            area(c, a, *m) / whole < -1e-9)
          continue;
        const double radius = (a - *m).norm();
        if ((about - *m).norm() > radius) continue;
        const double clear = extent_about(points, *m).least;
        if (clear < radius - 1e-11) continue;
        best = std::max(best, clear);
      }
  return best;
}

/// No gap of half a turn or more between neighbouring directions.
bool all_around(const std::vector<Vector2d>& points, const Vector2d& about) {
  std::vector<double> direction;
  for (const Vector2d& p : points) direction.push_back(std::atan2(p.y() - about.y(), p.x() - about.x()));
  std::sort(direction.begin(), direction.end());
  double gap = direction.front() + 2.0 * std::numbers::pi - direction.back();
  for (std::size_t i = 1; i < direction.size(); ++i) gap = std::max(gap, direction[i] - direction[i - 1]);
  return gap < std::numbers::pi - 1e-9;
}

/// Largest minus smallest distance from a centre that may be far away, where a plain difference would be
/// rounding.
double zone_about(const std::vector<Vector2d>& points, const Vector2d& centre) {
  Vector2d far = points.front();
  Vector2d near = far;
  for (const Vector2d& p : points) {
    if ((p - far).dot(p + far - 2.0 * centre) > 0.0) far = p;
    if ((p - near).dot(p + near - 2.0 * centre) < 0.0) near = p;
  }
  return (far - near).dot(far + near - 2.0 * centre) / ((far - centre).norm() + (near - centre).norm());
}

/// The narrowest zone of two concentric circles touches each in two points, so its centre lies where the
/// perpendicular bisectors of two pairs cross: all crossings of the plane are tried.
double brute_force_zone(const std::vector<Vector2d>& points) {
  double best = 1e300;
  std::vector<std::array<std::size_t, 2>> pairs;
  for (std::size_t i = 0; i < points.size(); ++i)
    for (std::size_t j = i + 1; j < points.size(); ++j) pairs.push_back({i, j});
  for (std::size_t p = 0; p < pairs.size(); ++p)
    for (std::size_t q = p + 1; q < pairs.size(); ++q)
      if (const auto centre =
              crossing(points[pairs[p][0]], points[pairs[p][1]], points[pairs[q][0]], points[pairs[q][1]]))
        best = std::min(best, zone_about(points, *centre));
  return best;
}

/// The narrowest zone of two parallel lines runs along two of the points: all pairs are tried.
double brute_force_strip(const std::vector<Vector2d>& points) {
  double best = 1e300;
  for (const Vector2d& a : points)
    for (const Vector2d& b : points) {
      if ((b - a).norm() < 1e-12) continue;
      const Vector2d across = Vector2d(a.y() - b.y(), b.x() - a.x()).normalized();
      double least = 1e300, most = -1e300;
      for (const Vector2d& p : points) {
        least = std::min(least, across.dot(p));
        most = std::max(most, across.dot(p));
      }
      best = std::min(best, most - least);
    }
  return best;
}

std::vector<Vector2d> list_of(const Matrix2Xd& points) {
  std::vector<Vector2d> list;
  for (Index i = 0; i < points.cols(); ++i) list.emplace_back(points.col(i));
  return list;
}

enum Kind { kRound, kRough, kWild, kHalf, kShort, kRegular, kTwice, kLattice, kEllipse, kLine, kKinds };
constexpr std::array<const char*, kKinds> kNames{"round",   "rough", "wild",    "half",    "short",
                                                 "regular", "twice", "lattice", "ellipse", "line"};

/// Ten kinds of sets of 4 to 8 points; the last five are degenerate: regular polygons, every point twice,
/// whole numbers, an ellipse's symmetric points, points on a line or within
/// 1e-9 to 1 of one.
Matrix2Xd points_of(int kind, unsigned seed) {
  std::mt19937 random(seed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  const int n = 4 + static_cast<int>(seed % 5);
  Matrix2Xd points(2, n);
  for (int i = 0; i < n; ++i) {
    const double sweep = kind == kHalf ? 3.1 : kind == kShort ? 1.0 : 2.0 * std::numbers::pi;
    const bool shaky = kind < kRegular || kind == kTwice;
    const double at = sweep * (i + (shaky ? 0.4 * uniform(random) : 0.0)) / n;
    const double noise = kind == kRough || kind == kTwice ? 0.3
                         : kind == kWild                  ? 0.9
                         : kind < kRegular                ? 0.01
                                                          : 0.0;
    points.col(i) = (1.0 + noise * uniform(random)) * Vector2d(std::cos(at), std::sin(at));
    if (kind == kTwice && i % 2 == 1) points.col(i) = points.col(i - 1);
    if (kind == kEllipse) points(0, i) *= 1.2;
    if (kind == kLattice)
      points.col(i) = (3.0 * Vector2d(uniform(random), uniform(random))).array().round().matrix();
    if (kind == kLine) {
      points.col(i) = Vector2d(1.0, 2.0) * uniform(random);
      if (seed % 3 > 0) points(0, i) += std::pow(10.0, -static_cast<double>(seed % 10)) * uniform(random);
    }
  }
  return points;
}

TEST(ReferenceCircles, EqualTheirBruteForceTwinsOnTenThousandSets) {
  int inscribed = 0, nearer_to_a_line = 0;
  for (int kind = 0; kind < kKinds; ++kind)
    for (unsigned seed = 1; seed <= 1000; ++seed) {
      SCOPED_TRACE(std::string(kNames[static_cast<std::size_t>(kind)]) + ", seed " + std::to_string(seed));
      const Matrix2Xd points = points_of(kind, seed);
      const std::vector<Vector2d> list = list_of(points);

      const ReferenceCircle outer = minimum_circumscribed_circle(points);
      ASSERT_EQ(outer.status, FitStatus::kOk);
      ASSERT_NEAR(outer.radius, brute_force_circumscribed(list), 1e-9);
      ASSERT_NEAR(outer.radius, extent_about(list, outer.centre).most, 1e-12);

      const CircleFit fitted = fit_circle(points);
      const MinimumZoneCircle zone = minimum_zone_circle(points);
      const ReferenceCircle inner = maximum_inscribed_circle(points);
      if (fitted.status != FitStatus::kOk) {
        ASSERT_NE(zone.status, FitStatus::kOk);
        ASSERT_NE(inner.status, FitStatus::kOk);
        continue;
      }
      const double circles = brute_force_zone(list);
      const double lines = brute_force_strip(list);
      for (const MinimumZoneCircle& found : {zone, minimum_zone_circle_everywhere(points)}) {
        if (found.status == FitStatus::kOk) {
          ASSERT_NEAR(found.width, circles, 1e-9);
          ASSERT_NEAR(found.width, zone_about(list, found.centre), 1e-9);
          ASSERT_LT(circles, lines + 1e-9);
        } else {
          ASSERT_GT(circles, lines - 1e-9);
        }
      }
      nearer_to_a_line += zone.status == FitStatus::kOk ? 0 : 1;
      const double expected =
          all_around(list, fitted.centre) ? brute_force_inscribed(list, fitted.centre) : 0.0;
      if (inner.status != FitStatus::kOk) {
        ASSERT_EQ(expected, 0.0);
        continue;
      }
      ++inscribed;
      ASSERT_NEAR(inner.radius, expected, 1e-9);
      ASSERT_NEAR(inner.radius, extent_about(list, inner.centre).least, 1e-12);
    }
  EXPECT_LT(nearer_to_a_line, 500) << "most sets have a minimum-zone circle to compare";
  EXPECT_GT(inscribed, 5000) << "most sets have an inscribed circle to compare";
}

TEST(ReferenceCircles, OfTheNistSetsAreInTheOrderThatTheirDefinitionsAskFor) {
  if (!std::filesystem::exists(test::shared_data()))
    GTEST_SKIP() << "no shared data at " << BALLBAR_SHARED_DIR;
  for (int number = 1; number <= test::kNistSets; ++number) {
    const test::NistCircle nist = test::read_nist_circle(number);
    SCOPED_TRACE(nist.name);
    const std::vector<Vector2d> list = list_of(nist.points);
    const CircleFit fitted = fit_circle(nist.points);
    const ReferenceCircle outer = minimum_circumscribed_circle(nist.points);
    const ReferenceCircle inner = maximum_inscribed_circle(nist.points);
    const MinimumZoneCircle zone = minimum_zone_circle(nist.points);
    const bool few = list.size() <= 40;  // the twins need n^4
    if (few) {
      EXPECT_NEAR(outer.radius, brute_force_circumscribed(list), 1e-9);
    }
    EXPECT_NEAR(outer.radius, extent_about(list, outer.centre).most, 1e-12);
    EXPECT_LE(outer.radius, zone.outer_radius + 1e-12);
    const double expected = few ? brute_force_inscribed(list, fitted.centre) : inner.radius;
    if (inner.status == FitStatus::kOk) {
      EXPECT_NEAR(inner.radius, expected, 1e-9);
      EXPECT_NEAR(inner.radius, extent_about(list, inner.centre).least, 1e-12);
      EXPECT_GE(roundness_about(nist.points, inner.centre, inner.radius).total, zone.width - 1e-12);
    } else {
      EXPECT_EQ(expected, 0.0);
    }
  }
}

TEST(ReferenceCircles, OfTwentyThousandSamplesRestOnThreePoints) {
  for (const double noise : {0.0, 0.5e-6}) {
    const unsigned seed = 3;
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0.0, 1.0);
    const int n = 20000;
    Matrix2Xd points(2, n);
    for (int i = 0; i < n; ++i) {
      const double angle = 2.0 * std::numbers::pi * i / n;
      const double radius =
          0.1 + 90e-6 * std::cos(2 * angle + 0.3) + 20e-6 * std::sin(3 * angle) + noise * normal(random);
      points.col(i) = radius * Vector2d(std::cos(angle), std::sin(angle));
    }
    const ReferenceCircle outer = minimum_circumscribed_circle(points);
    const ReferenceCircle inner = maximum_inscribed_circle(points);
    ASSERT_EQ(outer.status, FitStatus::kOk);
    ASSERT_EQ(inner.status, FitStatus::kOk) << "noise " << noise << ", seed " << seed;
    int on_outer = 0, on_inner = 0;
    for (int i = 0; i < n; ++i) {
      const double out = (points.col(i) - outer.centre).norm();
      const double in = (points.col(i) - inner.centre).norm();
      EXPECT_LE(out, outer.radius + 1e-15);
      EXPECT_GE(in, inner.radius - 1e-15);
      on_outer += outer.radius - out < 5e-14 ? 1 : 0;
      on_inner += in - inner.radius < 5e-14 ? 1 : 0;
    }
    EXPECT_GE(on_outer, 2);
    EXPECT_LE(on_outer, 3);
    EXPECT_EQ(on_inner, 3) << "noise " << noise << ", seed " << seed;
  }
}

TEST(ReferenceCircles, TheLargestInscribedOneOfManyPointsIsThatOfEveryOtherSequence) {
  // Many points go another way than few. Shuffled they choose others; half of them go the other way, and
  // bound the radius.
  for (unsigned seed = 1; seed <= 12; ++seed) {
    std::mt19937 random(seed);
    std::normal_distribution<double> normal(0.0, 1.0);
    std::uniform_real_distribution<double> uniform(0.0, 2.0 * std::numbers::pi);
    const int n = 2400;
    const double size = seed % 3 == 0 ? 10e-3 : 100e-6;  // of the shape
    Matrix2Xd points(2, n);
    const double phase = uniform(random);
    for (int i = 0; i < n; ++i) {
      const double angle = seed % 2 == 0 ? uniform(random) : 2.0 * std::numbers::pi * i / n;
      const double radius = 0.1 + size * std::cos(2 * angle + phase) + 0.3 * size * std::sin(5 * angle) +
                            (seed % 4 == 0 ? 0.01 * size * normal(random) : 0.0);
      points.col(i) = radius * Vector2d(std::cos(angle), std::sin(angle));
    }
    const CircleFit fitted = fit_circle(points);
    const ReferenceCircle many = maximum_inscribed_circle(points, fitted);
    ASSERT_EQ(many.status, FitStatus::kOk) << "seed " << seed;
    std::vector<Eigen::Index> sequence(static_cast<std::size_t>(n));
    std::iota(sequence.begin(), sequence.end(), Eigen::Index{0});
    std::shuffle(sequence.begin(), sequence.end(), random);
    const ReferenceCircle shuffled = maximum_inscribed_circle(points(Eigen::all, sequence).eval(), fitted);
    EXPECT_NEAR(shuffled.radius, many.radius, 1e-14) << "seed " << seed;
    EXPECT_NEAR((shuffled.centre - many.centre).norm(), 0.0, 1e-9) << "seed " << seed;
    for (const Eigen::Index first : {0, 1}) {
      const Matrix2Xd half = points(Eigen::all, Eigen::seq(first, n - 1, 2));
      const ReferenceCircle direct = maximum_inscribed_circle(half, fitted);
      EXPECT_GE(direct.radius, many.radius - 1e-14) << "fewer points leave more room; seed " << seed;
      const double clear = (points.colwise() - direct.centre).colwise().norm().minCoeff();
      EXPECT_LE(clear, many.radius + 1e-14) << "seed " << seed;
    }
  }
}

TEST(ReferenceCircles, SayWhereTheyAreNotDefined) {
  EXPECT_EQ(minimum_circumscribed_circle(Matrix2Xd(2, 1)).status, FitStatus::kTooFewPoints);
  EXPECT_EQ(maximum_inscribed_circle(Matrix2Xd::Zero(2, 2)).status, FitStatus::kTooFewPoints);
  const ReferenceCircle alike = minimum_circumscribed_circle(Matrix2Xd::Constant(2, 5, 0.7));
  EXPECT_EQ(alike.status, FitStatus::kOk);
  EXPECT_EQ(alike.radius, 0.0);
  Matrix2Xd half_turn(2, 200);
  for (int i = 0; i < 200; ++i)
    half_turn.col(i) << std::cos(std::numbers::pi * i / 199), std::sin(std::numbers::pi * i / 199) * 0.999;
  EXPECT_EQ(maximum_inscribed_circle(half_turn).status, FitStatus::kIllConditioned);
  Matrix2Xd bad = half_turn;
  bad(1, 7) = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(minimum_circumscribed_circle(bad), std::invalid_argument);
  EXPECT_THROW(maximum_inscribed_circle(bad), std::invalid_argument);
}

TEST(Roundness, OfAKnownTraceHasItsPeakValleyAndRms) {
  Matrix2Xd square(2, 4);
  square << 1.0, 0.0, -1.2, 0.0, 0.0, 1.1, 0.0, -0.9;
  const Roundness about = roundness_about(square, Vector2d::Zero(), 1.0);
  EXPECT_NEAR(about.peak, 0.2, 1e-15);
  EXPECT_NEAR(about.valley, 0.1, 1e-15);
  EXPECT_NEAR(about.total, 0.3, 1e-15);
  EXPECT_NEAR(about.rms, std::sqrt((0.04 + 0.01 + 0.01) / 4.0), 1e-15);
  EXPECT_EQ(roundness_about(Matrix2Xd(2, 0), Vector2d::Zero(), 1.0).total, 0.0);
}

}  // namespace
}  // namespace ballbar
