#pragma once
/// Alarms as states; the machine that moves them is in rules/.

#include <cstddef>
#include <cstdint>
#include <optional>
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

/// One number that an alarm stands on.
struct AlarmNumber {
  std::string name;  ///< with unit: a quantity, what the rule computed, or a field of the rule
  double value = 0.0;
  std::optional<double> sd;  ///< standard deviation, where the run gives one
  bool of_rule = false;      ///< set in the rule, as a limit is; else found in the run
  bool operator==(const AlarmNumber&) const = default;
};

/// "I have seen it." Ends when the alarm does.
struct Acknowledgement {
  std::string by;  ///< empty: nobody
  std::string comment;
  std::int64_t at_us = 0;  ///< the daemon's clock
  bool operator==(const Acknowledgement&) const = default;
};

/// "Do not tell me until then." The alarm goes on all the same.
struct Shelving {
  std::string by;  ///< empty: not shelved
  std::string comment;
  std::int64_t until_us = 0;  ///< the daemon's clock
  bool operator==(const Shelving&) const = default;
};

struct AlarmStatus {
  AlarmKey key;
  AlarmState state = AlarmState::kInactive;
  std::string severity = "warning";    ///< "info", "warning" or "critical"
  std::int64_t since_us = 0;           ///< begin of this state: ended_us of the run that caused it
  std::int64_t judged_us = 0;          ///< ended_us of the run that was judged last
  int bad_runs = 0;                    ///< in a row, for which the condition held
  int clean_runs = 0;                  ///< in a row, for which it did not
  std::string text;                    ///< the rule's text, filled in
  std::int64_t id = 0;                 ///< from 1, what people call it by; 0: not numbered yet
  std::int64_t streak_us = 0;          ///< ended_us of the first of those runs in a row
  std::int64_t fires = 0;              ///< bit i: it began to fire i judged runs ago
  bool flapping = false;               ///< fired so often that it fires on until it has been quiet
  std::vector<AlarmNumber> numbers{};  ///< of the last bad run: what `text` is made of
  std::vector<std::int64_t> runs{};    ///< started_us of the last bad runs in a row, oldest first
  Acknowledgement acknowledged{};
  Shelving shelved{};
  bool operator==(const AlarmStatus&) const = default;
};

inline constexpr std::size_t kAlarmRuns = 20;     ///< of AlarmStatus::runs, the newest
inline constexpr std::size_t kAlarmNumbers = 40;  ///< of AlarmStatus::numbers, the first

/// What an event is about.
enum class AlarmChange { kState, kAcknowledged, kShelved, kUnshelved };

/// One change, as stored and published.
struct AlarmEvent {
  AlarmStatus status;  ///< after the change
  AlarmState from = AlarmState::kInactive;
  std::int64_t run_started_us = 0;  ///< with key.robot: the run that caused it
  AlarmChange change = AlarmChange::kState;
  std::string by{};        ///< who did it, where a person did
  std::string comment{};   ///< what that person said
  std::int64_t at_us = 0;  ///< when, by the daemon's clock; of a change of state: status.since_us
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

inline const char* to_string(AlarmChange change) {
  switch (change) {
    case AlarmChange::kState:
      return "state";
    case AlarmChange::kAcknowledged:
      return "acknowledged";
    case AlarmChange::kShelved:
      return "shelved";
    case AlarmChange::kUnshelved:
      return "unshelved";
  }
  return "state";
}

inline AlarmChange alarm_change_from(const std::string& word) {
  if (word == "acknowledged") return AlarmChange::kAcknowledged;
  if (word == "shelved") return AlarmChange::kShelved;
  if (word == "unshelved") return AlarmChange::kUnshelved;
  return AlarmChange::kState;
}

inline AlarmState alarm_state_from(const std::string& word) {
  if (word == "pending") return AlarmState::kPending;
  if (word == "firing") return AlarmState::kFiring;
  if (word == "resolved") return AlarmState::kResolved;
  return AlarmState::kInactive;
}

}  // namespace ballbar
