#pragma once
/// What a set of rules would have said of what is stored.

#include <cstdint>
#include <functional>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/spec.hpp"
#include "rules/rule_set.hpp"
#include "store/store.hpp"

namespace ballbar {

/// Alarms as runs move them, one after another, from none.
class RunBacktest {
 public:
  RunBacktest(const RuleSet& rules, const Store& store) : rules_(rules), store_(store) {}

  /// Judges a run; `changed` hears of each state that changes.
  void feed(const StoredRun& run, const std::function<void(const Record&, const AlarmEvent&)>& changed);

  const std::map<AlarmKey, AlarmStatus>& alarms() const { return alarms_; }
  const std::map<RuleError, int>& errors() const { return errors_; }  ///< and how often

 private:
  const RuleSet& rules_;
  const Store& store_;
  std::map<AlarmKey, AlarmStatus> alarms_;
  std::map<RuleError, int> errors_;
};

struct BacktestPeriod {
  std::optional<std::int64_t> since_us;  ///< else from the first stored run or diagnosis on
  std::int64_t until_us = 0;
  std::string robot;             ///< empty: all
  std::vector<RobotSpec> known;  ///< silence and losses of these, beside those that are stored
};

/// One state of an alarm that changed, and what the rule was asked then.
struct BacktestChange {
  std::int64_t at_us = 0;     ///< begin of the run, end of the diagnosis, the minute of the clock
  std::int64_t moved_us = 0;  ///< what the changes are sorted by
  std::string subject;        ///< for people: "lrmate-1 A+1#7", "lrmate-1 series morning", "lrmate-1"
  Record record;
  AlarmEvent event;
};

struct BacktestReport {
  std::vector<BacktestChange> changes;  ///< by time
  std::map<RuleError, int> errors;      ///< and how often
  std::int64_t runs = 0, diagnoses = 0;
  std::vector<std::pair<Record, AlarmState>> asked;  ///< what `watched` was asked, and its alarm behind it
};

/// Runs all rules over the period: runs and diagnoses as they are stored, silence and losses as the service
/// asks them, each minute by the clock. Nothing is known of the alarms before the period; of silence and
/// losses, and by what rules look back at, also what lies before it counts.
/// @param watched  may be null: nothing is kept of what it was asked
BacktestReport backtest(const RuleSet& rules, const Store& store, const BacktestPeriod& period,
                        const Rule* watched);

/// "lrmate-1 A+1#7", "lrmate-1 A (both directions)", "lrmate-1 Y+1#1 X"
std::string subject_name(const StoredRun& run, const Record& subject);

}  // namespace ballbar
