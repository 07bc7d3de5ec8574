// Circles and lines of one robot in one recording, through the programs: simulated, diagnosed from the log
// and from the database, drawn.

#include <gtest/gtest.h>

#include <algorithm>
#include <memory>
#include <nlohmann/json.hpp>
#include <set>

#include "support/process.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

using nlohmann::json;

const std::string kLineConfig = BALLBAR_SOURCE_DIR "/scripts/robots/lrmate200ic.toml";

class DiagnoseLines : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    dir_ = std::make_unique<test::TempDir>();
    const test::Outcome simulated =
        test::run({test::kBallbar, "simulate", "--config", kLineConfig, "--test", "A,B,Y", "--repetitions",
                   "2", "--noise-um", "1.5", "--effect",
                   "joint_lost_motion,joint=1,kind=backlash,width_deg=0.003", "-o", path("both.lcm")});
    ASSERT_EQ(simulated.code, 0) << simulated.err;
  }
  static void TearDownTestSuite() { dir_.reset(); }

  static std::string path(const std::string& name) { return dir_->path() + "/" + name; }

  static test::Outcome diagnose(std::vector<std::string> words) {
    words.insert(words.begin(), {test::kBallbar, "diagnose"});
    words.insert(words.end(), {"--config", kLineConfig});
    return test::run(words);
  }

  static inline std::unique_ptr<test::TempDir> dir_;
};

bool names_lost_motion_of_j1(const json& diagnosis) {
  return std::any_of(diagnosis["left_out"].begin(), diagnosis["left_out"].end(), [](const json& one) {
    return one["effect"] == "joint_lost_motion" && one["joint"] == 1;
  });
}

TEST_F(DiagnoseLines, FromTheLogAndFromTheDatabaseTheyAreFittedTogether) {
  const test::Outcome from_log = diagnose({path("both.lcm"), "--json"});
  ASSERT_LE(from_log.code, 1) << from_log.err;
  EXPECT_EQ(from_log.err, "") << "nothing is left aside";
  const test::Outcome replayed = test::run(
      {test::kBallbar, "replay", path("both.lcm"), "--config", kLineConfig, "--db", path("a.db"), "--quiet"});
  ASSERT_EQ(replayed.code, 0) << replayed.err;
  const test::Outcome from_store = diagnose({"--series", "simulated", "--db", path("a.db"), "--json"});
  ASSERT_LE(from_store.code, 1) << from_store.err;
  for (const test::Outcome& outcome : {from_log, from_store}) {
    const json diagnosis = json::parse(outcome.out);
    EXPECT_EQ(diagnosis["verdict"], "explained") << diagnosis["says"];
    EXPECT_TRUE(names_lost_motion_of_j1(diagnosis)) << diagnosis["left_out"].dump(1);
    const auto runs = diagnosis["fit"]["runs"].get<std::vector<std::string>>();
    EXPECT_EQ(runs.size(), 12u) << "a line that was read along two axes is one run";
    EXPECT_EQ(std::count(runs.begin(), runs.end(), "Y-1#2"), 1);
    EXPECT_NE(diagnosis["says"].get<std::string>().find("circles and lines"), std::string::npos);
    std::set<std::string> nuisance;
    for (const json& one : diagnosis["nuisance"]) nuisance.insert(one["name"].get<std::string>());
    for (const char* name : {"set_up1_ball_x_um", "set_up3_offset_um", "set_up3_slope_urad",
                             "set_up4_slope_urad", "time_shift_Y+1#1_X_ms"})
      EXPECT_TRUE(nuisance.contains(name)) << name;
    for (const json& place : diagnosis["located"])
      EXPECT_NE(place.contains("angle_deg"), place.contains("position_mm")) << place;
  }
}

TEST_F(DiagnoseLines, OfLinesAloneItSaysWhatTheyDoNotCarry) {
  const test::Outcome alone = diagnose({path("both.lcm"), "--hold-out", "A,B", "--json"});
  ASSERT_LE(alone.code, 1) << alone.err;
  const json diagnosis = json::parse(alone.out);
  EXPECT_TRUE(
      std::any_of(diagnosis["warnings"].begin(), diagnosis["warnings"].end(),
                  [](const json& warning) { return warning.get<std::string>().starts_with("Only lines"); }));
  EXPECT_EQ(diagnosis["held_out"]["runs"].size(), 8u);
}

TEST_F(DiagnoseLines, PageAndPicturesShowThemOverPosition) {
  ASSERT_LE(diagnose({path("both.lcm"), "-o", path("d.html")}).code, 1);
  EXPECT_NE(test::read_file(path("d.html")).find("position [mm]"), std::string::npos);
  for (const std::string picture : {"lines", "Y"}) {
    const test::Outcome drawn = diagnose({path("both.lcm"), "-o", path("p.svg"), "--picture", picture});
    ASSERT_LE(drawn.code, 1) << drawn.err;
    EXPECT_NE(test::read_file(path("p.svg")).find("position [mm]"), std::string::npos) << picture;
  }
}

}  // namespace
}  // namespace ballbar
