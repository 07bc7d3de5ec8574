#include "rules/rule_set.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>
#include <fstream>

#include "core/error.hpp"
#include "rules/rule_files.hpp"
#include "rules/test_records.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

using test::circle;
using test::rule_source;

RuleSet rules_of(const std::vector<RuleSource>& sources) {
  LoadReport report = RuleSet::load(sources);
  for (const RuleError& error : report.errors) ADD_FAILURE() << to_string(error);
  return report.rules;
}

std::string names(const RuleSet& rules) {
  std::string all;
  for (const Rule& rule : rules.rules()) all += (all.empty() ? "" : " ") + rule.name;
  return all;
}

class RuleFolder : public testing::Test {
 protected:
  RuleFolder() {
    std::string name = testing::TempDir() + "ballbar_rules_XXXXXX";
    if (mkdtemp(name.data()) == nullptr) throw std::runtime_error("no temporary folder");
    folder_ = name;
  }
  ~RuleFolder() override { std::filesystem::remove_all(folder_); }

  void write(const std::string& name, const std::string& text) const {
    std::ofstream(folder_ / name) << text;
  }
  void write(const RuleSource& source) const { write(source.file, source.text); }

  std::filesystem::path folder_;
};

TEST_F(RuleFolder, LoadsByNameWithoutTestsHiddenFilesAndOthers) {
  write(rule_source("b", "true"));
  write(rule_source("a", "true"));
  write("a_test.lua", "not a rule");
  write(".c.lua", "not a rule");
  write("d.lua~", "not a rule");
  write("README", "not a rule");
  const LoadReport report = RuleSet::load(folder_);
  EXPECT_EQ(names(report.rules), "a b");
  EXPECT_TRUE(report.errors.empty());
}

TEST_F(RuleFolder, ABrokenFileIsReportedAndDoesNotTouchTheOthers) {
  write(rule_source("a", "true"));
  write("b.lua", "return {\n  name = = 1 }");
  const LoadReport report = RuleSet::load(folder_);
  EXPECT_EQ(names(report.rules), "a");
  ASSERT_EQ(report.errors.size(), 1U);
  EXPECT_EQ(to_string(report.errors[0]), "b.lua:2: unexpected symbol near '='");
  EXPECT_TRUE(report.kept.empty());
}

TEST_F(RuleFolder, AReloadKeepsTheLastGoodVersionOfABrokenFileAndTakesTheRest) {
  write(rule_source("a", "false"));
  write(rule_source("b", "true"));
  write(rule_source("c", "true"));
  const LoadReport first = RuleSet::load(folder_);
  write("a.lua", "return { half");
  write(rule_source("b", "false"));
  std::filesystem::remove(folder_ / "c.lua");
  const LoadReport second = RuleSet::load(folder_, &first.rules);
  EXPECT_EQ(names(second.rules), "a b");
  EXPECT_EQ(second.rules.rules()[0].source.text, rule_source("a", "false").text);
  EXPECT_EQ(second.rules.rules()[1].source.text, rule_source("b", "false").text);
  EXPECT_EQ(second.kept, std::vector<std::string>{"a.lua"});
  ASSERT_EQ(second.errors.size(), 1U);
  EXPECT_EQ(second.errors[0].rule, "a");
  // Still broken: still the good one. Repaired: the new one.
  const LoadReport third = RuleSet::load(folder_, &second.rules);
  EXPECT_EQ(names(third.rules), "a b");
  write(rule_source("a", "true"));
  const LoadReport fourth = RuleSet::load(folder_, &third.rules);
  EXPECT_EQ(fourth.rules.rules()[0].source.text, rule_source("a", "true").text);
  EXPECT_TRUE(fourth.errors.empty());
}

TEST_F(RuleFolder, TheSourcesOfALastGoodSetAreEnoughToHaveItBackAfterARestart) {
  write(rule_source("a", "true"));
  std::vector<RuleSource> saved;
  const RuleSet before = RuleSet::load(folder_).rules;
  for (const Rule& rule : before.rules()) saved.push_back(rule.source);
  write("a.lua", "broken");
  const RuleSet back = rules_of(saved);
  EXPECT_EQ(names(RuleSet::load(folder_, &back).rules), "a");
}

TEST_F(RuleFolder, FilesThatCannotBeReadAreErrorsNotHangs) {
  ASSERT_EQ(mkfifo((folder_ / "pipe.lua").c_str(), 0600), 0);
  std::filesystem::create_directory(folder_ / "folder.lua");
  std::filesystem::create_symlink(folder_ / "gone", folder_ / "link.lua");
  write("long.lua", std::string(kMaxRuleBytes + 1, ' '));
  write("just.lua", std::string(kMaxRuleBytes - rule_source("just", "true").text.size(), ' ') +
                        rule_source("just", "true").text);
  const LoadReport report = RuleSet::load(folder_);
  EXPECT_EQ(names(report.rules), "just");
  ASSERT_EQ(report.errors.size(), 4U);
  EXPECT_EQ(to_string(report.errors[0]), "folder.lua: not a file that can be read");
  EXPECT_EQ(report.errors[1].file, "link.lua");
  EXPECT_EQ(to_string(report.errors[2]), "long.lua: the file is longer than 64 KiB");
  EXPECT_EQ(to_string(report.errors[3]), "pipe.lua: not a file that can be read");
}

TEST_F(RuleFolder, AFolderThatIsNotThereIsAnError) { EXPECT_THROW(RuleSet::load(folder_ / "none"), Error); }

TEST(RuleSet, TheSecondRuleOfANameIsAnError) {
  const LoadReport report =
      RuleSet::load({{"1.lua", rule_source("a", "true").text}, {"2.lua", rule_source("a", "false").text}});
  EXPECT_EQ(names(report.rules), "a");
  ASSERT_EQ(report.errors.size(), 1U);
  EXPECT_EQ(to_string(report.errors[0]), "2.lua: name 'a' is already taken by 1.lua");
}

TEST(RuleSet, ALastGoodVersionWhoseNameIsTakenByNowCannotStay) {
  const RuleSet before = rules_of({{"2.lua", rule_source("a", "true").text}});
  const LoadReport report =
      RuleSet::load({{"1.lua", rule_source("a", "true").text}, {"2.lua", "broken"}}, &before);
  EXPECT_EQ(names(report.rules), "a");
  EXPECT_EQ(report.errors.size(), 2U);
  EXPECT_TRUE(report.kept.empty());
}

TEST(RuleSet, HoldsAtMostItsStatedNumberOfRules) {
  std::vector<RuleSource> sources;
  for (std::size_t i = 0; i <= kMaxRules; ++i)
    sources.push_back(rule_source("r" + std::to_string(i), "true"));
  const LoadReport report = RuleSet::load(sources);
  EXPECT_EQ(report.rules.rules().size(), kMaxRules);
  ASSERT_EQ(report.errors.size(), 1U);
  EXPECT_EQ(to_string(report.errors[0]), "r200.lua: more than 200 rules");
}

TEST(Evaluate, GivesStatusesOfAllThatJudgedAndEventsOfThoseThatChanged) {
  const RuleSet rules =
      rules_of({rule_source("bad", "true", "severity = 'critical'"), rule_source("good", "false")});
  const EvaluateResult result = rules.evaluate(circle({{"ovality_um", 7.0}}), {}, {}, 2'000'000);
  EXPECT_TRUE(result.errors.empty());
  ASSERT_EQ(result.statuses.size(), 2U);
  EXPECT_EQ(result.statuses[0].key, (AlarmKey{"bad", "r1", "A", 1, ""}));
  EXPECT_EQ(result.statuses[0].state, AlarmState::kFiring);
  EXPECT_EQ(result.statuses[0].severity, "critical");
  EXPECT_EQ(result.statuses[0].text, "ovality 7");
  EXPECT_EQ(result.statuses[0].since_us, 2'000'000);
  EXPECT_EQ(result.statuses[1].state, AlarmState::kInactive);
  EXPECT_EQ(result.statuses[1].judged_us, 2'000'000);
  ASSERT_EQ(result.events.size(), 1U);
  EXPECT_EQ(result.events[0].status, result.statuses[0]);
  EXPECT_EQ(result.events[0].from, AlarmState::kInactive);
  EXPECT_EQ(result.events[0].run_started_us, 1'000'000);
}

TEST(Evaluate, AnAlarmKeepsTheTextOfItsLastBadRun) {
  const RuleSet rules = rules_of({rule_source("high", "result.ovality_um > 5", "keep_runs = 0")});
  const EvaluateResult bad = rules.evaluate(circle({{"ovality_um", 7.0}}), {}, {}, 1);
  const EvaluateResult clean = rules.evaluate(circle({{"ovality_um", 2.0}}), {}, bad.statuses, 2);
  ASSERT_EQ(clean.events.size(), 1U);
  EXPECT_EQ(clean.events[0].status.state, AlarmState::kResolved);
  EXPECT_EQ(clean.events[0].from, AlarmState::kFiring);
  EXPECT_EQ(clean.events[0].status.text, "ovality 7");
}

TEST(Evaluate, AnAlarmHoldsTheNumbersAndTheRunsThatItStandsOn) {
  const std::string text =
      "return { name = 'over', on = 'circle', needs = { 'ovality_um' }, gives = { 'over_um' }, limit_um = "
      "5.5,\n"
      "  when = function(r, h, rule) return r.ovality_um > rule.limit_um, { over_um = r.ovality_um - "
      "rule.limit_um } "
      "end,\n  text = '{over_um} um over, noise {noise_um}' }\n";
  const RuleSet rules = rules_of({{"over.lua", text}});
  Record record = circle({{"ovality_um", 7.0}, {"noise_um", 0.5}});
  record.values["ovality_um"].sd = 0.25;
  std::vector<AlarmStatus> states;
  for (std::int64_t run = 1; run <= 25; ++run) {
    record.started_us = run;
    states = rules.evaluate(record, {}, states, run + 1).statuses;
  }
  ASSERT_EQ(states.size(), 1u);
  EXPECT_EQ(states[0].numbers,
            (std::vector<AlarmNumber>{{"ovality_um", 7.0, 0.25, false},
                                      {"noise_um", 0.5, record.values["noise_um"].sd, false},
                                      {"over_um", 1.5, {}, false},
                                      {"limit_um", 5.5, {}, true}}));
  ASSERT_EQ(states[0].runs.size(), kAlarmRuns);
  EXPECT_EQ(states[0].runs.front(), 6);
  EXPECT_EQ(states[0].runs.back(), 25);
  record.values["ovality_um"].value = 1.0;
  states = rules.evaluate(record, {}, states, 26).statuses;
  EXPECT_EQ(states[0].runs.back(), 25) << "a clean run leaves what the last bad one said";
  record.values["ovality_um"].value = 6.0;
  record.started_us = 30;
  states = rules.evaluate(record, {}, states, 31).statuses;
  EXPECT_EQ(states[0].runs, std::vector<std::int64_t>{30}) << "another row of bad runs";
}

TEST(Load, NamesOfAlarmsAboutBallbardItselfAreTaken) {
  const LoadReport report = RuleSet::load({rule_source("ballbard_notify", "true")});
  ASSERT_EQ(report.errors.size(), 1u);
  EXPECT_NE(report.errors[0].message.find("about ballbard itself"), std::string::npos);
  AlarmStatus own;
  own.key = {"ballbard_notify", "", "", 0, ""};
  own.state = AlarmState::kFiring;
  EXPECT_TRUE(RuleSet().retire({own}, 5).empty()) << "no rule is gone with them";
}

TEST(Evaluate, ARuleThatFailsStopsNoOtherAndMovesNoAlarm) {
  const RuleSet rules =
      rules_of({rule_source("a_loops", "(function() while true do end end)()"),
                rule_source("b_fails", "result.ovality_um > nil"), rule_source("c_good", "true")});
  AlarmStatus firing;
  firing.key = {"b_fails", "r1", "A", 1, ""};
  firing.state = AlarmState::kFiring;
  const EvaluateResult result = rules.evaluate(circle({{"ovality_um", 7.0}}), {}, {firing}, 2);
  ASSERT_EQ(result.errors.size(), 2U);
  EXPECT_EQ(to_string(result.errors[0]),
            "a_loops.lua:2: over the instruction budget of 1000000: endless loop?");
  EXPECT_EQ(result.errors[0].rule, "a_loops");
  EXPECT_EQ(to_string(result.errors[1]), "b_fails.lua:2: attempt to compare nil with number");
  ASSERT_EQ(result.statuses.size(), 1U);
  EXPECT_EQ(result.statuses[0].key.rule, "c_good");
}

TEST(Evaluate, EachDirectionTestAndRobotHasAnAlarmOfItsOwn) {
  const RuleSet rules = rules_of({rule_source("high", "true", "hold_runs = 2")});
  Record other = circle({{"ovality_um", 7.0}});
  const std::vector<AlarmStatus> pending = rules.evaluate(other, {}, {}, 1).statuses;
  other.direction = -1;
  EXPECT_EQ(rules.evaluate(other, {}, pending, 2).statuses[0].state, AlarmState::kPending);
  other.direction = 1;
  EXPECT_EQ(rules.evaluate(other, {}, pending, 2).statuses[0].state, AlarmState::kFiring);
}

TEST(Evaluate, RunsThatAreNotOkMoveNothing) {
  const RuleSet rules = rules_of({rule_source("high", "true")});
  Record record = circle({{"ovality_um", 7.0}});
  record.status = "interrupted";
  const EvaluateResult result = rules.evaluate(record, {}, {}, 1);
  EXPECT_TRUE(result.statuses.empty());
  EXPECT_TRUE(result.events.empty());
  EXPECT_TRUE(result.errors.empty());
}

TEST(Load, APersonsOwnFolderChangesAddsAndSwitchesOffWhatIsShipped) {
  const test::TempDir shipped, own;
  const auto put = [](const test::TempDir& dir, const std::string& file, const std::string& text) {
    std::ofstream(dir.path() + "/" + file) << text;
  };
  for (const std::string name : {"changed", "off", "shipped"})
    put(shipped, name + ".lua", rule_source(name, "true").text);
  put(own, "changed.lua", rule_source("changed", "false").text);
  put(own, "off.lua", "");
  put(own, "mine.lua", rule_source("mine", "true").text);
  const LoadReport report = RuleSet::load_folders({shipped.path(), own.path()});
  EXPECT_TRUE(report.errors.empty());
  std::vector<std::string> bad;
  for (const AlarmStatus& s : report.rules.evaluate(circle({{"ovality_um", 7.0}}), {}, {}, 1).statuses)
    bad.push_back(s.key.rule + (s.bad_runs > 0 ? " bad" : " good"));
  EXPECT_EQ(bad, (std::vector<std::string>{"changed good", "mine bad", "shipped bad"}));

  put(own, "lonely.lua", "");  // switches nothing off: a mistake, and said
  EXPECT_EQ(RuleSet::load_folders({shipped.path(), own.path()}).errors.size(), 1U);
}

TEST(Retire, AlarmsOfRulesThatAreGoneBecomeInactive) {
  const RuleSet rules = rules_of({rule_source("stays", "true")});
  AlarmStatus gone;
  gone.key.rule = "gone";
  gone.state = AlarmState::kFiring;
  AlarmStatus stays = gone;
  stays.key.rule = "stays";
  AlarmStatus quiet = gone;
  quiet.state = AlarmState::kInactive;
  const std::vector<AlarmEvent> events = rules.retire({gone, stays, quiet}, 9);
  ASSERT_EQ(events.size(), 1U);
  EXPECT_EQ(events[0].status.key.rule, "gone");
  EXPECT_EQ(events[0].from, AlarmState::kFiring);
  EXPECT_EQ(events[0].status.state, AlarmState::kInactive);
  EXPECT_EQ(events[0].status.since_us, 9);
}

}  // namespace
}  // namespace ballbar
