/// What rules are asked about that is no run: silence, losses, a diagnosis.

#include <algorithm>

#include "daemon/service.hpp"
#include "rules/past_records.hpp"
#include "rules/subjects.hpp"

namespace ballbar {
namespace {

bool watches(const RuleSet& rules, const std::string& kind) {
  return std::any_of(rules.rules().begin(), rules.rules().end(),
                     [&](const Rule& rule) { return rule.kind == kind; });
}

}  // namespace

void Service::note_last(const std::string& robot, const std::string& test, std::int64_t ended_us) {
  for (const std::string& name : {test, std::string()}) {
    std::int64_t& last = last_ok_us_[robot][name];
    last = std::max(last, ended_us);
  }
}

void Service::on_time(std::int64_t now_us) {
  constexpr std::int64_t kDayUs = 86'400'000'000;
  alarms_.look();
  if (watched_since_us_ == 0) {
    watched_since_us_ = now_us;
    try {
      for (const LastRun& last : store_.last_runs(now_us)) note_last(last.robot, last.test, last.ended_us);
    } catch (const StoreError& error) {
      watched_since_us_ = 0;  // asked again
      return log_(Priority::kError, std::string("silence not judged: ") + error.what());
    }
  }
  if (!watches(rules_, "silence") && !watches(rules_, "loss")) return;
  const std::vector<AlarmStatus> states = alarms_.states();
  Judged judged;
  const auto ask = [&](const Record& record) {
    PastRecords past(record, History{});
    judge(record, past, states, now_us, judged);
  };
  try {
    for (const RobotSpec& robot : config_.robots) {
      const DayCounts day = store_.counts_between(robot.name, now_us - kDayUs, now_us);
      ask(loss_record(robot.name, now_us,
                      {day.runs, day.runs_failed, day.lost_messages, day.receiver_restarts}));
      const auto ask_silence = [&](const std::string& test) {
        auto& last = last_ok_us_[robot.name];
        const auto found = last.find(test);
        // A controller whose clock is ahead has measured by now, not in a year.
        if (found != last.end()) found->second = std::min(found->second, now_us);
        // What was never measured has been silent for as long as we have listened.
        ask(silence_record(robot.name, test, now_us,
                           found != last.end() ? found->second : watched_since_us_));
      };
      ask_silence("");
      for (const TestSpec& test : robot.tests) ask_silence(test.name);
    }
    take_verdict(std::move(judged));
  } catch (const StoreError& error) {
    ++counters_.store_failures;
    log_(Priority::kError, std::string("silence and losses not judged: ") + error.what());
  }
}

void Service::judge(const GapRecord& gap) {
  const Record record = gap_record(gap);
  Judged judged;
  PastRecords past(record, History{});
  judge(record, past, alarms_.states(), gap.ended_us, judged);
  take_verdict(std::move(judged));
}

/// Stored only where a state changed: the clock asks every minute.
void Service::take_verdict(Judged judged) {
  if (judged.events.empty()) return alarms_.stand(judged.states);
  alarms_.number(judged.states, judged.events);
  alarms_.change(judged.states, judged.events);
}

}  // namespace ballbar
