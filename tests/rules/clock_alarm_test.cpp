// What rules on silence and loss would have said, against a twin that asks every rule each minute.

#include "rules/clock_alarm.hpp"

#include <gtest/gtest.h>

#include <random>
#include <set>

#include "rules/rule_set.hpp"
#include "rules/subjects.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kMinute = 60'000'000;
constexpr std::int64_t kHour = 60 * kMinute;

std::string told(const AlarmEvent& event, std::int64_t at_us) {
  return std::to_string(at_us / kMinute) + " " + to_string(event.from) + " -> " +
         to_string(event.status.state) + " " + event.status.text + "\n";
}

RuleSet one_rule(const std::string& on, const std::string& needs, const std::string& more) {
  LoadReport report = RuleSet::load({{"x.lua", "return { name = 'x', on = '" + on + "', needs = { '" + needs +
                                                   "' },\ntext = '{" + needs + "}',\n" + more + " }"}});
  for (const RuleError& error : report.errors) ADD_FAILURE() << to_string(error);
  return report.rules;
}

std::string each_minute(const RuleSet& rules, const ClockPeriod& period,
                        const std::function<Record(std::int64_t)>& record_at) {
  std::string all;
  std::vector<AlarmStatus> states;
  for (std::int64_t now_us = period.since_us + kMinute; now_us <= period.until_us; now_us += kMinute) {
    const EvaluateResult verdict = rules.evaluate(record_at(now_us), History{}, states, now_us);
    for (const AlarmEvent& event : verdict.events) all += told(event, now_us);
    if (!verdict.statuses.empty()) states = verdict.statuses;
  }
  return all;
}

std::string searched(const RuleSet& rules, const ClockPeriod& period,
                     const std::function<Record(std::int64_t)>& record_at,
                     const std::vector<std::int64_t>& happened_us) {
  std::string all;
  for (const ClockChange& change : clock_alarm(rules.rules().front(), period, record_at, happened_us).changes)
    all += told(change.event, change.record.started_us);
  return all;
}

// Thirty good runs in twelve days, at random; for each of these rules, however it counts, waits and flaps.
TEST(ClockAlarm, SilenceIsFoundAtTheMinuteThatATwinWhoAsksEachMinuteFinds) {
  std::mt19937_64 rng(11);
  std::set<std::int64_t> ended_us;
  for (int run = 0; run < 30; ++run)
    ended_us.insert(std::uniform_int_distribution<std::int64_t>(0, 12 * 24 * kHour)(rng));
  const ClockPeriod period{17, 14 * 24 * kHour};
  const auto record_at = [&](std::int64_t now_us) {
    const auto later = ended_us.upper_bound(now_us);
    return silence_record("r", "", now_us, later == ended_us.begin() ? period.since_us : *std::prev(later));
  };
  const std::string when = "when = function(r, h, rule) return r.hours_since_last > rule.limit_hours end";
  for (const std::string& more : std::vector<std::string>{
           "limit_hours = 7.3, hold_runs = 1, keep_runs = 0, ",
           "limit_hours = 3, hold_runs = 5, keep_runs = 40, ",
           "limit_hours = 2, hold_s = 7200, keep_s = 5000, ",
           "limit_hours = 0.9, flap_fires = 2, flap_runs = 60, ",
       }) {
    const RuleSet rules = one_rule("silence", "hours_since_last", more + when);
    const std::string expected = each_minute(rules, period, record_at);
    EXPECT_NE(expected.find("firing"), std::string::npos) << "else this tells nothing";
    EXPECT_EQ(searched(rules, period, record_at, {ended_us.begin(), ended_us.end()}), expected)
        << more << "seed 11";
  }
}

TEST(ClockAlarm, LossesComeAndGoWithTheRunsOfADay) {
  std::mt19937_64 rng(12);
  std::vector<std::int64_t> at_us;
  for (int run = 0; run < 40; ++run)
    at_us.push_back(std::uniform_int_distribution<std::int64_t>(0, 8 * 24 * kHour)(rng));
  const ClockPeriod period{0, 10 * 24 * kHour};
  const auto record_at = [&](std::int64_t now_us) {
    Losses losses;
    for (const std::int64_t time_us : at_us)
      if (time_us <= now_us && time_us >= now_us - 24 * kHour) losses.lost_messages += 20;
    return loss_record("r", now_us, losses);
  };
  std::vector<std::int64_t> happened_us;
  for (const std::int64_t time_us : at_us)
    happened_us.insert(happened_us.end(), {time_us, time_us + 24 * kHour});
  const RuleSet rules =
      one_rule("loss", "lost_messages", "keep_runs = 0, when = function(r) return r.lost_messages > 100 end");
  const std::string expected = each_minute(rules, period, record_at);
  EXPECT_NE(expected.find("firing -> resolved"), std::string::npos) << "else this tells nothing";
  EXPECT_EQ(searched(rules, period, record_at, happened_us), expected) << "seed 12";
}

TEST(ClockAlarm, ARuleThatFailsIsAnErrorAndMovesNothing) {
  const RuleSet rules = one_rule("silence", "hours_since_last",
                                 "when = function(r) return r.hours_since_last < 5 or nil + 1 end");
  const ClockVerdict verdict =
      clock_alarm(rules.rules().front(), {0, 24 * kHour},
                  [](std::int64_t now_us) { return silence_record("r", "", now_us, 0); }, {});
  ASSERT_EQ(verdict.errors.size(), 1u);
  EXPECT_NE(to_string(verdict.errors.begin()->first).find("x.lua:3: "), std::string::npos)
      << to_string(verdict.errors.begin()->first);
  ASSERT_EQ(verdict.changes.size(), 1u);
  EXPECT_EQ(verdict.changes.front().event.status.state, AlarmState::kFiring);
}

}  // namespace
}  // namespace ballbar
