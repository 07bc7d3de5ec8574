// Scripts put together at random from pieces of Lua, of our own functions and of attacks: whatever they are,
// they end in an answer or in an error of their own, within the budget, and the rule beside them goes on.

#include <gtest/gtest.h>

#include <random>

#include "rules/past_records.hpp"
#include "rules/rule_set.hpp"
#include "rules/test_records.hpp"

namespace ballbar {
namespace {

const std::vector<std::string>& pieces() {
  static const std::vector<std::string> all{"while true do ",
                                            "for i = 1, 1e9 do ",
                                            "repeat ",
                                            "until false ",
                                            "if result.ovality_um > 1 then ",
                                            "else ",
                                            "end ",
                                            "local function f(...) ",
                                            "return ",
                                            "f(f) ",
                                            "local t = {} ",
                                            "t[#t + 1] = t ",
                                            "t = { t, t } ",
                                            "local s = 'x' ",
                                            "s = s .. s ",
                                            "s:rep(1e9) ",
                                            "('a'):find('.-.-b') ",
                                            "pcall(f) ",
                                            "setmetatable(t, { __gc = f }) ",
                                            "history.recent[1] ",
                                            "local x = history.recent[-1] ",
                                            "local y = #history.series_first ",
                                            "history.mean('ovality_um') ",
                                            "history.slope('ovality_um', 100) ",
                                            "history.distance('ovality') ",
                                            "history.cusum('ovality_um', -1) ",
                                            "history.mean = f ",
                                            "result.ovality_um = nil ",
                                            "for k, v in pairs(result) do ",
                                            "for k, v in pairs(history) do ",
                                            "for _, r in ipairs(history.recent) do ",
                                            "string.format('%99.99f', 1e300) ",
                                            "table.sort(t, f) ",
                                            "table.concat(t, s, 1, 1e9) ",
                                            "table.unpack(t, 1, 1e7) ",
                                            "goto a ",
                                            "::a:: ",
                                            "error(t) ",
                                            "error(nil) ",
                                            "_ENV = t ",
                                            "string = nil ",
                                            "math.huge // 0 ",
                                            "1 // 0 ",
                                            "load('x') ",
                                            "x = ",
                                            "= ",
                                            "( ",
                                            ") ",
                                            "{ ",
                                            "} ",
                                            ", ",
                                            "nil ",
                                            "0/0 ",
                                            "'\\0\\255' ",
                                            "--[[ ",
                                            "]] ",
                                            "rule.when(result, history, rule) ",
                                            "return true, { over = 1 } ",
                                            "tostring(result) ",
                                            "next(result) ",
                                            "select('#', table.unpack(t)) ",
                                            "math.tointeger(2^63) ",
                                            "string.byte(s, 1, -1) "};
  return all;
}

TEST(RuleFuzz, WhateverAScriptDoesTheRuleBesideItGoesOn) {
  constexpr int kScripts = 1500;
  constexpr unsigned kSeed = 20261122;
  std::mt19937 rng(kSeed);
  const RuleSource good = test::rule_source("good", "result.ovality_um > (history.mean('ovality_um') or 0)");
  std::vector<Record> earlier;
  for (int i = 1; i <= 60; ++i) {
    earlier.push_back(
        test::circle({{"ovality_um", 1.0 + i % 3}, {"ovality_cos_um", i % 5}, {"ovality_sin_um", i % 7}}));
    earlier.back().started_us = i;
  }
  Record now = earlier.back();
  now.started_us = 1000;
  now.values["ovality_um"].value = 9.0;
  int loaded = 0;
  int judged = 0;
  for (int script = 0; script < kScripts; ++script) {
    std::string body;
    const unsigned length = 1 + rng() % 14;
    for (unsigned i = 0; i < length; ++i) body += pieces()[rng() % pieces().size()];
    SCOPED_TRACE("seed " + std::to_string(kSeed) + ", script " + std::to_string(script) + ": " + body);
    const RuleSource wild{"wild.lua",
                          "return { name = 'wild', on = 'circle', needs = {}, text = 'x',\n"
                          "when = function(result, history, rule)\n" +
                              body + "\nend }"};
    const LoadReport report = RuleSet::load({wild, good});
    loaded += report.rules.rules().size() == 2;
    for (int again = 0; again < 2; ++again) {  // the second call meets what the first one left: nothing
      PastRecords past(now, earlier, {});
      const EvaluateResult result = report.rules.evaluate(now, past, {}, 2000);
      ASSERT_FALSE(result.statuses.empty());
      const AlarmStatus& last = result.statuses.back();
      ASSERT_EQ(last.key.rule, "good");
      ASSERT_EQ(last.state, AlarmState::kFiring);
      judged += result.statuses.size() == 2;
      for (const RuleError& error : result.errors) ASSERT_EQ(error.rule, "wild");
    }
  }
  EXPECT_GT(loaded, kScripts / 50) << "enough of them are Lua";
  EXPECT_GT(judged, 0);
}

TEST(RuleFuzz, EveryCallOfAnEndlessRuleIsStoppedAndTheOthersGoOn) {
  const RuleSource good = test::rule_source("good", "true");
  const std::vector<std::string> attacks{
      "while true do end", "(function() local s = 'x' while true do s = s .. s end end)()",
      "(function() local t = {} while true do t = { t } end end)()",
      "(function() for _ in pairs(result) do while true do history.mean('ovality_um') end end end)()",
      "(function() while true do local r = history.recent[1] end end)()"};
  for (const std::string& attack : attacks) {
    const std::string body = attack.starts_with("while") ? "(function() " + attack + " end)()" : attack;
    const LoadReport report = RuleSet::load({test::rule_source("bad", body), good});
    ASSERT_EQ(report.rules.rules().size(), 2u) << attack;
    for (int call = 0; call < 3; ++call) {
      const EvaluateResult result =
          report.rules.evaluate(test::circle({{"ovality_um", 1.0}}), History{}, {}, 1);
      ASSERT_EQ(result.errors.size(), 1u) << attack;
      EXPECT_NE(result.errors[0].message.find("budget"), std::string::npos) << result.errors[0].message;
      ASSERT_EQ(result.statuses.size(), 1u);
      EXPECT_EQ(result.statuses[0].state, AlarmState::kFiring);
    }
  }
}

}  // namespace
}  // namespace ballbar
