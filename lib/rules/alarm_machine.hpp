#pragma once
/// Moves an alarm from run to run. A rule says whether a run is bad; this says what that makes of the alarm.

#include <cstdint>

#include "core/alarm.hpp"

namespace ballbar {

/// How much it takes until an alarm fires, and until it is over.
struct AlarmDelays {
  int hold_runs = 1;    ///< >= 1: bad runs in a row
  int keep_runs = 1;    ///< >= 0: clean runs in a row that firing outlasts
  double hold_s = 0.0;  ///< [s] from the end of the first bad run in a row to that of the one that fires
  double keep_s = 0.0;  ///< [s] from the end of the first clean run in a row to that of the one that resolves
  int flap_fires = 3;   ///< having begun to fire so often ...
  int flap_runs = 20;   ///< ... within so many judged runs, at most kMaxFlapRuns: flapping; 0: never
};

inline constexpr int kMaxFlapRuns = 60;

/// The alarm after one more run was judged.
///
///     inactive  bad: pending; at once firing where hold_runs is 1 and hold_s is 0   clean: stays
///     pending   bad: firing at the hold_runs-th bad run in a row, hold_s after the first   clean: inactive
///     firing    bad: stays   clean: resolved at clean run keep_runs + 1 in a row, keep_s after the first
///     resolved  bad: as from inactive   clean: inactive
///
/// An alarm that flaps does not resolve until fewer than flap_fires of the last flap_runs runs began to
/// fire: it is said once, and not at each turn.
///
/// Changes state, since_us, judged_us, streak_us, the counters, fires and flapping. An acknowledgement ends
/// where the alarm begins to fire anew, or becomes inactive. All else is left as it is.
///
/// @param at_us      ended_us of the run
AlarmStatus advance(const AlarmStatus& before, bool bad, const AlarmDelays& delays, std::int64_t at_us);

}  // namespace ballbar
