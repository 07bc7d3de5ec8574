#pragma once
/// When a series of circles and lines is over and may be diagnosed. Pure: is told what was stored, and when
/// by a steady clock.

#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/spec.hpp"

namespace ballbar {

/// The name without "-held-out": both halves are one measurement.
std::string base_series(const std::string& series);

/// One robot's series that is over.
struct EndedSeries {
  std::string robot, series;  ///< without "-held-out"
  std::string why;            ///< for the journal
};

/// A series is over when another begins, when nothing more of it comes for the stated time, or when every
/// configured circle was heard both ways twice; of a robot without circles, every line. What comes later
/// makes it due again.
class SeriesWatch {
 public:
  /// @param silence_us  after which nothing more is awaited
  explicit SeriesWatch(std::int64_t silence_us) : silence_us_(silence_us) {}

  void configure(std::int64_t silence_us) { silence_us_ = silence_us; }

  /// A circle or line that a diagnosis can use.
  void heard(const RobotSpec& robot, const std::string& series, const std::string& test, int direction,
             std::int64_t now_us);

  /// What was heard of this robot so far has been diagnosed already.
  void diagnosed(const std::string& robot);

  /// The next one that is over; each is told once.
  std::optional<EndedSeries> next(std::int64_t now_us);

 private:
  struct Open {
    std::string series;
    std::map<std::pair<std::string, int>, int> laps;
    int fresh = 0;  ///< runs since it was last told
    bool complete = false;
    std::int64_t heard_us = 0;
  };

  std::int64_t silence_us_;
  std::map<std::string, Open> open_;  ///< by robot
  std::vector<EndedSeries> ended_;
};

}  // namespace ballbar
