#pragma once
/// Alarms as states; the machine that moves them is in rules/.

#include <cstdint>
#include <string>
#include <tuple>
#include <vector>

#include "core/result.hpp"

namespace ballbar {

enum class AlarmState { kInactive, kPending, kFiring, kResolved };

/// What an alarm is about: a rule, and the results it looks at. Never a value that changes.
struct AlarmKey {
  std::string rule, robot, test;
  int direction = 0;
  std::string axis;  ///< lines; else empty
  auto operator<=>(const AlarmKey&) const =
      default;  // NOLINT(modernize-use-nullptr): clang-tidy 14 mistakes it
};

struct AlarmStatus {
  AlarmKey key;
  AlarmState state = AlarmState::kInactive;
  std::string severity = "warning";  ///< "info", "warning" or "critical"
  std::int64_t since_us = 0;         ///< begin of this state: ended_us of the run that caused it
  std::int64_t judged_us = 0;        ///< ended_us of the run that was judged last
  int bad_runs = 0;                  ///< in a row, for which the condition held
  int clean_runs = 0;                ///< in a row, for which it did not
  std::string text;                  ///< the rule's text, filled in
  bool operator==(const AlarmStatus&) const = default;
};

/// One change of state, as stored and published.
struct AlarmEvent {
  AlarmStatus status;  ///< after the change
  AlarmState from = AlarmState::kInactive;
  std::int64_t run_started_us = 0;  ///< with key.robot: the run that caused it
};

/// The earlier results that a rule may look at: same robot, test, direction, axis and source, without the
/// one being judged.
struct History {
  std::vector<Record> series_first;  ///< the first ones of the same series, oldest first
  std::vector<Record> recent;        ///< the latest ones of all series, oldest first
};

inline const char* to_string(AlarmState state) {
  switch (state) {
    case AlarmState::kInactive:
      return "inactive";
    case AlarmState::kPending:
      return "pending";
    case AlarmState::kFiring:
      return "firing";
    case AlarmState::kResolved:
      return "resolved";
  }
  return "inactive";
}

inline AlarmState alarm_state_from(const std::string& word) {
  if (word == "pending") return AlarmState::kPending;
  if (word == "firing") return AlarmState::kFiring;
  if (word == "resolved") return AlarmState::kResolved;
  return AlarmState::kInactive;
}

}  // namespace ballbar
