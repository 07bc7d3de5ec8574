#pragma once
/// Moves an alarm from run to run. A rule says whether a run is bad; this says what that makes of the alarm.

#include <cstdint>

#include "core/alarm.hpp"

namespace ballbar {

/// The alarm after one more run was judged.
///
///     inactive  bad: pending; at once firing where hold_runs is 1        clean: stays
///     pending   bad: firing at the hold_runs-th bad run in a row         clean: inactive
///     firing    bad: stays                                               clean: resolved at clean run
///     keep_runs + 1 in a row resolved  bad: as from inactive                                    clean:
///     inactive
///
/// Changes state, since_us, judged_us and the counters; key, severity and text are left as they are.
///
/// @param hold_runs  >= 1
/// @param keep_runs  >= 0
/// @param at_us      ended_us of the run
AlarmStatus advance(const AlarmStatus& before, bool bad, int hold_runs, int keep_runs, std::int64_t at_us);

}  // namespace ballbar
