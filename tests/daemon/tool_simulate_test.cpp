// ballbar simulate as people type it: figures, logs that replay to the same figures, pictures, and what it
// says where it cannot.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "bus/log_file.hpp"
#include "support/tool_test.hpp"

namespace ballbar {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::ballbar;
using test::kScripts;
using test::Outcome;
using test::Words;

const std::string kConfig = kScripts + "/robots/lrmate200ic.toml";
const std::string kJ3 = "joint_zero_offset,joint=3,offset_deg=0.172";

class ToolSimulate : public testing::Test {
 protected:
  std::string path(const std::string& name) const { return dir.path() + "/" + name; }

  static Words with(Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  }
  static Outcome simulate(const Words& more) {
    return ballbar(with({"simulate", "--config", kConfig}, more));
  }
  static json figures(const Words& more) {
    const Outcome outcome = simulate(with({"--json"}, more));
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.code == 0 ? json::parse(outcome.out) : json();
  }
  /// The error's one line, without "ballbar: ".
  static std::string error_of(const Words& words, int code = 2) {
    const Outcome outcome = ballbar(words);
    EXPECT_EQ(outcome.code, code) << outcome.err;
    EXPECT_EQ(outcome.out, "");
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
    EXPECT_TRUE(outcome.err.starts_with("ballbar: ")) << outcome.err;
    return outcome.err.size() > 10 ? outcome.err.substr(9, outcome.err.size() - 10) : "";
  }
  /// The shipped configuration with its URDF and one thing changed in either.
  std::string changed(const std::string& in_config, const std::string& config_now,
                      const std::string& in_urdf = "", const std::string& urdf_now = "") const {
    std::string urdf = test::read_file(kScripts + "/robots/lrmate200ic.urdf");
    std::string config = test::read_file(kConfig);
    EXPECT_NE(config.find(in_config), std::string::npos) << in_config;
    EXPECT_NE(urdf.find(in_urdf), std::string::npos) << in_urdf;
    test::write_file(path("lrmate200ic.urdf"), urdf.replace(urdf.find(in_urdf), in_urdf.size(), urdf_now));
    test::write_file(path("c.toml"), config.replace(config.find(in_config), in_config.size(), config_now));
    return path("c.toml");
  }
  std::string error_with(const std::string& in_config, const std::string& config_now,
                         const std::string& in_urdf = "", const std::string& urdf_now = "") const {
    return error_of(
        {"simulate", "--test", "A", "--config", changed(in_config, config_now, in_urdf, urdf_now)});
  }

  test::TempDir dir;
};

/// Every figure of `expected` is in `found`, equal to `tolerance` [um] or, for other units, as it stands.
void expect_same_figures(const json& found, const json& expected, double tolerance,
                         const std::string& where) {
  if (expected.is_object()) {
    for (const auto& [key, value] : expected.items()) {
      if (key.ends_with("_sd") || key == "id" || key == "sd_um" || key.ends_with("_deg")) continue;
      ASSERT_TRUE(found.contains(key)) << where << "." << key;
      expect_same_figures(found[key], value, tolerance, where + "." + key);
    }
  } else if (expected.is_array()) {
    ASSERT_EQ(found.size(), expected.size()) << where;
    for (std::size_t i = 0; i < expected.size(); ++i)
      expect_same_figures(found[i], expected[i], tolerance, where + "[" + std::to_string(i) + "]");
  } else if (expected.is_number_float()) {
    EXPECT_NEAR(found.get<double>(), expected.get<double>(), tolerance) << where;
  } else {
    EXPECT_EQ(found, expected) << where;
  }
}

TEST_F(ToolSimulate, ALogReplaysToTheFiguresOfTheDirectComputation) {
  const Words words{"--effect", kJ3, "--effect",
                    "joint_lost_motion,joint=1,kind=friction_windup,width_deg=0.01"};
  const json direct = figures(words);
  ASSERT_EQ(direct["runs"].size(), 6u);
  const Outcome written = simulate(with(words, {"-o", path("x.lcm")}));
  ASSERT_EQ(written.code, 0) << written.err;
  const LogFile log = inspect_log(path("x.lcm"));
  EXPECT_TRUE(log.whole());
  EXPECT_EQ(written.out, path("x.lcm") + ": " + std::to_string(log.events) + " messages\n");
  const Outcome replayed =
      ballbar({"replay", path("x.lcm"), "--config",
               changed("# A FANUC", "[rules]\ndirectory = \".\"\n# A FANUC"), "--db", path("x.db")});
  EXPECT_NE(replayed.out.find(" 0 lost, 0 refused\n6 runs stored, 6 of them ok"), std::string::npos)
      << replayed.out;
  const json stored = json::parse(ballbar({"export", "--json", "--db", path("x.db")}).out);
  ASSERT_EQ(stored["runs"].size(), 6u);
  for (std::size_t i = 0; i < 6; ++i)  // the wire's units cost a last digit
    expect_same_figures(direct["runs"][i], stored["runs"][i], 1e-6, "run " + std::to_string(i));
}

TEST_F(ToolSimulate, TheJsonHoldsBallAndPlainHarmonicsOfTheBar) {
  const json fitted = figures({"--effect", kJ3, "--test", "A", "--centre", "fitted"});
  EXPECT_EQ(fitted["ball"], "fitted");
  EXPECT_EQ(fitted["effects"],
            json::parse(R"([{"effect": "joint_zero_offset", "joint": 3, "offset_deg": 0.172}])"));
  for (const json& run : fitted["runs"]) {
    EXPECT_FALSE(run.contains("id"));
    EXPECT_EQ(run["status"], "ok");
    ASSERT_EQ(run["bar_harmonics"].size(), 11u);
    // metrology.md 6.1: 0.172 deg = 10.32 arcmin of J3
    EXPECT_NEAR(run["bar_harmonics"][0]["cos_um"].get<double>(), 10.32 * 5.842, 0.1);
    EXPECT_NEAR(run["bar_harmonics"][2]["amplitude_um"].get<double>(), 10.32 * 18.921, 0.1);
    EXPECT_NEAR(run["bar_harmonics"][3]["amplitude_um"].get<double>(), 10.32 * 1.984, 0.1);
    EXPECT_NEAR(run["p2p_um"].get<double>(), run["circular_deviation_um"].get<double>(), 0.1);
    for (std::size_t i = 0; i < 3; ++i) {
      const double programmed[] = {380, -320, -251};
      EXPECT_NEAR(run["ball_mm"][i].get<double>() - run["centre_shift_mm"][i].get<double>(), programmed[i],
                  1e-9);
    }
  }
  const json programmed = figures({"--effect", kJ3, "--test", "A", "--centre", "programmed"});
  for (const json& run : programmed["runs"])
    EXPECT_EQ(run["centre_shift_mm"], json::parse("[0.0, 0.0, 0.0]"));
}

TEST_F(ToolSimulate, SameSeedSameBytesAndEffectsOfTheConfigurationCount) {
  const Words noisy{"--test", "A", "--noise-um", "0.7"};
  for (const std::string name : {"a.lcm", "b.lcm"})
    ASSERT_EQ(simulate(with(noisy, {"--seed", "5", "-o", path(name)})).code, 0);
  ASSERT_EQ(simulate(with(noisy, {"--seed", "6", "-o", path("c.lcm")})).code, 0);
  EXPECT_EQ(test::read_file(path("a.lcm")), test::read_file(path("b.lcm")));
  EXPECT_NE(test::read_file(path("a.lcm")), test::read_file(path("c.lcm")));
  ASSERT_EQ(simulate({"--test", "A,B", "--noise-um", "0.7", "--seed", "5", "-o", path("ab.lcm")}).code, 0);
  EXPECT_TRUE(test::read_file(path("ab.lcm")).starts_with(test::read_file(path("a.lcm"))))
      << "a test that is added behind";

  const std::string config = changed("# A FANUC", "# A FANUC");
  test::write_file(config,
                   test::read_file(config) +
                       "\n[[robot.effect]]\neffect = \"joint_zero_offset\"\njoint = 3\noffset_deg = 0.172\n");
  const Words own{"simulate", "--config", config, "--test", "A"};
  EXPECT_EQ(ballbar(own).out, simulate({"--test", "A", "--effect", kJ3}).out);
  EXPECT_EQ(ballbar(with(own, {"--nominal"})).out, simulate({"--test", "A"}).out);
  EXPECT_NE(ballbar(own).out, ballbar(with(own, {"--nominal"})).out);
}

TEST_F(ToolSimulate, ThePicturesShowTheTraceAndTheJoints) {
  ASSERT_EQ(simulate({"--test", "A", "--effect", kJ3, "--plot", path("a.svg")}).code, 0);
  EXPECT_NE(test::read_file(path("a.svg")).find("A-1#1"), std::string::npos);
  EXPECT_NE(test::read_file(path("a-joints.svg")).find("joint angle"), std::string::npos);
  ASSERT_EQ(simulate({"--test", "Y", "--effect", kJ3, "--plot", path("y.png")}).code, 0);
  EXPECT_TRUE(test::read_file(path("y.png")).starts_with("\x89PNG"));
  EXPECT_TRUE(test::read_file(path("y-joints.png")).starts_with("\x89PNG"));
  EXPECT_NE(
      error_of({"simulate", "--config", kConfig, "--plot", path("x.svg")}).find("do not go into one plot"),
      std::string::npos);
}

TEST_F(ToolSimulate, RunsThatAreNotOkAreOneLineAndOne) {
  // A bar that reads 60 mm too long on a circle of 100 mm.
  const Outcome outcome =
      simulate({"--test", "A", "--effect", "gauge_jump,jump_um=60000,time_us=1", "--json"});
  EXPECT_EQ(outcome.code, 1);
  EXPECT_EQ(outcome.err.find("ballbar: 2 of 2 simulated runs are not ok, first A+1#1: implausible: "), 0U)
      << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1);
  EXPECT_EQ(json::parse(outcome.out)["runs"].size(), 2U) << "they are shown all the same";
}

// Figures are made only where they are shown: that must be seen in nothing else.
TEST_F(ToolSimulate, TheLogAndTheAnswerAreTheSameWhateverIsShownBesideIt) {
  for (const std::string jump_um : {"60000", "3"}) {
    const Words words{"--noise-um", "0.7", "--seed",   "9",
                      "--effect",   kJ3,   "--effect", "gauge_jump,jump_um=" + jump_um + ",time_us=1"};
    const Outcome alone = simulate(with(words, {"-o", path("alone.lcm")}));
    EXPECT_EQ(alone.code, jump_um == "3" ? 0 : 1) << alone.err;
    const std::string log = test::read_file(path("alone.lcm"));
    EXPECT_GT(log.size(), 100'000U);
    const Outcome figures = simulate(with(words, {"--json", "-o", path("figures.lcm")}));
    EXPECT_EQ(json::parse(figures.out)["runs"].size(), 6U);
    EXPECT_EQ(test::read_file(path("figures.lcm")), log);
    EXPECT_EQ(figures.code, alone.code);
    EXPECT_EQ(figures.err, alone.err);
    const Words circles{"--test", "A", "--plot", path("beside.svg"), "-o", path("picture.lcm")};
    EXPECT_EQ(simulate(with(words, circles)).code, alone.code);
    EXPECT_TRUE(log.starts_with(test::read_file(path("picture.lcm"))))
        << "circle A is the first of the tests";
  }
}

TEST_F(ToolSimulate, BadUseIsOneLineAndTwo) {
  const auto says = [&](const Words& words, const std::string& what, int code = 2) {
    const std::string error = error_of(with({"simulate", "--config", kConfig}, words), code);
    EXPECT_NE(error.find(what), std::string::npos) << error << "\ndoes not say: " << what;
  };
  says({"--effect", "bent_arm"}, "unknown effect 'bent_arm'; known are: joint_zero_offset");
  says({"--effect", "joint_zero_offset,joint=3"}, "needs 'offset_deg'");
  says({"--effect", "joint_zero_offset,joint=7,offset_deg=1"}, "the robot's joints are 1 to 6");
  says({"--effect", "joint_zero_offset,joint=1.5,offset_deg=1"},
       "'joint' is a whole number from 1, not '1.5'");
  says({"--effect", "joint_zero_offset,joint=3,offset_deg=1x"}, "'offset_deg'");
  says({"--effect", "joint_zero_offset,joint=3,offset_deg="}, "'offset_deg=' is no NAME=VALUE");
  says({"--effect", "joint_zero_offset,joint=3,joint=3,offset_deg=1"}, "'joint' stands there twice");
  says({"--effect", "joint=3"}, "begins with the effect's name");
  says({"--test", "Q"}, "has no test 'Q'; configured are: A, B, Y");
  says({"--robot", "r9"}, "no robot 'r9'; there is lrmate-1");
  says({"--direction", "up"}, "--direction");
  says({"--centre", "left"}, "--centre");
  says({"--repetitions", "0"}, "'0' is no whole number of 1 to 1000");
  says({"--noise-um", "nan"}, "'nan' is no number of micrometres");
  says({"--seed", "-1"}, "--seed");
  says({"--plot", path("x.pdf")}, "a picture's name ends in .svg or .png");
  says({"--series", std::string(128, 's'), "-o", path("x.lcm")}, "--series: a label of 128 bytes");
  says({"-o", dir.path()}, "is a folder");
  says({"-o", path("none/x.lcm")}, "none/x.lcm: cannot be written", 3);
  EXPECT_TRUE(fs::is_empty(dir.path())) << "nothing is left of what failed";
}

TEST_F(ToolSimulate, WhatTheRobotCannotDriveIsOneLineWithTestAngleAndJoint) {
  const std::string centre = "centre_mm = [380, -320, -251]";
  EXPECT_NE(
      error_with(centre, "centre_mm = [900, 0, -251]")
          .find("test 'A': at 300.0 deg of the circle no joint angles bring the tool there; move centre_mm"),
      std::string::npos);
  EXPECT_NE(
      error_with(centre, "centre_mm = [390, 0, -251]").find("the arm is singular: J4 and J6 turn against"),
      std::string::npos);
  EXPECT_NE(error_with(centre, centre, "lower=\"-1.0471975512\" upper=\"2.4434609528\"",
                       "lower=\"-1.0471975512\" upper=\"1.1\"")
                .find(" deg of the circle J2 (joint_2) would pass its limits of -60.0 to 63.0 deg"),
            std::string::npos);
  EXPECT_NE(
      error_with("tool_rpy_deg = [180, 0, 0]", "").find("test 'A': how the tool is held is not configured"),
      std::string::npos);
  EXPECT_NE(error_with(centre, centre + "\nposture_deg = [0, 0, 0]")
                .find("test 'A': 'posture_deg' holds 3 angles, the chain has 6 joints"),
            std::string::npos);
  EXPECT_NE(error_with("feed_mm_s = 55.33", "").find("test 'A': give 'feed_mm_s'"), std::string::npos);
}

TEST_F(ToolSimulate, AWrongUrdfOrConventionIsOneLine) {
  const std::string none = "# A FANUC";
  const auto error = [&](const std::string& in_urdf, const std::string& now) {
    return error_with(none, none, in_urdf, now);
  };
  EXPECT_NE(error("<link name=\"link_3\">", "<link name=\"link_33\">").find("link_3"), std::string::npos);
  EXPECT_NE(error("upper=\"2.9670597284\"", "upper=\"nan\"").find("joint_1"), std::string::npos);
  EXPECT_NE(error_with("tip = \"tcp\"", "tip = \"needle\"").find("needle"), std::string::npos);
  EXPECT_NE(error("<axis xyz=\"0 -1 0\"/>", "<axis xyz=\"0 1 0\"/>").find("joint_convention"),
            std::string::npos);
}

TEST_F(ToolSimulate, HelpIsCompleteAndTheTableNamesItsUnits) {
  const Outcome help = ballbar({"simulate", "--help"});
  EXPECT_EQ(help.code, 0);
  for (const std::string word :
       {"--config", "--robot", "--test", "--direction", "--repetitions", "--effect", "--nominal", "--centre",
        "--noise-um", "--seed", "--series", "--start-us", "--output", "--plot", "--json"})
    EXPECT_NE(help.out.find(word), std::string::npos) << word;
  const Outcome table = simulate({"--effect", kJ3});
  EXPECT_EQ(table.code, 0);
  EXPECT_EQ(table.err, "") << "no progress in a pipe";
  EXPECT_EQ(std::count(table.out.begin(), table.out.end(), '\n'), 1 + 4 + 1 + 4) << table.out;
  EXPECT_NE(table.out.find("h2 um"), std::string::npos);
  EXPECT_NE(table.out.find("Y-1#1"), std::string::npos);
}

}  // namespace
}  // namespace ballbar
