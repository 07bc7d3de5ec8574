// Rules tried on what is stored, baselines, and what no run can tell: silence, losses, a diagnosis.

#include <sstream>

#include "bus/encode.hpp"
#include "bus/log_writer.hpp"
#include "daemon/service.hpp"
#include "store/example_runs.hpp"
#include "support/tool_test.hpp"

namespace ballbar {
namespace {

using test::ballbar;
using test::Outcome;

class ToolRules : public test::ToolTest {
 protected:
  static test::Words with(test::Words words) {
    for (const std::string& word :
         {std::string("--config"), path("lrmate.toml"), std::string("--db"), path("a.db")})
      words.push_back(word);
    return words;
  }
};

TEST_F(ToolRules, ABacktestSaysWhatTheServiceSaid) {
  const Outcome back = ballbar(with({"rules", "backtest", "--until", "2026-03-12"}));
  ASSERT_EQ(back.code, 0) << back.out << back.err;
  EXPECT_NE(back.out.find("ovality_drift  lrmate-1 A+1#7  pending -> firing: ovality of test A (+1) moved"),
            std::string::npos)
      << back.out;
  EXPECT_NE(back.out.find("16 runs, 0 diagnoses, 6 changes of state, 0 errors"), std::string::npos)
      << back.out;
  const Outcome one = ballbar(with({"rules", "backtest", "--rule", "ovality_high", "--robot", "lrmate-1"}));
  EXPECT_NE(one.out.find("16 runs, 0 diagnoses, 4 changes of state"), std::string::npos) << one.out;
  EXPECT_NE(ballbar(with({"rules", "backtest", "--since", "2026-03-12"}))
                .out.find("0 runs, 0 diagnoses, 0 changes"),
            std::string::npos);
  EXPECT_EQ(ballbar(with({"rules", "backtest", "--rule", "ovality_drift", "-o", path("drift.svg")})).code, 0);
  EXPECT_NE(test::read_file(path("drift.svg")).find("firing"), std::string::npos)
      << "a line where its state changed";
  expect_error(with({"rules", "backtest", "--since", "yesterday"}), 2, "'yesterday' is no time");
  expect_error(with({"rules", "backtest", "--rule", "ovality_hihg"}), 2, "did you mean 'ovality_high'?");
  expect_error(with({"rules", "backtest", "-o", path("x.svg")}), 2, "--rule");
}

// Good runs at 0, 33, 34 and 80 hours, the first with 120 lost messages; three that fail at 30, 31 and 32; a
// diagnosis at 50 finds backlash, another at 60 nothing.
TEST_F(ToolRules, ABacktestAsksOnSilenceLossesAndDiagnosesToo) {
  constexpr std::int64_t kHourUs = 3'600'000'000;
  constexpr std::int64_t kBeginUs = 1'773'187'200'000'000;  // 2026-03-11 00:00:00 UTC
  std::filesystem::create_directory(path("clock"));
  test::write_file(
      path("clock/quiet.lua"),
      "return { name = 'quiet', on = 'silence', needs = { 'hours_since_last' }, where = { test = '' },\n"
      "keep_runs = 0, when = function(r) return r.hours_since_last > 30 end,\n"
      "text = 'quiet for {hours_since_last} h' }");
  test::write_file(
      path("clock/lost.lua"),
      "return { name = 'lost', on = 'loss', needs = { 'lost_messages', 'failed_percent' },\n"
      "keep_runs = 0, when = function(r) return r.lost_messages > 100 or r.failed_percent > 50 end,\n"
      "text = 'lost {lost_messages} messages, {failed_percent} % of {runs} runs failed' }");
  std::filesystem::copy(test::kScripts + "/rules/effect_found.lua", path("clock/effect_found.lua"));
  {
    Store store(path("clock.db"));
    const auto save = [&](std::int64_t hour, const std::string& status, std::int64_t lost) {
      test::Saved run = test::circle(kBeginUs + hour * kHourUs);
      run.run.lost_messages = lost;
      run.run.receiver_restarts = 0;
      run.result.status = status;
      run.records.front().status = status;
      store.save(run.run, run.result, run.records, {}, {});
    };
    save(0, "ok", 120);
    for (const int hour : {30, 31, 32}) save(hour, "aborted", 0);
    save(33, "ok", 0);
    save(34, "ok", 0);
    save(80, "ok", 0);
    GapRecord gap;
    gap.robot = "lrmate-1";
    gap.series = "morning";
    gap.verdict = "explained";
    gap.ended_us = kBeginUs + 50 * kHourUs;
    gap.rms_before = 40e-6;
    gap.rms_after = 1e-6;
    gap.left_out = {{"joint_lost_motion", "backlash", 2, 3, 0.83, 913.0}};
    store.save_gap({gap, kBeginUs + 49 * kHourUs, "{}"});
    gap.left_out.clear();
    gap.series = "evening";
    gap.ended_us = kBeginUs + 60 * kHourUs;
    store.save_gap({gap, kBeginUs + 59 * kHourUs, "{}"});
  }
  const auto asked = [&](test::Words more) {
    test::Words words{"rules", "backtest",       path("clock"), "--config",  path("none.toml"),
                      "--db",  path("clock.db"), "--until",     "2026-03-18"};
    words.insert(words.end(), more.begin(), more.end());
    return ballbar(words);
  };
  // Runs last 12 s; the clock is asked at each whole minute after the first run has begun.
  EXPECT_EQ(
      asked({}).out,
      "2026-03-11 00:01:00  lost  lrmate-1  inactive -> firing: lost 120 messages, 0 % of 1 runs failed  "
      "[lost_messages 120, failed_percent 0]\n"
      "2026-03-12 00:01:00  lost  lrmate-1  firing -> resolved  [lost_messages 0, failed_percent 0]\n"
      "2026-03-12 00:02:00  lost  lrmate-1  resolved -> inactive  [lost_messages 0, failed_percent 0]\n"
      "2026-03-12 06:01:00  lost  lrmate-1  inactive -> firing: lost 0 messages, 100 % of 1 runs failed  "
      "[lost_messages 0, failed_percent 100]\n"
      "2026-03-12 06:01:00  quiet  lrmate-1  inactive -> firing: quiet for 30.0 h  [hours_since_last 30.0]\n"
      "2026-03-12 09:01:00  quiet  lrmate-1  firing -> resolved  [hours_since_last 0.0133]\n"
      "2026-03-12 09:02:00  quiet  lrmate-1  resolved -> inactive  [hours_since_last 0.03]\n"
      "2026-03-13 02:00:00  effect_found  lrmate-1 series morning  inactive -> firing: joint_lost_motion "
      "backlash of joint 2 explains 83 % of the mismatch of lrmate-1; 1 um are left  [remainder_rms_um 1]\n"
      "2026-03-13 06:01:00  lost  lrmate-1  firing -> resolved  [lost_messages 0, failed_percent 50]\n"
      "2026-03-13 06:02:00  lost  lrmate-1  resolved -> inactive  [lost_messages 0, failed_percent 50]\n"
      "2026-03-13 12:00:00  effect_found  lrmate-1 series evening  firing -> resolved  [remainder_rms_um 1]\n"
      "2026-03-13 16:01:00  quiet  lrmate-1  inactive -> firing: quiet for 30.0 h  [hours_since_last 30.0]\n"
      "2026-03-14 08:01:00  quiet  lrmate-1  firing -> resolved  [hours_since_last 0.0133]\n"
      "2026-03-14 08:02:00  quiet  lrmate-1  resolved -> inactive  [hours_since_last 0.03]\n"
      "2026-03-15 14:01:00  quiet  lrmate-1  inactive -> firing: quiet for 30.0 h  [hours_since_last 30.0]\n"
      "4 runs, 2 diagnoses, 15 changes of state, 0 errors\n");
  const Outcome since = asked({"--since", "2026-03-12 12:00:00", "--rule", "lost"});
  EXPECT_TRUE(
      since.out.starts_with("2026-03-12 12:01:00  lost  lrmate-1  inactive -> firing: lost 0 messages, "
                            "60 % of 5 runs failed"))
      << since.out;
  EXPECT_EQ(asked({"--rule", "quiet", "-o", path("quiet.svg")}).code, 0);
  EXPECT_NE(test::read_file(path("quiet.svg")).find("firing"), std::string::npos);
  EXPECT_EQ(asked({"--rule", "effect_found", "-o", path("gap.svg")}).code, 0);
  EXPECT_EQ(asked({"--rule", "lost", "-o", path("lost.svg")}).code, 0);
  EXPECT_NE(test::read_file(path("lost.svg")).find("resolved"), std::string::npos);
}

TEST_F(ToolRules, ExplainGivesTheNumbersAndTheReason) {
  const Outcome bad = ballbar(with({"rules", "explain", "ovality_drift", "A+1#7"}));
  ASSERT_EQ(bad.code, 0) << bad.err;
  for (const char* part :
       {"rule.limit_um = 20", "drift_um = 40.2", "bad: yes: ovality of test A (+1) moved 40.2 um",
        "inactive -> pending", "pending -> firing"})
    EXPECT_NE(bad.out.find(part), std::string::npos) << part << "\n" << bad.out;
  EXPECT_NE(ballbar(with({"rules", "explain", "ovality_drift", "A+1#2"})).out.find("bad: no"),
            std::string::npos);
  EXPECT_NE(ballbar(with({"rules", "explain", "straightness_high", "A+1#2"}))
                .out.find("not asked: the rule is on line"),
            std::string::npos);
  expect_error(with({"rules", "explain", "ovality_drif", "A+1#2"}), 2, "did you mean 'ovality_drift'?");
}

// Each of them in `when`, at every run; in the file itself they are refused when it is loaded
// (rules/sandbox_test).
TEST_F(ToolRules, RulesThatAttackAreStoppedAndTheOthersGoOn) {
  std::filesystem::create_directory(path("attacked.d"));
  const std::vector<std::pair<std::string, std::string>> attacks{
      {"endless", "while true do end"},
      {"recursive", "local function f() return 1 + f() end f()"},
      {"growing", "local t = {} for i = 1, 1e9 do t[i] = i end"},
      {"doubling", "local s = 'x' while true do s = s .. s end"},
      {"reading", "local x = math.huge while true do x = history.median('ovality_um') end"}};
  for (const auto& [name, does] : attacks)
    test::write_file(path("attacked.d/" + name + ".lua"),
                     "return { name = '" + name +
                         "', on = 'circle', text = 't', when = function(result, history)\n" + does +
                         "\nreturn false end }");
  std::filesystem::copy(test::kScripts + "/rules/ovality_high.lua", path("attacked.d/ovality_high.lua"));
  std::string config = test::read_file(path("lrmate.toml"));
  config.replace(config.find("rules.d"), 7, "attacked.d");
  test::write_file(path("attacked.toml"), config);
  const Outcome attacked =
      ballbar({"replay", test::kDemo, "--config", path("attacked.toml"), "--db", path("attacked.db")});
  EXPECT_EQ(attacked.code, 0) << attacked.err;
  for (const auto& [name, does] : attacks)
    EXPECT_NE(attacked.out.find("rule failed: " + name + ".lua:2: "), std::string::npos) << name << "\n"
                                                                                         << replayed.out;
  const auto changes_of_ovality_high = [](const std::string& said) {
    std::string all;
    std::istringstream lines(said);
    for (std::string line; std::getline(lines, line);)
      if (line.find(") ovality_high ") != std::string::npos)  // but for the number that people call it by
        all += line.substr(0, line.find(", id ")) + line.substr(line.find(": ")) + "\n";
    return all;
  };
  const Outcome back = ballbar({"rules", "backtest", "--rule", "recursive", "--config", path("attacked.toml"),
                                "--db", path("attacked.db")});
  EXPECT_EQ(back.code, 1) << "a rule that fails";
  EXPECT_NE(back.out.find("(12 times)\n    local function f() return 1 + f() end f()\n"), std::string::npos)
      << back.out;
  EXPECT_NE(changes_of_ovality_high(attacked.out), "");
  EXPECT_EQ(changes_of_ovality_high(attacked.out), changes_of_ovality_high(ToolTest::replayed.out));
}

TEST_F(ToolRules, CheckShowsTheLineThatIsWrong) {
  std::filesystem::create_directory(path("units"));
  std::string rule = test::read_file(test::kScripts + "/rules/ovality_high.lua");
  for (std::size_t at = 0; (at = rule.find("limit_um", at)) != std::string::npos;)
    rule.replace(at, 8, "limit_mm");
  test::write_file(path("units/units.lua"), rule);
  const Outcome units = ballbar({"rules", "check", path("units")});
  EXPECT_EQ(units.code, 1);
  EXPECT_NE(
      units.out.find("field 'limit_mm' is in mm, but what the rule needs is in um: give the limit in um\n"
                     "    limit_mm = 150.0,\n"),
      std::string::npos)
      << units.out;
}

TEST_F(ToolRules, ABaselineIsSetAndListed) {
  EXPECT_EQ(ballbar(with({"baseline", "set", "--robot", "lrmate-1", "--at", "2026-03-11 09:00:00", "--note",
                          "mastered"}))
                .code,
            0);
  EXPECT_EQ(ballbar(with({"baseline", "list"})).out, "2026-03-11 09:00:00  lrmate-1  all tests  mastered\n");
  // A mark in a log does the same, however often the log is played.
  LogWriter log(path("mark.lcm"));
  TestMark mark;
  mark.header = {1'773'220'000'000'000, 1, "lrmate-1"};
  mark.test = "A";
  mark.mark = Mark::kCalibrated;
  mark.series = "new ball";
  log.write(encode(Sample(mark)), mark.header.time_us);
  log.keep();
  for (int time = 0; time < 2; ++time) EXPECT_EQ(ballbar(with({"replay", path("mark.lcm")})).code, 0);
  EXPECT_EQ(
      ballbar(with({"baseline", "list"})).out,
      "2026-03-11 09:00:00  lrmate-1  all tests  mastered\n2026-03-11 09:06:40  lrmate-1  A  new ball\n");
  expect_error(with({"baseline", "set", "--robot", "nobody"}), 2, "no robot 'nobody'");
  expect_error(with({"baseline", "set", "--robot", "lrmate-1", "--test", "Q"}), 2, "has no test 'Q'");
}

TEST_F(ToolRules, SilenceAndADiagnosisRaiseAlarmsThatAreStored) {
  constexpr std::int64_t kDayUs = 86'400'000'000;
  const Config config = load_config(path("lrmate.toml"));
  Store store(path("watch.db"));
  const std::string rules = test::kScripts + "/rules";
  std::vector<std::string> said;
  Service service(config, load_models(config), RuleSet::load(rules).rules, store,
                  [&](Priority, const std::string& line) { said.push_back(line); });
  const auto firing = [&] {
    std::string all;
    for (const AlarmStatus& alarm : store.alarm_states())
      if (alarm.state == AlarmState::kFiring) all += alarm.key.rule + " " + alarm.key.robot + "; ";
    return all;
  };
  {  // a controller whose clock was ten years ahead
    test::Saved s = test::circle(3650 * kDayUs);
    store.save(s.run, s.result, s.records, {}, {});
  }
  service.on_time(100 * kDayUs);
  service.on_time(129 * kDayUs);
  EXPECT_EQ(firing(), "") << "it has listened for 29 days";
  service.on_time(131 * kDayUs);
  EXPECT_EQ(firing(), "not_tested lrmate-1; ");
  service.on_time(132 * kDayUs);
  EXPECT_EQ(store.events().size(), 1u) << "the same state is not stored again";

  GapRecord gap;
  gap.robot = "lrmate-1";
  gap.verdict = "explained";
  gap.ended_us = 132 * kDayUs;
  gap.rms_before = 40e-6;
  gap.rms_after = 1e-6;
  gap.left_out = {{"joint_lost_motion", "backlash", 2, 3, 0.83, 913.0}};
  service.on_gap({gap, 131 * kDayUs, "{}"});
  EXPECT_EQ(firing(), "effect_found lrmate-1; not_tested lrmate-1; ");
  EXPECT_NE(said.back().find("joint_lost_motion backlash of joint 2 explains 83 %"), std::string::npos)
      << said.back();
  gap.left_out.clear();
  service.on_gap({gap, 131 * kDayUs, "{}"});
  EXPECT_EQ(firing(), "not_tested lrmate-1; ");
}

}  // namespace
}  // namespace ballbar
