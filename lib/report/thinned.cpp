#include "report/thinned.hpp"

#include <algorithm>
#include <cmath>
#include <cstddef>
#include <utility>

namespace ballbar {
namespace {

/// Distance from the stretch a..b: of a closed curve its ends are the same point.
double distance(const PlotPoint& p, const PlotPoint& a, const PlotPoint& b) {
  const double dx = b.x - a.x;
  const double dy = b.y - a.y;
  const double length2 = dx * dx + dy * dy;
  const double along =
      length2 > 0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / length2, 0.0, 1.0) : 0.0;
  return std::hypot(p.x - a.x - along * dx, p.y - a.y - along * dy);
}

}  // namespace

std::vector<PlotPoint> thinned(const std::vector<PlotPoint>& curve, double tolerance) {
  if (curve.size() < 3) return curve;
  std::vector<bool> stays(curve.size(), false);
  stays.front() = stays.back() = true;
  std::vector<std::pair<std::size_t, std::size_t>> open{{0, curve.size() - 1}};
  while (!open.empty()) {
    const auto [begin, end] = open.back();
    open.pop_back();
    std::size_t furthest = begin;
    double most = tolerance;
    for (std::size_t i = begin + 1; i < end; ++i) {
      const double off = distance(curve[i], curve[begin], curve[end]);
      if (off > most) {
        most = off;
        furthest = i;
      }
    }
    if (furthest == begin) continue;
    stays[furthest] = true;
    open.emplace_back(begin, furthest);
    open.emplace_back(furthest, end);
  }
  std::vector<PlotPoint> kept;
  for (std::size_t i = 0; i < curve.size(); ++i)
    if (stays[i]) kept.push_back(curve[i]);
  return kept;
}

}  // namespace ballbar
