// The main job's recordings through `ballbar replay`, against what an independent script found in them.

#include <gtest/gtest.h>

#include <cmath>
#include <filesystem>
#include <map>
#include <nlohmann/json.hpp>

#include "support/process.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

const std::string kRecordings = BALLBAR_SHARED_DIR "/data/recordings";

struct Replayed {
  json runs, summary;
  std::string exported;
  test::Outcome replay;
};

Replayed replay(const std::string& db, int times = 1) {
  Replayed r;
  for (int i = 0; i < times; ++i)
    r.replay = test::run({test::kBallbar, "replay", kRecordings + "/paper-before.lcm",
                          kRecordings + "/paper-after.lcm", "--config", kRecordings + "/ballbard.toml",
                          "--db", db, "--quiet"});
  r.exported = test::run({test::kBallbar, "export", "--json", "--db", db}).out;
  r.runs = json::parse(r.exported)["runs"];
  r.summary = json::parse(test::run({test::kBallbar, "summary", "--json", "--db", db}).out);
  return r;
}

class PaperRecordings : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    if (!fs::exists(kRecordings + "/expected.json")) return;
    expected = json::parse(test::read_file(kRecordings + "/expected.json"));
    replayed = replay(dir.path() + "/a.db");
  }
  void SetUp() override {
    if (expected.is_null()) GTEST_SKIP() << "no recordings at " << kRecordings;
  }
  static const json& find(const std::string& robot_run, std::int64_t started_us) {
    for (const json& run : replayed.runs)
      if (run["run"] == robot_run && run["started_us"] == started_us) return run;
    throw std::runtime_error("no run " + robot_run);
  }

  static inline test::TempDir dir;
  static inline json expected;
  static inline Replayed replayed;
};

TEST_F(PaperRecordings, EveryRunArrivesWholeAndOk) {
  EXPECT_EQ(replayed.replay.code, 0) << replayed.replay.err;
  ASSERT_EQ(replayed.runs.size(), 80u);
  for (const json& run : replayed.runs) {
    EXPECT_EQ(run["status"], "ok") << run["run"];
    EXPECT_EQ(run["lost_messages"], 0) << run["run"];
    EXPECT_EQ(run["angle_source"], run["kind"] == "circle" ? "joints" : "");
  }
}

TEST_F(PaperRecordings, EveryCircleIsWithinItsTolerances) {
  const json& tol = expected["tolerances"];
  const double harmonic_tol = tol["a_um_b_um_amplitude_um"];
  int circles = 0;
  for (const auto& [file, recording] : expected["recordings"].items()) {
    for (const json& want : recording["circles"]) {
      const json& got = find(want["run"], want["begin_time_us"]);
      const std::string where = file + " " + want["run"].get<std::string>();
      SCOPED_TRACE(where);
      ++circles;
      EXPECT_EQ(got["series"], want["series"]);
      EXPECT_NEAR(got["samples"].get<double>(), want["samples"].get<double>(), tol["samples"].get<double>());
      EXPECT_NEAR(got["mean_radius_deviation_um"], want["mean_radial_deviation_um"],
                  tol["mean_radial_deviation_um"]);
      EXPECT_NEAR(got["eccentricity_x_um"], want["eccentricity_um"][0], tol["eccentricity_um"]);
      EXPECT_NEAR(got["eccentricity_y_um"], want["eccentricity_um"][1], tol["eccentricity_um"]);
      EXPECT_NEAR(
          got["eccentricity_um"].get<double>(),
          std::hypot(want["eccentricity_um"][0].get<double>(), want["eccentricity_um"][1].get<double>()),
          tol["eccentricity_um"]);
      EXPECT_NEAR(got["circular_deviation_um"], want["circular_deviation_lsc_um"],
                  tol["circular_deviation_lsc_um"]);
      EXPECT_NEAR(got["circular_deviation_mz_um"], want["circular_deviation_mzc_um"],
                  tol["circular_deviation_mzc_um"]);
      EXPECT_NEAR(got["radial_max_um"].get<double>() - got["radial_min_um"].get<double>(),
                  got["circular_deviation_um"], 1e-9);
      ASSERT_EQ(got["harmonics"].size(), 30u);
      for (int k = 1; k <= 10; ++k) {
        const json& h = got["harmonics"][k - 1];
        EXPECT_EQ(h["order"], k);
        EXPECT_NEAR(h["cos_um"], want["a_um"][k], harmonic_tol) << "order " << k;
        EXPECT_NEAR(h["sin_um"], want["b_um"][k], harmonic_tol) << "order " << k;
        EXPECT_NEAR(h["amplitude_um"], want["amplitude_um"][k], harmonic_tol) << "order " << k;
        EXPECT_GT(h["sd_um"], 0.0);
      }
      EXPECT_NEAR(got["ovality_um"], want["amplitude_um"][2], harmonic_tol);
    }
  }
  EXPECT_EQ(circles, 40);
}

TEST_F(PaperRecordings, TheMeansPerTestAndDirectionAreWithinTheirTolerances) {
  int groups = 0;
  for (const auto& [file, recording] : expected["recordings"].items()) {
    const std::string series = recording["circles"][0]["series"];
    for (const json& want : recording["averages"]) {
      for (const json& got : replayed.summary["circles"]) {
        if (got["series"] != series || got["test"] != want["test"] || got["direction"] != want["direction"])
          continue;
        ++groups;
        SCOPED_TRACE(file + " " + want["test"].get<std::string>() + " " +
                     std::to_string(want["direction"].get<int>()));
        EXPECT_EQ(got["runs"], want["runs"]);
        EXPECT_NEAR(got["harmonic2_mean_amplitude_um"], want["harmonic2_mean_amplitude_um"], 0.02);
        EXPECT_NEAR(got["harmonic2_mean_vector_um"][0], want["harmonic2_mean_vector_um"][0], 0.02);
        EXPECT_NEAR(got["harmonic2_mean_vector_um"][1], want["harmonic2_mean_vector_um"][1], 0.02);
        EXPECT_NEAR(got["circular_deviation_mean_um"], want["circular_deviation_lsc_mean_um"], 0.1);
      }
    }
  }
  EXPECT_EQ(groups, 8);
}

TEST_F(PaperRecordings, EveryLineIsWithinItsTolerances) {
  const json& tol = expected["tolerances"];
  int lines = 0;
  for (const auto& [file, recording] : expected["recordings"].items()) {
    const std::string series = recording["circles"][0]["series"];
    for (const json& want : recording["lines"]) {
      for (const json& got : replayed.summary["lines"]) {
        if (got["series"] != series || got["test"] != want["test"] || got["axis"] != want["axis"]) continue;
        ++lines;
        SCOPED_TRACE(file + " " + want["axis"].get<std::string>());
        EXPECT_EQ(got["runs"], want["runs"]);
        for (const char* set :
             {"all_runs", "forward", "forward_mean_of_runs", "backward", "backward_mean_of_runs"})
          for (const auto& [name, value] : want[set].items())
            EXPECT_NEAR(got[set][name], value,
                        tol[name.find("slope") == std::string::npos ? "straightness_um" : "slope_um_per_m"])
                << set << " " << name;
        EXPECT_NEAR(std::abs(got["reversal_max_um"].get<double>()), want["reversal_max_abs_um"],
                    tol["reversal_um"]);
        EXPECT_NEAR(got["reversal_mean_um"], want["reversal_mean_um"], tol["reversal_um"]);
        ASSERT_EQ(got["forward_mean"].size(), want["position_mm"].size());
        for (std::size_t i = 0; i < want["position_mm"].size(); ++i) {
          EXPECT_NEAR(got["forward_mean"][i]["position_mm"], want["position_mm"][i], tol["position_mm"]);
          EXPECT_NEAR(got["forward_mean"][i]["deviation_um"], want["mean_forward_um"][i],
                      tol["straightness_um"]);
          EXPECT_NEAR(got["backward_mean"][i]["deviation_um"], want["mean_backward_um"][i],
                      tol["straightness_um"]);
          EXPECT_NEAR(got["forward_mean"][i]["reversal_um"], want["reversal_um"][i], tol["reversal_um"]);
        }
      }
    }
  }
  EXPECT_EQ(lines, 4);
}

TEST_F(PaperRecordings, ReplayTwiceGivesEqualExports) {
  const test::TempDir other;
  EXPECT_EQ(replay(other.path() + "/b.db").exported, replayed.exported) << "into another database";
  const Replayed again = replay(other.path() + "/b.db");
  EXPECT_EQ(again.exported, replayed.exported) << "into the same database: nothing is stored twice";
  EXPECT_NE(again.replay.out.find("0 runs stored, 0 of them ok, 80 already known"), std::string::npos)
      << again.replay.out;
}

}  // namespace
}  // namespace ballbar
