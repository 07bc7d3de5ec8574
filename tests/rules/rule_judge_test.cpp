#include <gtest/gtest.h>

#include <algorithm>
#include <limits>

#include "rules/test_records.hpp"

namespace ballbar {
namespace {

using test::circle;
using test::rule_source;

Judgement ask(const std::string& condition, const Record& record, const std::string& more = "",
              const History& history = {}) {
  return judge(parse_rule(rule_source("x", condition, more)), record, history);
}

std::string ask_badly(const std::string& condition, const Record& record, const std::string& more = "") {
  return test::outcome([&] { ask(condition, record, more); });
}

TEST(Judge, TellsBadFromGood) {
  EXPECT_TRUE(ask("result.ovality_um > rule.limit_um", circle({{"ovality_um", 26.0}}), "limit_um = 25").bad);
  EXPECT_FALSE(ask("result.ovality_um > rule.limit_um", circle({{"ovality_um", 25.0}}), "limit_um = 25").bad);
}

TEST(Judge, FillsTheTextOfABadRunWithValuesLabelsFieldsAndWhatTheRuleGives) {
  const Judgement judgement = ask("true, { over_um = 1.0 / 3.0 }", circle({{"ovality_um", 184.26}}),
                                  "limit_um = 25.0, gives = { 'over_um' }, text = '{test} {direction}: "
                                  "{ovality_um} um, {over_um} over {limit_um} um'");
  EXPECT_EQ(judgement.text, "A +1: 184.3 um, 0.333 over 25 um");
}

TEST(Judge, LeavesTheTextOfAGoodRunEmpty) { EXPECT_EQ(ask("false", circle({{"ovality_um", 1.0}})).text, ""); }

TEST(Judge, ShowsLabelsToTheRule) {
  EXPECT_TRUE(ask("result.robot == 'r1' and result.test == 'A' and result.kind == 'circle' and result.series "
                  "== 's' and "
                  "result.direction == 1 and result.repetition == 1 and result.started_us == 1000000 and "
                  "result.axis == '' and "
                  "result.status == 'ok'",
                  circle({{"ovality_um", 1.0}}))
                  .bad);
}

TEST(Judge, AMissingQuantityThatIsNeededIsAnErrorAtItsLine) {
  EXPECT_EQ(ask_badly("true", circle({{"noise_um", 1.0}})),
            "1: needs 'ovality_um', which this run does not have");
  EXPECT_EQ(ask_badly("true", circle({{"ovality_um", std::numeric_limits<double>::quiet_NaN()}})),
            "1: needs 'ovality_um', which is not finite in this run");
}

TEST(Judge, AQuantityThatIsNotNeededMayBeMissing) {
  EXPECT_TRUE(ask("result.temperature_c == nil", circle({{"ovality_um", 1.0}})).bad);
  EXPECT_EQ(ask("true", circle({{"ovality_um", 1.0}}), "text = 'at {temperature_c}'").text, "at (not known)");
}

TEST(Judge, AMisspeltNameInWhenIsAnErrorAndNotNil) {
  EXPECT_EQ(ask_badly("result.ovalty_um > 3", circle({{"ovality_um", 1.0}})),
            "2: a circle has no 'ovalty_um'; did you mean 'ovality_um'?");
  EXPECT_EQ(ask_badly("result.ovality_um > rule.limt_um", circle({{"ovality_um", 1.0}}), "limit_um = 3"),
            "2: the rule has no 'limt_um'");
}

TEST(Judge, WhenMustAnswerTrueOrFalse) {
  EXPECT_EQ(ask_badly("nil", circle({{"ovality_um", 1.0}})), "2: when must return true or false, not nil");
  EXPECT_EQ(ask_badly("result.ovality_um", circle({{"ovality_um", 1.0}})),
            "2: when must return true or false, not number");
}

TEST(Judge, WhatARuleGivesMustBeThereAndFiniteWhereItIsBad) {
  const Record record = circle({{"ovality_um", 1.0}});
  const std::string gives = "gives = { 'drift_um' }";
  EXPECT_EQ(ask_badly("false", record, gives), "fine");
  EXPECT_EQ(ask_badly("true", record, gives),
            "2: when must return a table with 'drift_um' as its second value, as gives says");
  const char* not_finite =
      "2: when must return a finite number 'drift_um' in its second value, as gives says";
  EXPECT_EQ(ask_badly("true, {}", record, gives), not_finite);
  EXPECT_EQ(ask_badly("true, { drift_um = 0/0 }", record, gives), not_finite);
  EXPECT_EQ(ask_badly("true, { drift_um = '3' }", record, gives), not_finite);
}

// A limit for the bar says nothing of what the controller believes, which is nearly perfect.
TEST(Judge, TheVirtualBallbarIsShownOnlyToRulesThatAskForIt) {
  const std::pair<std::string, std::vector<std::string>> table[] = {
      {"", {"bar", ""}},
      {"where = { source = \"bar\" }", {"bar"}},
      {"where = { source = \"joints\" }", {"joints"}},
      {"where = { test = \"A\" }", {"bar", ""}},
  };
  for (const auto& [where, seen] : table) {
    const Rule rule = parse_rule(test::rule_source("r", "true", where));
    for (const std::string source : {"bar", "joints", ""}) {
      Record record = circle({{"ovality_um", 1.0}});
      record.source = source;
      EXPECT_EQ(applies(rule, record), std::find(seen.begin(), seen.end(), source) != seen.end())
          << where << ": " << source;
    }
  }
}

TEST(Judge, HistoryHoldsTheOkResultsOldestFirst) {
  History history;
  for (int i = 1; i <= 100; ++i) {
    Record record = circle({{"ovality_um", static_cast<double>(i)}});
    if (i == 2) record.status = "too_few_samples";
    history.recent.push_back(record);
    if (i <= 30) history.series_first.push_back(record);
  }
  const std::string condition =
      "error(#history.series_first .. ' ' .. history.series_first[2].ovality_um .. ' ' .. #history.recent .. "
      "' ' .. "
      "history.recent[1].ovality_um .. ' ' .. history.recent[#history.recent].ovality_um, 0)";
  EXPECT_EQ(test::outcome([&] {
              ask(condition, circle({{"ovality_um", 1.0}}), "", history);
            }),
            "2: 20 3.0 50 51.0 100.0");
}

TEST(Judge, AFullHistoryOfFullCirclesFitsIntoTheBudgets) {
  Record record = circle({{"ovality_um", 1.0}});
  for (int k = 1; k <= 30; ++k)
    for (const char* end : {"_um", "_cos_um", "_sin_um"})
      record.values["harmonic" + std::to_string(k) + end] = {1.0, 0.1};
  History history;
  history.series_first.assign(kHistoryFirst, record);
  history.recent.assign(kHistoryRecent, record);
  const std::string condition =
      "(function() local sum = 0 for _, r in ipairs(history.recent) do for k = 1, 30 do "
      "sum = sum + r[string.format('harmonic%d_cos_um', k)] end end return sum > 0 end)()";
  EXPECT_TRUE(ask(condition, record, "", history).bad);
}

TEST(Judge, ARuleRemembersNothingBetweenTwoCalls) {
  const Rule rule = parse_rule({"x.lua",
                                "local calls = 0\n"
                                "return { name = 'x', on = 'circle', needs = {}, text = 'x',\n"
                                "  when = function(result) calls = calls + 1 return calls > 1 end }"});
  for (int i = 0; i < 3; ++i) EXPECT_FALSE(judge(rule, circle({}), {}).bad);
}

TEST(Applies, LooksAtKindStatusAndWhere) {
  const Rule all = parse_rule(rule_source("x", "true"));
  const Rule one = parse_rule(
      rule_source("x", "true", "where = { robot = 'r1', test = 'A', series = 's', direction = 1 }"));
  EXPECT_TRUE(applies(all, circle({})));
  EXPECT_TRUE(applies(one, circle({})));
  Record other = circle({});
  other.direction = -1;
  EXPECT_TRUE(applies(all, other));
  EXPECT_FALSE(applies(one, other));
  other = circle({});
  other.robot = "r2";
  EXPECT_FALSE(applies(one, other));
  other = circle({});
  other.kind = "line";
  EXPECT_FALSE(applies(all, other));
  other = circle({});
  other.status = "aborted";
  EXPECT_FALSE(applies(all, other));
}

}  // namespace
}  // namespace ballbar
