#include "rules/rule_test.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>

#include "core/error.hpp"
#include "rules/rule_files.hpp"
#include "rules/test_records.hpp"

namespace ballbar {
namespace {

RuleSource high() {
  return test::rule_source("high", "result.ovality_um > rule.limit_um", "limit_um = 25, hold_runs = 2");
}

std::string failures(const std::string& rows) {
  std::string all;
  const RuleTestReport report =
      run_rule_test({"high_test.lua", "return { rule = 'high.lua',\n" + rows + "}"}, high());
  for (const RuleError& error : report.failures) all += to_string(error) + "\n";
  return all;
}

TEST(RuleTest, ATableThatIsRightPasses) {
  const RuleTestReport report = run_rule_test({"high_test.lua",
                                               "return { rule = 'high.lua', { ovality_um = 26, expect = "
                                               "'pending' }, { ovality_um = 27, expect = 'firing' } }"},
                                              high());
  EXPECT_TRUE(report.failures.empty());
  EXPECT_EQ(report.rows, 2);
  EXPECT_EQ(report.file, "high_test.lua");
}

TEST(RuleTest, ARowThatIsWrongIsToldWithItsLine) {
  EXPECT_EQ(failures("-- what to expect\n{ ovality_um = 26, expect = 'pending' },\n{ ovality_um = 24, expect "
                     "= 'firing' },\n"),
            "high_test.lua:4: row 2: expected firing, got inactive\n");
}

TEST(RuleTest, AnUnexpectedErrorOfTheRuleIsQuoted) {
  EXPECT_EQ(failures("{ noise_um = 26, expect = 'pending' },"),
            "high_test.lua:2: row 1: expected pending, got error (high.lua:1: needs 'ovality_um', which this "
            "run does not have)\n");
}

TEST(RuleTest, RowsThatAreNotJudgedKeepTheState) {
  EXPECT_EQ(failures("{ ovality_um = 26, expect = 'pending' },\n{ ovality_um = 26, status = 'aborted', "
                     "expect = 'pending' },\n"
                     "{ ovality_um = 26, expect = 'firing' },"),
            "");
}

TEST(RuleTest, ReadingsOfTheVirtualBallbarMoveNoAlarmOfTheBar) {
  EXPECT_EQ(failures("{ ovality_um = 26, expect = 'pending' },\n{ ovality_um = 0, source = 'joints', "
                     "expect = 'pending' },\n"
                     "{ ovality_um = 26, expect = 'firing' },"),
            "");
  const RuleSource drift = test::rule_source("drift", "#history.recent > 0", "where = { source = 'joints' }");
  const std::string rows =
      "{ ovality_um = 1, expect = 'inactive' },\n{ ovality_um = 1, source = 'joints', expect = 'inactive' "
      "},\n"
      "{ ovality_um = 1, expect = 'inactive' },\n{ ovality_um = 1, source = 'joints', expect = 'firing' },";
  const RuleTestReport report =
      run_rule_test({"drift_test.lua", "return { rule = 'drift.lua',\n" + rows + "}"}, drift);
  for (const RuleError& failure : report.failures) ADD_FAILURE() << to_string(failure);
}

TEST(RuleTest, MistakesInTheTableAreFailures) {
  EXPECT_EQ(failures("{ ovalty_um = 26, expect = 'pending' },"),
            "high_test.lua:2: row 1: ovalty_um is no quantity or label of a circle, or of the wrong type; "
            "did you mean 'ovality_um'?\n");
  EXPECT_EQ(failures("{ test = 1, expect = 'pending' },").substr(0, 26), "high_test.lua:2: row 1: te");
  EXPECT_EQ(failures("{ ovality_um = 26 },"),
            "high_test.lua: row 1: expect must be inactive, pending, firing, resolved or error\n");
  EXPECT_EQ(failures("{ ovality_um = 26, expect = 'fires' },"),
            "high_test.lua:2: row 1: expect must be inactive, pending, firing, resolved or error\n");
  EXPECT_EQ(failures(""),
            "high_test.lua:1: a table holds rule = \"...\", at least one row, and nothing else\n");
  EXPECT_EQ(failures("{ ovality_um = 26, expect = 'pending' } {}"),
            "high_test.lua:2: '}' expected (to close '{' at line 1) near '{'\n");
}

TEST(RuleTest, TheHistoryOfARowIsTheRowsBeforeItOfTheSameTestDirectionAndSeries) {
  const RuleSource counting =
      test::rule_source("count", "#history.series_first == 2 and #history.recent == 3", "keep_runs = 0");
  const RuleTestReport report = run_rule_test({"count_test.lua",
                                               "return { rule = 'count.lua',\n"
                                               "{ ovality_um = 1, expect = 'inactive' },\n"
                                               "{ ovality_um = 1, series = 'other', expect = 'inactive' },\n"
                                               "{ ovality_um = 1, test = 'B', expect = 'inactive' },\n"
                                               "{ ovality_um = 1, direction = -1, expect = 'inactive' },\n"
                                               "{ ovality_um = 1, status = 'failed', expect = 'inactive' },\n"
                                               "{ ovality_um = 1, expect = 'inactive' },\n"
                                               "{ ovality_um = 1, expect = 'firing' } }"},
                                              counting);
  for (const RuleError& error : report.failures) ADD_FAILURE() << to_string(error);
}

TEST(RuleTest, ARuleThatCannotBeLoadedIsAFailure) {
  const RuleTestReport report =
      run_rule_test({"x_test.lua", "return { rule = 'x.lua', { expect = 'error' } }"}, {"x.lua", "broken"});
  ASSERT_EQ(report.failures.size(), 1U);
  EXPECT_EQ(report.failures[0].file, "x.lua");
  EXPECT_EQ(report.failures[0].line, 1);
}

class ShippedRules : public testing::Test {
 protected:
  const std::filesystem::path folder_ = std::filesystem::path(BALLBAR_SOURCE_DIR) / "scripts" / "rules";
};

TEST_F(ShippedRules, AllLoad) {
  const LoadReport report = RuleSet::load(folder_);
  for (const RuleError& error : report.errors) ADD_FAILURE() << to_string(error);
  EXPECT_EQ(report.rules.rules().size(), 11U);
}

TEST_F(ShippedRules, EachHasATableAndPassesIt) {
  for (const std::filesystem::path& rule : rule_files(folder_)) {
    const std::filesystem::path table = folder_ / (rule.stem().string() + "_test.lua");
    ASSERT_TRUE(std::filesystem::exists(table)) << table;
    const RuleTestReport report = run_rule_test(table);
    EXPECT_GT(report.rows, 0) << table;
    for (const RuleError& error : report.failures) ADD_FAILURE() << to_string(error);
  }
}

TEST_F(ShippedRules, OvalityThatOnlyTurnsFiresTheDriftRule) {
  const LoadReport loaded = RuleSet::load(
      {read_rule_file(folder_ / "ovality_drift.lua"), read_rule_file(folder_ / "ovality_high.lua")});
  std::vector<AlarmStatus> states;
  History history;
  std::string said;
  for (const double phase_deg : {0.0, 0.0, 0.0, 0.0, 40.0, 40.0}) {  // 60 um all the time
    const double phase = phase_deg * 3.14159265358979 / 180.0;
    const Record record = test::circle({{"ovality_um", 60.0},
                                        {"ovality_cos_um", 60.0 * std::cos(phase)},
                                        {"ovality_sin_um", 60.0 * std::sin(phase)}});
    const EvaluateResult result = loaded.rules.evaluate(record, history, states, 1);
    EXPECT_TRUE(result.errors.empty());
    states = result.statuses;
    history.series_first.push_back(record);
    for (const AlarmEvent& event : result.events)
      said += event.status.key.rule + ": " + event.status.text + "\n";
  }
  // 2 x 60 um x sin(20 deg) = 41.04 um
  const std::string text =
      "ovality_drift: ovality of test A (+1) moved 41.0 um from the begin of series s: (cos, sin) was (60, "
      "0) um, is (46.0, 38.6) um; "
      "limit 20 um, or 5.5 sd added up: 0\n";
  EXPECT_EQ(said, text + text);
}

}  // namespace
}  // namespace ballbar
