#include "daemon/backtest.hpp"

#include <algorithm>
#include <iterator>
#include <memory>
#include <set>

#include "daemon/service.hpp"
#include "rules/clock_alarm.hpp"
#include "rules/past_records.hpp"
#include "rules/subjects.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kBacktestDayUs = 86'400'000'000;
constexpr std::int64_t kBacktestMinuteUs = 60'000'000;

std::vector<AlarmStatus> states_of(const std::map<AlarmKey, AlarmStatus>& alarms) {
  std::vector<AlarmStatus> states;
  states.reserve(alarms.size());
  for (const auto& [key, status] : alarms) states.push_back(status);
  return states;
}

/// What the clock's rules are told of one robot.
struct RobotTimes {
  std::map<std::string, std::set<std::int64_t>> good_us;  ///< ends of "ok" runs; by test, "": of any
  std::vector<StoredRun> runs;                            ///< all, by begin; only their counts
};

class StoreBacktest {
 public:
  StoreBacktest(const RuleSet& rules, const Store& store, const BacktestPeriod& period, const Rule* watched)
      : rules_(rules), store_(store), period_(period), watched_(watched) {}

  BacktestReport report() {
    judge_runs();
    judge_gaps();
    if (from_us_) judge_clock();
    std::stable_sort(found_.changes.begin(), found_.changes.end(),
                     [](const auto& a, const auto& b) { return a.moved_us < b.moved_us; });
    return std::move(found_);
  }

 private:
  bool inside(std::int64_t time_us) const {
    return time_us >= period_.since_us.value_or(INT64_MIN) && time_us < period_.until_us;
  }

  void watch(const Record& record, const std::map<AlarmKey, AlarmStatus>& alarms) {
    if (watched_ == nullptr || !applies(*watched_, record)) return;
    const auto alarm =
        alarms.find({watched_->name, record.robot, record.test, record.direction, record.axis});
    if (alarm != alarms.end()) found_.asked.emplace_back(record, alarm->second.state);
  }

  void add_errors(const std::map<RuleError, int>& errors) {
    for (const auto& [error, count] : errors) found_.errors[error] += count;
  }

  /// The period begins no later than that, where nobody has said when.
  void begins(std::int64_t time_us) { from_us_ = std::min(from_us_.value_or(time_us), time_us); }

  void judge_runs() {
    RunFilter filter;
    filter.harmonic_orders = kAllHarmonicOrders;
    if (!period_.robot.empty()) filter.robot = period_.robot;
    // A day more, for what was lost within one.
    if (period_.since_us) filter.since_us = *period_.since_us - kBacktestDayUs;
    filter.until_us = period_.until_us;
    from_us_ = period_.since_us;
    RunBacktest runs(rules_, store_);
    for (StoredRun& run : store_.runs(filter)) {
      if (inside(run.started_us)) {
        begins(run.started_us);
        judge(run, runs);
      }
      note(std::move(run));
    }
    add_errors(runs.errors());
  }

  void judge(const StoredRun& run, RunBacktest& runs) {
    if (run.status != "ok") return;
    ++found_.runs;
    runs.feed(run, [&](const Record& subject, const AlarmEvent& event) {
      found_.changes.push_back(
          {run.started_us, event.status.since_us, subject_name(run, subject), subject, event});
    });
    for (const Record& record : run.records)
      for (const Record& subject : subjects_of(record)) watch(subject, runs.alarms());
  }

  void note(StoredRun run) {
    RobotTimes& times = times_[run.robot];
    if (run.status == "ok")
      for (const std::string& test : {run.test, std::string()}) times.good_us[test].insert(run.ended_us);
    run.records.clear();
    run.harmonics.clear();
    run.gap_harmonics.clear();
    times.runs.push_back(std::move(run));
  }

  void judge_gaps() {
    GapFilter filter;
    if (!period_.robot.empty()) filter.robot = period_.robot;
    std::map<AlarmKey, AlarmStatus> alarms;
    for (const StoredGap& gap : store_.gaps(filter)) {
      if (!inside(gap.record.ended_us)) continue;
      begins(gap.record.ended_us);
      ++found_.diagnoses;
      const Record record = gap_record(gap.record);
      PastRecords past(record, History{});
      const EvaluateResult verdict = rules_.evaluate(record, past, states_of(alarms), gap.record.ended_us);
      for (const AlarmStatus& status : verdict.statuses) alarms[status.key] = status;
      for (const RuleError& error : verdict.errors) ++found_.errors[error];
      for (const AlarmEvent& event : verdict.events)
        found_.changes.push_back({gap.record.ended_us, gap.record.ended_us,
                                  record.robot + " series " + record.series, record, event});
      watch(record, alarms);
    }
  }

  void judge_clock() {
    for (const RobotSpec& robot : period_.known) {
      if (!period_.robot.empty() && robot.name != period_.robot) continue;
      for (const TestSpec& test : robot.tests) times_[robot.name].good_us[test.name];
    }
    for (const LastRun& last : store_.last_runs())
      if (period_.robot.empty() || last.robot == period_.robot) times_[last.robot].good_us[last.test];
    for (auto& [robot, times] : times_) {
      times.good_us[""];
      for (auto& [test, good_us] : times.good_us) note_last_before(robot, test, good_us);
      for (const Rule& rule : rules_.rules()) {
        if (rule.kind == "loss") ask_losses(rule, robot, times);
        for (const auto& [test, good_us] : times.good_us)
          if (rule.kind == "silence") ask_silence(rule, robot, test, good_us);
      }
    }
  }

  void note_last_before(const std::string& robot, const std::string& test, std::set<std::int64_t>& good_us) {
    RunFilter filter;
    filter.robot = robot;
    if (!test.empty()) filter.test = test;
    filter.status = "ok";
    filter.until_us = *from_us_;
    filter.newest_first = true;
    filter.limit = 1;
    for (const StoredRun& run : store_.runs(filter)) good_us.insert(run.ended_us);
  }

  void ask_silence(const Rule& rule, const std::string& robot, const std::string& test,
                   const std::set<std::int64_t>& good_us) {
    const auto record_at = [&](std::int64_t now_us) {
      const auto later = good_us.upper_bound(now_us);
      return silence_record(robot, test, now_us, later == good_us.begin() ? *from_us_ : *std::prev(later));
    };
    ask_clock(rule, record_at, {good_us.begin(), good_us.end()});
  }

  void ask_losses(const Rule& rule, const std::string& robot, const RobotTimes& times) {
    const auto record_at = [&](std::int64_t now_us) {
      Losses losses;
      const auto first = std::lower_bound(
          times.runs.begin(), times.runs.end(), now_us - kBacktestDayUs,
          [](const StoredRun& run, std::int64_t since_us) { return run.started_us < since_us; });
      for (auto run = first; run != times.runs.end() && run->started_us <= now_us; ++run) {
        if (run->ended_us > now_us) continue;
        ++losses.runs;
        losses.runs_failed += run->status == "ok" ? 0 : 1;
        losses.lost_messages += run->lost_messages;
        losses.receiver_restarts += run->receiver_restarts;
      }
      return loss_record(robot, now_us, losses);
    };
    std::vector<std::int64_t> happened_us;
    happened_us.reserve(2 * times.runs.size());
    for (const StoredRun& run : times.runs) {
      happened_us.push_back(run.ended_us);
      happened_us.push_back(run.started_us + kBacktestDayUs);
    }
    ask_clock(rule, record_at, happened_us);
  }

  void ask_clock(const Rule& rule, const std::function<Record(std::int64_t)>& record_at,
                 const std::vector<std::int64_t>& happened_us) {
    if (!applies(rule, record_at(period_.until_us))) return;
    ClockVerdict verdict = clock_alarm(rule, {*from_us_, period_.until_us}, record_at, happened_us);
    add_errors(verdict.errors);
    if (watched_ != nullptr && watched_->name == rule.name) watch_clock(verdict, record_at, happened_us);
    for (ClockChange& change : verdict.changes) {
      const std::int64_t at_us = change.record.started_us;
      const std::string subject =
          change.record.robot + (change.record.test.empty() ? "" : " ") + change.record.test;
      found_.changes.push_back({at_us, at_us, subject, std::move(change.record), std::move(change.event)});
    }
  }

  /// The corners of what the rule was asked: between them its figures go straight or stand still.
  void watch_clock(const ClockVerdict& verdict, const std::function<Record(std::int64_t)>& record_at,
                   const std::vector<std::int64_t>& happened_us) {
    std::set<std::int64_t> corners{*from_us_, period_.until_us};
    const auto corner = [&](std::int64_t time_us) {
      for (const std::int64_t at_us : {time_us - kBacktestMinuteUs, time_us})
        if (at_us > *from_us_ && at_us < period_.until_us) corners.insert(at_us);
    };
    for (const std::int64_t time_us : happened_us) corner(time_us);
    for (const ClockChange& change : verdict.changes) corner(change.record.started_us);
    AlarmState state = AlarmState::kInactive;
    auto next = verdict.changes.begin();
    for (const std::int64_t at_us : corners) {
      for (; next != verdict.changes.end() && next->record.started_us <= at_us; ++next)
        state = next->event.status.state;
      found_.asked.emplace_back(record_at(at_us), state);
    }
  }

  const RuleSet& rules_;
  const Store& store_;
  const BacktestPeriod& period_;
  const Rule* watched_;
  BacktestReport found_;
  std::optional<std::int64_t> from_us_;
  std::map<std::string, RobotTimes> times_;
};

}  // namespace

std::string subject_name(const StoredRun& run, const Record& subject) {
  const std::string what = subject.kind == "test" ? run.test + " (both directions)"
                                                  : run_name(run.test, run.direction, run.repetition);
  return run.robot + " " + what + (subject.axis.empty() ? "" : " " + subject.axis);
}

void RunBacktest::feed(const StoredRun& run,
                       const std::function<void(const Record&, const AlarmEvent&)>& changed) {
  for (const Record& record : run.records) {
    for (const Record& subject : subjects_of(record)) {
      const std::unique_ptr<Past> past = store_.past(subject);
      const EvaluateResult verdict = rules_.evaluate(subject, *past, states_of(alarms_), run.ended_us);
      for (const AlarmStatus& status : verdict.statuses) alarms_[status.key] = status;
      for (const RuleError& error : verdict.errors) ++errors_[error];
      for (const AlarmEvent& event : verdict.events) changed(subject, event);
    }
  }
}

BacktestReport backtest(const RuleSet& rules, const Store& store, const BacktestPeriod& period,
                        const Rule* watched) {
  return StoreBacktest(rules, store, period, watched).report();
}

}  // namespace ballbar
