#include "rules/alarm_machine.hpp"

#include <algorithm>

namespace ballbar {
namespace {

constexpr int kMaxCount = 1'000'000;  // more than any hold_runs; a counter that stops there cannot overflow

AlarmState next_state(const AlarmStatus& counted, bool bad, int hold_runs, int keep_runs) {
  if (bad) {
    const bool fires = counted.state == AlarmState::kFiring || counted.bad_runs >= hold_runs;
    return fires ? AlarmState::kFiring : AlarmState::kPending;
  }
  if (counted.state != AlarmState::kFiring) return AlarmState::kInactive;
  return counted.clean_runs > keep_runs ? AlarmState::kResolved : AlarmState::kFiring;
}

}  // namespace

AlarmStatus advance(const AlarmStatus& before, bool bad, int hold_runs, int keep_runs, std::int64_t at_us) {
  AlarmStatus after = before;
  after.judged_us = at_us;
  after.bad_runs = bad ? std::min(before.bad_runs, kMaxCount) + 1 : 0;
  after.clean_runs = bad ? 0 : std::min(before.clean_runs, kMaxCount) + 1;
  after.state = next_state(after, bad, hold_runs, keep_runs);
  if (after.state != before.state) after.since_us = at_us;
  return after;
}

}  // namespace ballbar
