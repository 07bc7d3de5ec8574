// The main job's recording without its marks, without its bar, or without both: what `ballbar replay` makes
// of the joints alone.

#include <gtest/gtest.h>

#include <ballbar/joint_samples_t.hpp>
#include <cmath>
#include <filesystem>
#include <lcm/lcm-cpp.hpp>
#include <nlohmann/json.hpp>
#include <set>

#include "support/messages.hpp"
#include "support/process.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

using nlohmann::json;

const std::string kUnmarkedRecordings = BALLBAR_SHARED_DIR "/data/recordings";

/// Copies a log without some channels. J3 says `off` [rad] too much, so that the joints draw circles that are
/// not perfect.
void copy_without(const std::string& from, const std::string& to, const std::set<std::string>& left_out,
                  double off) {
  lcm::LogFile in(from, "r"), out(to, "w");
  while (const lcm::LogEvent* event = in.readNextEvent()) {
    if (left_out.contains(event->channel)) continue;
    lcm::LogEvent copy = *event;
    std::vector<std::uint8_t> bytes;
    if (event->channel == "JOINTS") {
      joint_samples_t joints;
      ASSERT_GE(joints.decode(event->data, 0, event->datalen), 0);
      joints.position_rad.at(2) += off;
      bytes = test::bytes_of(joints);
      copy.data = bytes.data();
      copy.datalen = static_cast<std::int32_t>(bytes.size());
    }
    out.writeEvent(&copy);
  }
}

class UnmarkedRecordings : public testing::Test {
 protected:
  void SetUp() override {
    if (!std::filesystem::exists(kUnmarkedRecordings + "/paper-before.lcm"))
      GTEST_SKIP() << "no recordings at " << kUnmarkedRecordings;
  }
  /// The circles that replay makes of the recording.
  json circles(const std::set<std::string>& left_out, double off = 0.0) const {
    const std::string log = dir.path() + "/a.lcm";
    const std::string db = dir.path() + "/a" + std::to_string(left_out.size()) + std::to_string(off) +
                           (left_out.empty() ? "" : *left_out.begin()) + ".db";
    copy_without(kUnmarkedRecordings + "/paper-before.lcm", log, left_out, off);
    const test::Outcome replayed = test::run({test::kBallbar, "replay", log, "--config",
                                              kUnmarkedRecordings + "/ballbard.toml", "--db", db, "--quiet"});
    EXPECT_EQ(replayed.code, 0) << replayed.err;
    const json all = json::parse(test::run({test::kBallbar, "export", "--json", "--db", db}).out);
    json found = json::array();
    for (const json& run : all["runs"])
      if (run["kind"] == "circle") found.push_back(run);
    return found;
  }
  test::TempDir dir;
};

constexpr double kOff = 1e-3;  // [rad]

TEST_F(UnmarkedRecordings, JointsAloneGiveTheCirclesThatTheMarksName) {
  const json marked = circles({"BALLBAR"}, kOff);
  const json recognised = circles({"BALLBAR", "TEST_MARK"}, kOff);
  ASSERT_EQ(marked.size(), 20u);
  ASSERT_EQ(recognised.size(), 20u);
  for (std::size_t i = 0; i < 20; ++i) {
    const json& want = marked[i];
    const json& got = recognised[i];
    SCOPED_TRACE(want["run"].get<std::string>());
    EXPECT_EQ(got["run"], want["run"]) << "test, direction and repetition";
    EXPECT_EQ(want["ended_by"], "mark");
    EXPECT_EQ(got["ended_by"], "geometry");
    for (const json& run : {got, want}) {
      EXPECT_EQ(run["status"], "ok");
      EXPECT_EQ(run["source"], "joints");
      EXPECT_EQ(run["angle_source"], "joints");
    }
    // Within the marks, which lie outside the motion by at most a second.
    EXPECT_GE(got["started_us"], want["started_us"]);
    EXPECT_LE(got["ended_us"], want["ended_us"]);
    EXPECT_LE(got["started_us"].get<std::int64_t>() - want["started_us"].get<std::int64_t>(), 1'000'000);
    EXPECT_EQ(got["samples"], want["samples"]);
    EXPECT_NEAR(got["feed_mm_s"], 55.33, 0.05);
    EXPECT_GT(want["ovality_um"], 1.0) << "a joint that is off draws no circle: else this proves nothing";
    for (const char* name : {"ovality_um", "eccentricity_x_um", "eccentricity_y_um", "circular_deviation_um",
                             "circular_deviation_mz_um", "mean_radius_deviation_um", "noise_um"})
      EXPECT_NEAR(got[name], want[name], 1e-6) << name;
  }
}

TEST_F(UnmarkedRecordings, TheBarWithoutMarksGivesTheFiguresOfTheMarkedRuns) {
  const json marked = circles({});
  const json recognised = circles({"TEST_MARK"});
  ASSERT_EQ(marked.size(), 20u);
  ASSERT_EQ(recognised.size(), 20u);
  for (std::size_t i = 0; i < 20; ++i) {
    SCOPED_TRACE(marked[i]["run"].get<std::string>());
    EXPECT_EQ(recognised[i]["run"], marked[i]["run"]);
    EXPECT_EQ(recognised[i]["status"], "ok");
    EXPECT_EQ(recognised[i]["source"], "bar");
    EXPECT_EQ(recognised[i]["samples"], marked[i]["samples"]);
    for (const char* name : {"ovality_um", "eccentricity_x_um", "circular_deviation_um", "noise_um"})
      EXPECT_NEAR(recognised[i][name], marked[i][name], 1e-6) << name;
  }
}

TEST_F(UnmarkedRecordings, WithMarksNothingIsRecognisedASecondTime) {
  const json marked = circles({});
  ASSERT_EQ(marked.size(), 20u);
  for (const json& run : marked) EXPECT_EQ(run["ended_by"], "mark");
}

TEST_F(UnmarkedRecordings, ACircleThatIsTooFarOffIsNone) {
  EXPECT_TRUE(circles({"BALLBAR", "TEST_MARK"}, 0.02).empty()) << "J3 off by more than a degree";
}

}  // namespace
}  // namespace ballbar
