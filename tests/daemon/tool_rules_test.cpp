// Rules tried on what is stored, baselines, and what no run can tell: silence, losses, a diagnosis.

#include "daemon/service.hpp"
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
  const Outcome back = ballbar(with({"rules", "backtest"}));
  ASSERT_EQ(back.code, 0) << back.out << back.err;
  EXPECT_NE(back.out.find("ovality_drift  lrmate-1 A+1#7  pending -> firing: ovality of test A (+1) moved"),
            std::string::npos)
      << back.out;
  EXPECT_NE(back.out.find("16 runs, 6 changes of state, 0 errors"), std::string::npos) << back.out;
  const Outcome one = ballbar(with({"rules", "backtest", "--rule", "ovality_high", "--robot", "lrmate-1"}));
  EXPECT_NE(one.out.find("16 runs, 4 changes of state"), std::string::npos) << one.out;
  EXPECT_NE(ballbar(with({"rules", "backtest", "--since", "2026-03-12"})).out.find("0 runs, 0 changes"),
            std::string::npos);
  EXPECT_EQ(ballbar(with({"rules", "backtest", "--rule", "ovality_drift", "-o", path("drift.svg")})).code, 0);
  EXPECT_NE(test::read_file(path("drift.svg")).find("firing"), std::string::npos)
      << "a line where its state changed";
  expect_error(with({"rules", "backtest", "--since", "yesterday"}), 2, "'yesterday' is no time");
  expect_error(with({"rules", "backtest", "--rule", "ovality_hihg"}), 2, "did you mean 'ovality_high'?");
  expect_error(with({"rules", "backtest", "-o", path("x.svg")}), 2, "--rule");
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
