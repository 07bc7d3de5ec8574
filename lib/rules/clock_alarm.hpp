#pragma once
/// What a rule on silence or loss would have said over a time that is past.

#include <cstdint>
#include <functional>
#include <map>
#include <vector>

#include "rules/rule.hpp"
#include "rules/rule_set.hpp"

namespace ballbar {

struct ClockPeriod {
  std::int64_t since_us = 0;  ///< the rule is asked each minute after it ...
  std::int64_t until_us = 0;  ///< ... up to here
};

/// One state of the alarm, from the minute at which it began.
struct ClockChange {
  AlarmEvent event;
  Record record;  ///< what the rule was asked then
};

struct ClockVerdict {
  std::vector<ClockChange> changes;
  std::map<RuleError, int> errors;  ///< and at how many of the asked minutes
};

/// Moves one alarm as the service does, that asks each minute, but asks the script itself only each hour and
/// about the moments at which something happened, and searches for the minute in between at which its answer
/// changed. So a rule whose answer changes and changes back within an hour, with nothing happening, is not
/// seen to do so.
/// @param record_at    what the rule is asked at a time; the rule applies to it
/// @param happened_us  when what record_at says changes other than by the passing of time, in any sequence
ClockVerdict clock_alarm(const Rule& rule, const ClockPeriod& period,
                         const std::function<Record(std::int64_t now_us)>& record_at,
                         const std::vector<std::int64_t>& happened_us);

}  // namespace ballbar
