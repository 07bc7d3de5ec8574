#include "files/recording.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/error.hpp"
#include "core/units.hpp"
#include "files/text.hpp"

namespace ballbar {
namespace {

constexpr double kTimeTolerance = 0.1;               // of the duration; as where angles are made of times
constexpr double kLeastRange = 1e-7;                 // [m] a bar resolves 0.1 um: less is a wrong unit
constexpr double kLeastSpan = 0.1, kMostSpan = 1.1;  // of the line: else a wrong unit

std::string text_of(double value, const char* unit) {
  char text[40];
  std::snprintf(text, sizeof text, "%.4g %s", value, unit);
  return text;
}

Run labelled(const TestSpec& test, const RecordingFacts& facts) {
  Run run;
  run.robot = facts.robot;
  run.test = test.name;
  run.kind = test.kind;
  run.direction = facts.direction;
  run.repetition = facts.repetition;
  run.series = facts.series;
  run.started_us = facts.started_us;
  run.ended_us = facts.started_us;
  run.feed = facts.feed > 0.0 ? facts.feed : test.feed;
  run.payload = facts.payload;
  run.temperature = facts.temperature;
  return run;
}

void end_after(Run& run, double seconds) {
  run.ended_us = run.started_us + std::llround(seconds / kSecondsPerUs);
}

void check_deviations(const std::vector<double>& deviation, const CircleSpec& circle) {
  const auto [low, high] = std::minmax_element(deviation.begin(), deviation.end());
  if (std::max(std::abs(*low), std::abs(*high)) > circle.radius / 2.0)
    throw refused("a deviation is " + text_of(to_mm(std::abs(*low) > *high ? *low : *high), "mm") +
                  ", more than half the radius: are these lengths, or is the unit wrong?");
  if (*high - *low < kLeastRange)
    throw refused("all deviations lie within " + text_of(to_um(*high - *low), "um") +
                  ", which no bar resolves: is the unit wrong?");
}

/// No times in the file: evenly over what was driven.
void spread_evenly(Run& run, const CircleSpec& circle, bool with_overshoot) {
  if (!(run.feed > 0.0)) throw refused("the speed is not known, the file has no times: give --feed-mm-s");
  const double rate = run.feed / circle.radius;
  const double before = with_overshoot ? 0.0 : circle.overshoot / rate;
  const double covered = (circle.arc_sweep + (with_overshoot ? 2.0 * circle.overshoot : 0.0)) / rate;
  const auto n = static_cast<double>(run.bar_deviation.size());
  for (std::size_t i = 0; i < run.bar_deviation.size(); ++i)
    run.bar_time.push_back(before + covered * (static_cast<double>(i) + 0.5) / n);
  end_after(run, 2.0 * before + covered);
}

/// Begin and end of the run as far before and behind the readings as the overshoots that they do not hold.
void place(Run& run, const std::vector<double>& time, const CircleSpec& circle, bool with_overshoot) {
  for (std::size_t i = 1; i < time.size(); ++i)
    if (!(time[i] > time[i - 1])) throw refused("the times do not rise at reading " + std::to_string(i + 1));
  const double span = time.back() - time.front();
  const double step = span / static_cast<double>(time.size() - 1);
  const double driven = circle.arc_sweep + (with_overshoot ? 2.0 * circle.overshoot : 0.0);
  double rate = driven / (span + step);
  if (run.feed > 0.0) {
    rate = run.feed / circle.radius;
    if (std::abs(span + step - driven / rate) > kTimeTolerance * driven / rate)
      throw refused("the readings take " + text_of(span + step, "s") + ", the " +
                    (with_overshoot ? "arc with its overshoots " : "arc without its overshoots ") +
                    text_of(driven / rate, "s") + " at " + text_of(to_mm(run.feed), "mm/s") +
                    ": see --with-overshoot, --feed-mm-s and the unit of the time");
  }
  const double before = step / 2.0 + (with_overshoot ? 0.0 : circle.overshoot / rate);
  for (const double t : time) run.bar_time.push_back(before + t - time.front());
  end_after(run, span + 2.0 * before);
}

}  // namespace

Run circle_from(const CsvReadings& readings, const TestSpec& test, const RecordingFacts& facts) {
  Run run = labelled(test, facts);
  if (readings.deviation.size() < 2) throw refused("one reading is no circle");
  check_deviations(readings.deviation, test.circle);
  run.bar_deviation = readings.deviation;
  if (readings.time.empty())
    spread_evenly(run, test.circle, facts.with_overshoot);
  else
    place(run, readings.time, test.circle, facts.with_overshoot);
  return run;
}

Run line_from(const CsvReadings& readings, const TestSpec& test, const RecordingFacts& facts, char axis) {
  if (readings.position.empty())
    throw refused(
        "the positions are not known: say with --columns which column holds them, e.g. position_mm=1");
  if (readings.axis.empty() && axis == '\0')
    throw refused("the direction of the deviation is not known: give --axis X, Y or Z");
  const auto [low, high] = std::minmax_element(readings.position.begin(), readings.position.end());
  const LineSpec& line = test.line;
  const double length =
      std::hypot(line.end[0] - line.start[0], line.end[1] - line.start[1], line.end[2] - line.start[2]);
  if (*high - *low < kLeastSpan * length || *high - *low > kMostSpan * length)
    throw refused("the positions span " + text_of(to_mm(*high - *low), "mm") + ", the line '" + test.name +
                  "' is " + text_of(to_mm(length), "mm") + " long: is the unit wrong?");
  const double travelled = readings.position.back() - readings.position.front();
  if (travelled * facts.direction < 0.0)
    throw refused("the positions " + std::string(travelled > 0.0 ? "rise" : "fall") +
                  ", but the direction is " + (facts.direction > 0 ? "forward" : "backward"));
  Run run = labelled(test, facts);
  const double first = readings.time.empty() ? 0.0 : readings.time.front();
  for (std::size_t i = 0; i < readings.deviation.size(); ++i) {
    const double time = readings.time.empty() ? 0.0 : readings.time[i] - first;
    if (!run.readings.empty() && time < run.readings.back().time)
      throw refused("the times fall at reading " + std::to_string(i + 1));
    run.readings.push_back(
        {readings.axis.empty() ? axis : readings.axis[i], time, readings.position[i], readings.deviation[i]});
  }
  end_after(run, run.readings.back().time);
  return run;
}

int sense_of(const std::string& plane, const CircleSpec& circle) {
  constexpr double kAlong = 0.99;  // cosine: 8 degrees
  const int axis = plane == "YZ" ? 0 : plane == "ZX" ? 1 : plane == "XY" ? 2 : -1;
  if (axis < 0) throw refused("the plane of the test is '" + plane + "', neither XY, YZ nor ZX");
  const double along = circle.normal[static_cast<std::size_t>(axis)];
  if (std::abs(along) < kAlong)
    throw refused("the file is of a test in the plane " + plane + ", the configured circle lies in another");
  return along > 0.0 ? 1 : -1;
}

}  // namespace ballbar
