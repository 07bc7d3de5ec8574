// How the tool answers: exit codes, one line per error, help, replay, rules and configuration.

#include <gtest/gtest.h>

#include "support/tool_test.hpp"

namespace ballbar {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::ballbar;
using test::kDemo;
using test::kScripts;
using test::Outcome;
using test::Words;

class ToolUse : public test::ToolTest {};

TEST_F(ToolUse, BadUseAndBadInputAreOneLineAndTwo) {
  const std::string db = path("a.db"), config = path("lrmate.toml");
  test::write_file(path("text.lcm"), "This is no recording, but a letter.\n");
  test::write_file(path("empty.lcm"), "");
  test::write_file(path("bad.toml"), "[store]\npath = \"x.db\"\n[rulez]\n");
  test::write_file(path("no_urdf.toml"), "[[robot]]\nname = \"r\"\nurdf = \"gone.urdf\"\n");

  expect_error({}, 2, "subcommand is required");
  expect_error({"fly"}, 2, "'fly'");
  expect_error({"rules"}, 2, "subcommand is required");
  expect_error({"rules", "obey"}, 2, "'obey'");
  expect_error({"config"}, 2, "subcommand is required");
  expect_error({"list", "--fast", "--db", db}, 2, "--fast");
  expect_error({"list", "--limit", "few", "--db", db}, 2, "'few' is no number of runs");
  expect_error({"list", "--limit", "-1", "--db", db}, 2, "--limit");
  expect_error({"list", "--db"}, 2, "--db");
  expect_error({"show", "--db", db}, 2, "RUN is required");
  expect_error({"replay", "--config", config}, 2, "LOG is required");
  expect_error({"import", "--config", config}, 2, "FILE is required");
  expect_error({"plot", "A+1#1", "--db", db}, 2, "--output is required");
  expect_error({"export", "--json", "--csv", "--db", db}, 2, "--json excludes --csv");

  expect_error({"replay", path("gone.lcm"), "--config", config, "--db", path("never.db")}, 2,
               path("gone.lcm") + ": cannot be read");
  expect_error({"replay", path("text.lcm"), "--config", config, "--db", path("never.db")}, 2,
               path("text.lcm") + ": is not an LCM log");
  expect_error({"replay", path("empty.lcm"), "--config", config, "--db", path("never.db")}, 2,
               "is not an LCM log");
  expect_error({"replay", dir->path(), "--config", config, "--db", path("never.db")}, 2, "is a folder");
  expect_error({"replay", kDemo, path("gone.lcm"), "--config", config, "--db", path("never.db")}, 2,
               "gone.lcm");
  expect_error({"replay", kDemo, "--config", path("bad.toml"), "--db", path("never.db")}, 2,
               path("bad.toml") + ":3:2: unknown key 'rulez'");
  EXPECT_FALSE(fs::exists(path("never.db"))) << "bad input leaves no database behind";

  expect_error({"config", "check", path("bad.toml")}, 2, path("bad.toml") + ":3:2: unknown key 'rulez'");
  expect_error({"config", "check", path("no_urdf.toml")}, 2,
               path("no_urdf.toml") + ":3:8: no file " + path("gone.urdf"));
  expect_error({"config", "check", path("gone.toml")}, 2, path("gone.toml") + ": cannot be read");
  expect_error({"list", "--config", path("bad.toml")}, 2, ":3:2: unknown key");
  expect_error({"show", "99999", "--db", db}, 2, "no run with id 99999 in " + db);
  for (const std::string name :
       {"Z+1#1", "A+1#77", "nowhere:A+1#1", "A", "", "+1#1", "#1", "99999999999999999999"})
    expect_error({"show", name, "--db", db}, 2,
                 std::string("no run '").append(name).append("' in ").append(db));
  expect_error({"export", "--trace", "A+1#77", "--db", db}, 2, "no run 'A+1#77'");
  expect_error({"plot", "A+1#1", "-o", path("x.pdf"), "--db", db}, 2,
               path("x.pdf") + ": a picture's name ends in .svg or .png");
  expect_error({"plot", "A+1#1", "Y+1#1", "-o", path("x.svg"), "--db", db}, 2, "do not go into one plot");
  expect_error({"plot", "--test", "Z", "-o", path("x.svg"), "--db", db}, 2, "nothing to plot");
  expect_error({"summary", "--series", "Z", "--db", db}, 2, "no run that is ok");
  expect_error({"summary", "--baseline", "Z", "--db", db}, 2, "no circle of the baseline 'Z'");
  expect_error({"rules", "check", path("gone")}, 2, path("gone"));
  expect_error({"rules", "test", path("gone")}, 2, path("gone"));
}

TEST_F(ToolUse, AUrdfThatIsNoneIsNamedWithItsRobot) {
  test::write_file(path("bad.urdf"), "<robot");
  test::write_file(path("bad_urdf.toml"), "[[robot]]\nname = \"r\"\nurdf = \"bad.urdf\"\n");
  for (const Words& words :
       {Words{"config", "check", path("bad_urdf.toml")},
        Words{"replay", kDemo, "--config", path("bad_urdf.toml"), "--db", path("never.db")}}) {
    const Outcome outcome = ballbar(words);
    EXPECT_EQ(outcome.code, 2);
    EXPECT_EQ(outcome.out, "");
    EXPECT_NE(outcome.err.find("ballbar: " + path("bad_urdf.toml") + ": robot 'r': " + path("bad.urdf")),
              std::string::npos)
        << outcome.err;
  }
  EXPECT_FALSE(fs::exists(path("never.db")));
}

TEST_F(ToolUse, WhereTheWorldFailsItIsOneLineAndThree) {
  const std::string config = path("lrmate.toml");
  test::write_file(path("text.db"), std::string(5000, 'x'));
  for (const std::string verb : {"list", "export", "alarms", "summary"}) {
    expect_error({verb, "--db", path("gone.db")}, 3, path("gone.db") + ": there is no such database");
    expect_error({verb, "--db", path("text.db")}, 3, path("text.db"));
  }
  expect_error({"list", "--config", config}, 3, path("configured.db"));
  expect_error({"replay", kDemo, "--config", config, "--db", "/proc/ballbar.db"}, 3,
               "/proc/ballbar.db");  // also root may not
  expect_error({"replay", kDemo, "--config", config, "--db", path("none/x.db")}, 3,
               "there is no folder " + path("none"));
  expect_error({"replay", kDemo, "--config", config, "--db", path("text.db")}, 3, path("text.db"));
  expect_error({"plot", "A+1#1", "-o", path("none/x.svg"), "--db", path("a.db")}, 3, path("none"));
  EXPECT_EQ(test::read_file(path("text.db")), std::string(5000, 'x'))
      << "a file that is not ours stays as it is";

  const Outcome full =
      test::run({"sh", "-c", test::kBallbar + " export --db " + path("a.db") + " > /dev/full"});
  EXPECT_EQ(full.code, 3) << "what could not be written is not done";
  EXPECT_NE(full.err.find("standard output cannot be written"), std::string::npos) << full.err;
}

TEST_F(ToolUse, AFolderThatMayNotBeWrittenIsTheWorldsFailure) {
  // /proc is a folder in which not even root makes files
  expect_error({"replay", kDemo, "--config", path("lrmate.toml"), "--db", "/proc/x.db"}, 3, "/proc");
}

TEST_F(ToolUse, EveryVerbHasHelp) {
  const std::vector<std::pair<Words, Words>> table{
      {{},
       {"replay", "import", "list", "show", "export", "plot", "summary", "alarms", "rules", "config",
        "Exit codes"}},
      {{"replay"}, {"LOG", "--config", "--db", "--publish", "--quiet"}},
      {{"import"},
       {"FILE", "--config", "--db", "--robot", "--test", "--direction", "--started", "--unit", "--columns",
        "--separator", "--decimal", "--axis", "--with-overshoot", "--feed-mm-s"}},
      {{"list"}, {"--config", "--db", "--robot", "--test", "--series", "--limit", "--json"}},
      {{"show"}, {"RUN", "--config", "--db", "--json"}},
      {{"export"}, {"--config", "--db", "--json", "--csv", "--trace", "--series"}},
      {{"summary"}, {"--config", "--db", "--json", "--series", "--baseline"}},
      {{"plot"}, {"RUN", "--output", "--config", "--db", "--series"}},
      {{"alarms"}, {"--config", "--db", "--all", "--json", "--robot", "show", "ack", "shelve", "unshelve"}},
      {{"alarms", "show"}, {"ID", "--config", "--db", "--json", "--output"}},
      {{"alarms", "ack"}, {"ID", "--config", "--socket", "--comment", "--name"}},
      {{"alarms", "shelve"}, {"ID", "--for", "--until", "UTC"}},
      {{"rules"}, {"check", "test", "backtest", "explain"}},
      {{"rules", "check"}, {"DIRECTORY", "--config"}},
      {{"rules", "test"}, {"DIRECTORY", "--config"}},
      {{"config"}, {"check"}},
      {{"config", "check"}, {"FILE", "--config"}},
  };
  for (const auto& [verb, says] : table) {
    Words words = verb;
    words.push_back("--help");
    const Outcome outcome = ballbar(words);
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.err, "");
    for (const std::string& word : says)
      EXPECT_NE(outcome.out.find(word), std::string::npos) << word << " in\n" << outcome.out;
  }
  const Outcome version = ballbar({"--version"});
  EXPECT_EQ(version.code, 0);
  EXPECT_TRUE(!version.out.empty() && std::isdigit(static_cast<unsigned char>(version.out[0])))
      << version.out;
}

TEST_F(ToolUse, ReplayStoresEveryRunOnceAndSaysSoWithoutProgressInAPipe) {
  EXPECT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_EQ(replayed.err, "");
  EXPECT_NE(replayed.out.find("0 lost, 0 refused\n16 runs stored, 16 of them ok, 0 already known"),
            std::string::npos)
      << replayed.out;
  EXPECT_EQ(replayed.out.find_first_of("\r\033"), std::string::npos) << replayed.out;
  EXPECT_EQ(exported["runs"].size(), 16u);

  const Outcome again =
      ballbar({"replay", kDemo, "--config", path("lrmate.toml"), "--db", path("a.db"), "--quiet"});
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_NE(again.out.find("0 runs stored, 0 of them ok, 16 already known"), std::string::npos) << again.out;
  EXPECT_EQ(std::count(again.out.begin(), again.out.end(), '\n'), 2) << "quiet: the log and the totals\n"
                                                                     << again.out;
  EXPECT_EQ(json::parse(ballbar({"export", "--json", "--db", path("a.db")}).out), exported);
}

TEST_F(ToolUse, TheConfiguredDatabaseIsTakenWhereNoneIsNamed) {
  write_config("own.toml", "lrmate-1");
  std::string text = test::read_file(path("own.toml"));
  text.replace(text.find("configured.db"), 13, "own.db");
  test::write_file(path("own.toml"), text);
  EXPECT_EQ(ballbar({"replay", kDemo, "--config", path("own.toml"), "--quiet"}).code, 0);
  EXPECT_EQ(json::parse(ballbar({"export", "--config", path("own.toml")}).out), exported);
}

TEST_F(ToolUse, MessagesOfRobotsThatAreNotConfiguredAreRefusedAndCounted) {
  write_config("other.toml", "somebody-else");
  const Outcome outcome =
      ballbar({"replay", kDemo, "--config", path("other.toml"), "--db", path("other.db")});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find(" 7380 refused (unknown_robot 7380)"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("0 runs stored"), std::string::npos) << outcome.out;
  EXPECT_EQ(json::parse(ballbar({"export", "--db", path("other.db")}).out), json::parse("{\"runs\": []}"));
}

TEST_F(ToolUse, ALogThatEndsInTheMiddleGivesWhatWasWhole) {
  const std::string log = test::read_file(kDemo);
  test::write_file(path("cut.lcm"), log.substr(0, log.size() / 2));
  const Outcome outcome =
      ballbar({"replay", path("cut.lcm"), "--config", path("lrmate.toml"), "--db", path("cut.db")});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("cut.lcm: damaged at byte "), std::string::npos) << outcome.err;
  const json runs = json::parse(ballbar({"export", "--db", path("cut.db")}).out)["runs"];
  ASSERT_GT(runs.size(), 2u);
  ASSERT_LT(runs.size(), 16u);
  for (std::size_t i = 0; i + 1 < runs.size(); ++i) EXPECT_EQ(runs[i], exported["runs"][i]) << "run " << i;
  EXPECT_NE(runs.back()["status"], "ok")
      << "the run in which the log ends is there, and says that it has no end";
}

TEST_F(ToolUse, RulesAreCheckedAndTested) {
  const Outcome check = ballbar({"rules", "check", kScripts + "/rules"});
  EXPECT_EQ(check.code, 0) << check.out << check.err;
  EXPECT_NE(check.out.find("11 rules good, 0 errors"), std::string::npos) << check.out;
  EXPECT_EQ(ballbar({"rules", "check", "--config", path("lrmate.toml")}).code, 0) << "the configured folder";
  const Outcome test = ballbar({"rules", "test", kScripts + "/rules"});
  EXPECT_EQ(test.code, 0) << test.out << test.err;
  EXPECT_NE(test.out.find("11 tables, 0 failures"), std::string::npos) << test.out;

  fs::create_directory(path("bad"));
  fs::copy(kScripts + "/rules/ovality_high.lua", path("bad/good.lua"));
  test::write_file(path("bad/bad.lua"), "return {\n  name = \"bad\",\n  on = = \"circle\",\n}\n");
  test::write_file(path("bad/good_test.lua"),
                   "return { rule = \"good.lua\",\n  { ovality_um = 1.0, expect = \"firing\" },\n}\n");
  const Outcome bad = ballbar({"rules", "check", path("bad")});
  EXPECT_EQ(bad.code, 1) << "the answer is no";
  EXPECT_NE(bad.out.find(path("bad/bad.lua") + ":3: "), std::string::npos) << bad.out;
  EXPECT_NE(bad.out.find("1 rules good, 1 errors"), std::string::npos) << bad.out;

  fs::create_directory(path("typo"));  // inside `when`, where loading does not look
  std::string rule = test::read_file(kScripts + "/rules/ovality_high.lua");
  const std::size_t at = rule.find("rule.limit_um");
  ASSERT_NE(at, std::string::npos);
  test::write_file(path("typo/typo.lua"), rule.replace(at, 13, "rule.limt_um"));
  const Outcome typo = ballbar({"rules", "check", path("typo")});
  EXPECT_EQ(typo.code, 1);
  EXPECT_NE(typo.out.find("limt_um"), std::string::npos) << typo.out;
  EXPECT_NE(typo.out.find("0 rules good, 1 errors"), std::string::npos) << typo.out;
  const Outcome failing = ballbar({"rules", "test", path("bad")});
  EXPECT_EQ(failing.code, 1);
  EXPECT_NE(failing.out.find(path("bad/good_test.lua") + ":2: "), std::string::npos) << failing.out;
}

TEST_F(ToolUse, ARuleThatDoesNotLoadDoesNotStopAReplay) {
  fs::create_directory(path("half"));
  fs::copy(kScripts + "/rules/ovality_drift.lua", path("half/ovality_drift.lua"));
  test::write_file(path("half/bad.lua"), "return {\n");
  std::string text = test::read_file(path("lrmate.toml"));
  text.replace(text.find("rules.d"), 7, "half");
  test::write_file(path("half.toml"), text);
  const Outcome outcome =
      ballbar({"replay", kDemo, "--config", path("half.toml"), "--db", path("half.db"), "--quiet"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_TRUE(outcome.err.starts_with("ballbar: bad.lua:")) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NE(ballbar({"alarms", "--db", path("half.db")}).out.find("ovality_drift"), std::string::npos);
}

TEST_F(ToolUse, TheConfigurationIsChecked) {
  for (const Words& words : {Words{"config", "check", path("lrmate.toml")},
                             Words{"config", "check", "--config", path("lrmate.toml")}}) {
    const Outcome outcome = ballbar(words);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out,
              "robot lrmate-1: 3 tests, 6 joints from base to tcp\n"
              "  test A: the robot can drive it\n"
              "  test B: the robot can drive it\n"
              "  test Y: the robot can drive it\n" +
                  path("lrmate.toml") + " is good\n");
  }
}

TEST_F(ToolUse, ATestThatTheRobotCannotDriveIsFoundByTheCheck) {
  std::string text = test::read_file(path("lrmate.toml"));
  const std::string centre = "centre_mm = [380, 320, -251]";
  text.replace(text.find(centre), centre.size(), "centre_mm = [880, 320, -251]");
  test::write_file(path("far.toml"), text);
  const Outcome outcome = ballbar({"config", "check", path("far.toml")});
  EXPECT_EQ(outcome.code, 1) << outcome.err;
  EXPECT_NE(outcome.out.find("test A: the robot can drive it"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("'B'"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("deg"), std::string::npos) << outcome.out;
  EXPECT_EQ(outcome.out.find("is good"), std::string::npos) << outcome.out;
}

}  // namespace
}  // namespace ballbar
