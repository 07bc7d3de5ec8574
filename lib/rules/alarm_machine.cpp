#include "rules/alarm_machine.hpp"

#include <algorithm>
#include <bit>

namespace ballbar {
namespace {

constexpr int kMaxCount = 1'000'000;  // more than any hold_runs; a counter that stops there cannot overflow

AlarmState next_state(const AlarmStatus& counted, bool bad, const AlarmDelays& delays) {
  const double streak_s = static_cast<double>(counted.judged_us - counted.streak_us) * 1e-6;
  if (bad) {
    const bool fires = counted.state == AlarmState::kFiring ||
                       (counted.bad_runs >= delays.hold_runs && streak_s >= delays.hold_s);
    return fires ? AlarmState::kFiring : AlarmState::kPending;
  }
  if (counted.state != AlarmState::kFiring) return AlarmState::kInactive;
  const bool over = counted.clean_runs > delays.keep_runs && streak_s >= delays.keep_s && !counted.flapping;
  return over ? AlarmState::kResolved : AlarmState::kFiring;
}

bool flaps(std::int64_t fires, const AlarmDelays& delays) {
  const std::uint64_t window = (std::uint64_t{1} << std::min(delays.flap_runs, kMaxFlapRuns)) - 1;
  return delays.flap_fires > 0 &&
         std::popcount(static_cast<std::uint64_t>(fires) & window) >= delays.flap_fires;
}

}  // namespace

AlarmStatus advance(const AlarmStatus& before, bool bad, const AlarmDelays& delays, std::int64_t at_us) {
  AlarmStatus after = before;
  after.judged_us = at_us;
  after.bad_runs = bad ? std::min(before.bad_runs, kMaxCount) + 1 : 0;
  after.clean_runs = bad ? 0 : std::min(before.clean_runs, kMaxCount) + 1;
  if (after.bad_runs + after.clean_runs == 1) after.streak_us = at_us;
  constexpr std::uint64_t kKept = (std::uint64_t{1} << kMaxFlapRuns) - 1;
  std::uint64_t fires = (static_cast<std::uint64_t>(before.fires) << 1U) & kKept;
  after.flapping = flaps(static_cast<std::int64_t>(fires), delays);
  after.state = next_state(after, bad, delays);
  if (after.state == AlarmState::kFiring && before.state != AlarmState::kFiring) fires |= 1U;
  after.fires = static_cast<std::int64_t>(fires);
  after.flapping = after.state == AlarmState::kFiring && flaps(after.fires, delays);
  if (after.state == before.state) return after;
  after.since_us = at_us;
  if (after.state == AlarmState::kFiring || after.state == AlarmState::kInactive) after.acknowledged = {};
  return after;
}

}  // namespace ballbar
