#include "daemon/series_watch.hpp"

#include <algorithm>

#include "gap/observation.hpp"

namespace ballbar {
namespace {

constexpr int kLaps = 2;  // each way: fewer do not show the noise

/// What must be heard for a series to be whole: the circles, or, where there are none, the lines.
TestKind awaited_of(const RobotSpec& robot) {
  const bool circles = std::any_of(robot.tests.begin(), robot.tests.end(),
                                   [](const TestSpec& test) { return test.kind == TestKind::kCircle; });
  return circles ? TestKind::kCircle : TestKind::kLine;
}

bool is_complete(const RobotSpec& robot, const std::map<std::pair<std::string, int>, int>& laps) {
  const TestKind awaited = awaited_of(robot);
  return !robot.tests.empty() &&
         std::all_of(robot.tests.begin(), robot.tests.end(), [&](const TestSpec& test) {
           const auto heard = [&](int direction) {
             const auto found = laps.find({test.name, direction});
             return found != laps.end() && found->second >= kLaps;
           };
           return test.kind != awaited || (heard(1) && heard(-1));
         });
}

}  // namespace

std::string base_series(const std::string& series) {
  const std::string ending = kHeldOutEnding;
  return series.ends_with(ending) ? series.substr(0, series.size() - ending.size()) : series;
}

void SeriesWatch::heard(const RobotSpec& robot, const std::string& series, const std::string& test,
                        int direction, std::int64_t now_us) {
  const std::string base = base_series(series);
  Open& open = open_[robot.name];
  if (open.series != base) {
    if (open.fresh > 0) ended_.push_back({robot.name, open.series, "the next series has begun"});
    open = {};
    open.series = base;
  }
  ++open.laps[{test, direction}];
  ++open.fresh;
  open.heard_us = now_us;
  if (open.complete || !is_complete(robot, open.laps)) return;
  open.complete = true;
  open.fresh = 0;
  ended_.push_back({robot.name, base,
                    std::string("every ") + (awaited_of(robot) == TestKind::kCircle ? "circle" : "line") +
                        " was heard both ways twice"});
}

void SeriesWatch::diagnosed(const std::string& robot) {
  if (const auto open = open_.find(robot); open != open_.end()) open->second.fresh = 0;
  std::erase_if(ended_, [&](const EndedSeries& ended) { return ended.robot == robot; });
}

std::optional<EndedSeries> SeriesWatch::next(std::int64_t now_us) {
  for (auto& [robot, open] : open_) {
    if (open.fresh == 0 || now_us - open.heard_us < silence_us_) continue;
    ended_.push_back({robot, open.series, "nothing more of it has come"});
    // The same name later is another measurement: its laps count anew.
    open.laps.clear();
    open.complete = false;
    open.fresh = 0;
  }
  if (ended_.empty()) return std::nullopt;
  EndedSeries first = std::move(ended_.front());
  ended_.erase(ended_.begin());
  return first;
}

}  // namespace ballbar
