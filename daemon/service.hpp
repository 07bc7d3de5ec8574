#pragma once
/// The way of a run through the house: analyse, judge, commit, publish. Used by the service and by `ballbar
/// replay` alike.

#include <deque>
#include <functional>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "bus/publisher.hpp"
#include "core/alarm.hpp"
#include "core/gap_record.hpp"
#include "core/recognition.hpp"
#include "daemon/alarm_book.hpp"
#include "daemon/config.hpp"
#include "daemon/log.hpp"
#include "physics/as_built.hpp"
#include "pipeline/process.hpp"
#include "rules/rule_set.hpp"
#include "store/store.hpp"

namespace ballbar {

using Models = std::map<std::string, AsBuilt>;

/// Every configured robot: nominal kinematics, and the effects that are known of it.
/// @throws Error(kInput) with robot and URDF path
Models load_models(const Config& config);

/// Recognises the circles of robots that send no marks. `models` stays the caller's; what is made has its own
/// copy.
MakeRecogniser recogniser_of(const Models& models);

/// The configured rules. A folder that cannot be read is one error in the report, and the last good rules
/// stay.
LoadReport load_rules(const Config& config, const RuleSet* last_good = nullptr);

struct ServiceCounters {
  std::int64_t runs_stored = 0;
  std::int64_t runs_ok = 0;
  std::int64_t runs_known = 0;  ///< came again (a log played twice): not stored a second time
  std::int64_t store_failures = 0;
  std::int64_t diagnoses = 0;  ///< of series, stored
};

class Service {
 public:
  using Log = std::function<void(Priority, const std::string&)>;

  Service(Config config, Models models, RuleSet rules, Store& store, Log log);

  /// Analyses, judges, commits in one transaction, then publishes. Where the commit fails the run waits in
  /// memory and is tried again by retry().
  void on_run(Run run);

  /// Behind those that wait; retry() takes it up.
  void enqueue(Run run);

  /// The robot's baseline "calibration" begins anew. It waits as runs do; retry() stores it.
  void on_calibration(BaselineMark mark);

  /// Judges what no run can tell: silence and losses. About once a minute.
  /// @param now_us  the daemon's clock
  void on_time(std::int64_t now_us);

  /// The store is another one, new and empty.
  void on_new_store() {
    store_damaged_ = false;
    alarms_.on_new_store();
  }
  /// The daemon's clock was set: what was known about silence by the old one is read again.
  void on_clock_set() {
    watched_since_us_ = 0;
    last_ok_us_.clear();
  }

  /// Tries to commit the runs that wait. @param most_us  no further one is begun after this time: the caller
  /// has other work
  void retry(std::uint64_t most_us = UINT64_MAX);

  /// Is told of every run that was stored, and what it was.
  using Stored = std::function<void(const Run&, const RunResult&)>;
  void on_stored(Stored stored) { stored_ = std::move(stored); }

  /// The diagnosis of a series: commits, then publishes. Where the commit fails it waits as runs do.
  void on_gap(StoredGap gap);

  /// Null: nothing is published.
  void publish_to(std::unique_ptr<Publisher> publisher) { publisher_ = std::move(publisher); }
  Publisher* publisher() { return publisher_.get(); }

  void publish_active_alarms();
  void configure(Config config, Models models) {
    config_ = std::move(config);
    models_ = std::move(models);
  }

  /// Takes another set of rules.
  /// @param complete  every file was read: alarms of rules that are gone go to inactive
  /// @param at_us     the daemon's clock
  void replace_rules(RuleSet rules, bool complete, std::int64_t at_us);

  const Config& config() const { return config_; }
  const Models& models() const { return models_; }
  const RuleSet& rules() const { return rules_; }
  const ServiceCounters& counters() const { return counters_; }
  std::size_t waiting() const { return waiting_.size(); }
  bool waits() const { return !waiting_.empty() || !waiting_calibrations_.empty(); }
  /// The database could not be written: trying again is for the clock.
  bool stuck() const { return !said_.empty(); }
  /// "3 runs and 1 calibration", what is in memory alone; empty where all is stored
  std::string unstored() const;
  AlarmBook& alarms() { return alarms_; }
  int alarms_firing() const { return alarms_.firing(); }
  bool store_damaged() const { return store_damaged_; }  ///< runs wait because SQLite found damage
  const std::map<std::string, std::string>& rule_errors() const {
    return rule_errors_;
  }  ///< by rule, the last one

 private:
  struct Judged {
    std::vector<AlarmStatus> states;
    std::vector<AlarmEvent> events;
  };

  void take(Run& run);
  std::size_t waiting_bytes() const;
  void retry_gaps();
  void store_can_be_written();
  bool retry_calibrations(std::uint64_t until_us);
  void tell(const StoredGap& gap);
  void judge(const GapRecord& gap);
  RunResult analyse(Run& run) const;
  Partners partners_of(const Run& run) const;
  Judged judge(const Run& run, const RunResult& result, const std::vector<Record>& records);
  void judge(const Record& subject, Past& past, const std::vector<AlarmStatus>& states, std::int64_t at_us,
             Judged& judged);
  void take_verdict(Judged judged);
  void note_last(const std::string& robot, const std::string& test, std::int64_t ended_us);
  void tell(const Run& run, const RunResult& result, const std::vector<Record>& records,
            const Judged& judged);

  Config config_;
  Models models_;
  RuleSet rules_;
  Store& store_;
  Log log_;
  Stored stored_;
  std::unique_ptr<Publisher> publisher_;
  AlarmBook alarms_;
  std::map<std::string, std::string> rule_errors_;
  std::map<std::string, std::map<std::string, std::int64_t>> last_ok_us_;  // by robot and test; test "": any
  std::int64_t watched_since_us_ = 0;
  std::deque<Run> waiting_;
  std::deque<StoredGap> waiting_gaps_;
  std::deque<BaselineMark> waiting_calibrations_;
  std::string said_;       ///< last, about the runs that wait
  std::string said_gaps_;  ///< likewise, of diagnoses
  bool store_damaged_ = false;
  ServiceCounters counters_;
};

}  // namespace ballbar
