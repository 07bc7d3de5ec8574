#pragma once
/// Fewer points for the same picture.

#include <vector>

namespace ballbar {

struct PlotPoint {
  double x = 0.0, y = 0.0;
};

/// The points of `curve` that are needed so that none of it is further than `tolerance` from the line through
/// those that stay (Douglas and Peucker 1973). First and last stay.
std::vector<PlotPoint> thinned(const std::vector<PlotPoint>& curve, double tolerance);

}  // namespace ballbar
