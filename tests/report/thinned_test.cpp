#include "report/thinned.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>
#include <random>

namespace ballbar {
namespace {

/// Brute force: the distance of p from the nearest stretch of the polygon.
double distance(const PlotPoint& p, const std::vector<PlotPoint>& polygon) {
  double nearest = 1e300;
  for (std::size_t i = 0; i + 1 < polygon.size(); ++i)
    for (int k = 0; k <= 400; ++k) {
      const double t = k / 400.0;
      nearest = std::min(nearest, std::hypot(polygon[i].x + t * (polygon[i + 1].x - polygon[i].x) - p.x,
                                             polygon[i].y + t * (polygon[i + 1].y - polygon[i].y) - p.y));
    }
  return nearest;
}

TEST(Thinned, StaysWithinTheToleranceOfEveryPointThatWasLeftOut) {
  constexpr unsigned kSeed = 7;
  std::mt19937 random(kSeed);
  std::normal_distribution<double> noise(0.0, 0.003);
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::vector<PlotPoint> circle;  // closed: first and last point are nearly the same
  for (int i = 0; i <= 500; ++i) {
    const double t = 2 * std::numbers::pi * i / 500;
    const double r = 6 + 0.5 * std::cos(2 * t) + (i > 250 ? 0.3 : 0.0) + noise(random);
    circle.push_back({r * std::cos(t), r * std::sin(t)});
  }
  const std::vector<PlotPoint> few = thinned(circle, 0.01);
  EXPECT_LT(few.size(), circle.size() / 3);
  EXPECT_EQ(few.front().x, circle.front().x);
  EXPECT_EQ(few.back().y, circle.back().y);
  for (const PlotPoint& p : circle) EXPECT_LT(distance(p, few), 0.01 + 0.002) << p.x << " " << p.y;
}

TEST(Thinned, KeepsWhatCannotBeSpared) {
  EXPECT_EQ(thinned({}, 1.0).size(), 0U);
  EXPECT_EQ(thinned({{0, 0}, {0, 0}}, 1.0).size(), 2U);
  EXPECT_EQ(thinned({{0, 0}, {1, 0}, {2, 0}, {3, 0}}, 0.1).size(), 2U);
  EXPECT_EQ(thinned({{0, 0}, {1, 1}, {2, 0}}, 0.1).size(), 3U);
  EXPECT_EQ(thinned({{0, 0}, {5, 0}, {1, 0}}, 0.1).size(), 3U) << "there and back along the same line";
}

}  // namespace
}  // namespace ballbar
