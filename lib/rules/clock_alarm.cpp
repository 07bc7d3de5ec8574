#include "rules/clock_alarm.hpp"

#include <algorithm>
#include <set>

#include "rules/alarm_machine.hpp"
#include "rules/past_records.hpp"
#include "rules/sandbox.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kMinuteUs = 60'000'000;
constexpr std::int64_t kMinutesPerHour = 60;

enum class ClockAnswer { kGood, kBad, kError };

class ClockWalk {
 public:
  ClockWalk(const Rule& rule, const ClockPeriod& period, const std::function<Record(std::int64_t)>& record_at)
      : rule_(rule), since_us_(period.since_us), record_at_(record_at) {}

  void walk(const std::set<std::int64_t>& minutes) {
    std::int64_t last = 0;
    ClockAnswer before = ClockAnswer::kGood;
    for (const std::int64_t minute : minutes) {
      const ClockAnswer answer = ask(minute).first;
      const std::int64_t turn = last == 0 || answer == before ? last + 1 : turns(last, minute, before);
      move(last + 1, turn - 1, before);
      move(turn, minute, answer);
      last = minute;
      before = answer;
    }
  }

  ClockVerdict verdict;

 private:
  std::int64_t time_of_minute(std::int64_t minute) const { return since_us_ + minute * kMinuteUs; }

  std::pair<ClockAnswer, Judgement> ask(std::int64_t minute) {
    const Record record = record_at_(time_of_minute(minute));
    PastRecords past(record, History{});
    try {
      Judgement judgement = judge(rule_, record, past);
      return {judgement.bad ? ClockAnswer::kBad : ClockAnswer::kGood, std::move(judgement)};
    } catch (const ScriptError& error) {
      ++verdict.errors[{rule_.name, rule_.source.file, error.line(), error.what()}];
      return {ClockAnswer::kError, {}};
    }
  }

  /// The first minute after `from` whose answer is another, up to `to`, whose is.
  std::int64_t turns(std::int64_t from, std::int64_t to, ClockAnswer at_from) {
    while (to - from > 1) {
      const std::int64_t middle = from + (to - from) / 2;
      (ask(middle).first == at_from ? from : to) = middle;
    }
    return to;
  }

  /// Minutes from..to, all of one answer.
  void move(std::int64_t from, std::int64_t to, ClockAnswer answer) {
    if (answer == ClockAnswer::kError) return;
    const bool bad = answer == ClockAnswer::kBad;
    for (std::int64_t minute = from; minute <= to; ++minute) {
      const AlarmState was = alarm_.state;
      alarm_ = advance(alarm_, bad, delays_of(rule_), time_of_minute(minute));
      if (alarm_.state != was) changed(minute, was);
      // What neither moves nor remembers when it began to fire stays as it is.
      const bool rests = alarm_.state == (bad ? AlarmState::kFiring : AlarmState::kInactive);
      if (rests && minute - from > kMaxFlapRuns) break;
    }
    if (bad && from <= to) remember(to);
  }

  /// What the latest bad minute said, as the service keeps it.
  void remember(std::int64_t minute) {
    const Judgement judgement = ask(minute).second;
    alarm_.text = judgement.text;
    alarm_.numbers = judgement.numbers;
  }

  void changed(std::int64_t minute, AlarmState from) {
    const Record record = record_at_(time_of_minute(minute));
    if (alarm_.bad_runs > 0) remember(minute);
    alarm_.key = {rule_.name, record.robot, record.test, record.direction, record.axis};
    alarm_.severity = rule_.severity;
    verdict.changes.push_back({{alarm_, from, record.started_us}, record});
  }

  const Rule& rule_;
  std::int64_t since_us_;
  const std::function<Record(std::int64_t)>& record_at_;
  AlarmStatus alarm_;
};

}  // namespace

ClockVerdict clock_alarm(const Rule& rule, const ClockPeriod& period,
                         const std::function<Record(std::int64_t)>& record_at,
                         const std::vector<std::int64_t>& happened_us) {
  const std::int64_t last = (period.until_us - period.since_us) / kMinuteUs;
  std::set<std::int64_t> minutes;
  const auto look = [&](std::int64_t minute) {
    if (minute >= 1 && minute <= last) minutes.insert(minute);
  };
  look(1);
  look(last);
  for (std::int64_t minute = kMinutesPerHour; minute < last; minute += kMinutesPerHour) look(minute);
  for (const std::int64_t time_us : happened_us) {
    const std::int64_t minute = (time_us - period.since_us) / kMinuteUs;
    look(minute);
    look(minute + 1);
  }
  ClockWalk walk(rule, period, record_at);
  walk.walk(minutes);
  return std::move(walk.verdict);
}

}  // namespace ballbar
