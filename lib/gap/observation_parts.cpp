#include "gap/observation_parts.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "metrology/arc.hpp"

namespace ballbar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

Index smooth_number(double wanted) {
  for (Index n = std::max<Index>(16, std::lround(wanted));; ++n) {
    Index rest = n;
    for (const Index factor : {2, 3, 5})
      while (rest % factor == 0) rest /= factor;
    if (rest == 1) return n;
  }
}

bool without_holes(const Motion& said) {
  for (Index k = 1; k < said.time.size(); ++k)
    if (said.time[k] - said.time[k - 1] > kLongestJointGap) return false;
  return true;
}

bool set_times(const Lap& lap, Observation& seen) {
  const Index n = seen.places();
  VectorXd on_way(n);
  Index i = 0;
  for (Index k = 0; k < n; ++k) {
    const double x = (static_cast<double>(k) + 0.5) / static_cast<double>(n);
    while (i + 2 < lap.x.size() && lap.x[i + 1] < x) ++i;
    on_way[k] = lap.time[i] + (x - lap.x[i]) / (lap.x[i + 1] - lap.x[i]) * (lap.time[i + 1] - lap.time[i]);
  }
  const double step = (on_way[n - 1] - on_way[0]) / static_cast<double>(n - 1);
  const double first = seen.said.time[0] + kShiftRoom;
  const double last = seen.said.time[seen.said.time.size() - 1] - kShiftRoom;
  if (!(step > 0.0) || on_way[0] <= first || on_way[n - 1] >= last || !without_holes(seen.said)) return false;
  const auto before = static_cast<Index>((on_way[0] - first) / step);
  const auto behind = static_cast<Index>(std::min(kBehindWay, last - on_way[n - 1]) / step);
  seen.time.resize(before + n + behind);
  for (Index k = 0; k < before; ++k) seen.time[k] = on_way[0] - step * static_cast<double>(before - k);
  seen.time.segment(before, n) = on_way;
  for (Index k = 0; k < behind; ++k)
    seen.time[before + n + k] = on_way[n - 1] + step * static_cast<double>(k + 1);
  seen.sample.resize(static_cast<std::size_t>(n));
  std::iota(seen.sample.begin(), seen.sample.end(), before);
  return true;
}

void describe(const std::vector<const Run*>& used, Observation& seen) {
  const Run& first = *used.front();
  seen.test = first.test;
  seen.series = first.series;
  seen.direction = first.direction;
  seen.feed = first.feed;
  seen.conditions.payload = first.payload;
  seen.conditions.start_us = first.started_us;
  seen.begin_us = first.started_us;
  seen.end_us = used.back()->ended_us;
  for (const Run* run : used) {
    seen.runs.push_back(run_name(*run));
    seen.conditions.series_time +=
        static_cast<double>(run->started_us - first.started_us) * 1e-6 / static_cast<double>(used.size());
  }
}

}  // namespace ballbar
