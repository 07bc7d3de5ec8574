// The practice recordings come from generators that share no code with us, one of them from MuJoCo. Where the
// answer stands in the configuration, what the model leaves of the measurement is the instrument's noise.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdio>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "support/process.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

using nlohmann::json;
namespace fs = std::filesystem;

const fs::path kKnownPractice = fs::path(BALLBAR_SHARED_DIR) / "data" / "practice";

std::string effect_table(const std::string& effect, int joint, const json& words) {
  std::string text = "\n[[robot.effect]]\neffect = \"" + effect + "\"\n";
  if (joint > 0) text += "joint = " + std::to_string(joint) + "\n";
  for (const auto& [name, value] : words.items()) text += name + " = " + value.dump() + "\n";
  return text;
}

/// What the answer says of the robot, as [[robot.effect]] tables.
std::string known_physics(const json& answer) {
  std::string text;
  int joint = 0;
  for (const json& deg : answer["always_present"]["joint_zero_offset_deg"])
    text += effect_table("joint_zero_offset", ++joint, {{"offset_deg", deg}});
  for (const json& planted : answer["planted"]) {
    json words;
    if (planted.contains("kind")) words["kind"] = planted["kind"];
    for (const json& p : planted["parameters"]) words[p["name"]] = p["value"];
    text += effect_table(planted["effect"], planted.value("joint", 0), words);
  }
  return text;
}

struct KnownCase {
  const char* name;
  double least_nominal_um;  ///< median gap of the nominal model: something is there to be explained
  double most_known_um;  ///< median gap with the answer; 0.7 um of white noise and 0.7 um of slow noise were
                         ///< added
};

class KnownPhysics : public testing::TestWithParam<KnownCase> {
 protected:
  /// Median of gap_rms_um over all runs.
  double median_gap_um(const std::string& configuration) {
    const std::string config = dir_.path() + "/c.toml",
                      db = dir_.path() + "/" + std::to_string(++count_) + ".db";
    test::write_file(config, configuration);
    const test::Outcome replay = test::run({test::kBallbar, "replay", (folder() / "recording.lcm").string(),
                                            "--config", config, "--db", db, "--quiet"});
    EXPECT_EQ(replay.code, 0) << replay.err;
    std::vector<double> gaps;
    const json exported = json::parse(test::run({test::kBallbar, "export", "--json", "--db", db}).out);
    for (const json& run : exported["runs"]) {
      EXPECT_EQ(run["predicted_from"], "joints") << run["run"];
      gaps.push_back(run["gap_rms_um"].get<double>());
    }
    EXPECT_GE(gaps.size(), 16u);
    std::sort(gaps.begin(), gaps.end());
    return gaps.at(gaps.size() / 2);
  }
  fs::path folder() const { return kKnownPractice / GetParam().name; }

  test::TempDir dir_;
  int count_ = 0;
};

TEST_P(KnownPhysics, LeavesTheNoise) {
  if (!fs::exists(folder())) GTEST_SKIP() << "no practice recordings at " << kKnownPractice;
  const json answer = json::parse(test::read_file((folder() / "answer.json").string()));
  std::string text = test::read_file((folder() / "ballbard.toml").string());
  text.replace(text.find("urdf = \""), 8, "urdf = \"" + folder().string() + "/");
  const bool commanded =
      answer["joints_on_the_wire"].get<std::string>().find("commanded") != std::string::npos;
  text.insert(text.find("joint_convention"),
              commanded ? "joints = \"commanded\"\n" : "joints = \"feedback\"\n");
  const double nominal_um = median_gap_um(text), known_um = median_gap_um(text + known_physics(answer));
  std::printf("practice case %s: median gap %.2f um nominal, %.2f um with the known physics\n",
              GetParam().name, nominal_um, known_um);
  EXPECT_GT(nominal_um, GetParam().least_nominal_um);
  EXPECT_LT(known_um, GetParam().most_known_um);
}

std::string known_name(const testing::TestParamInfo<KnownCase>& of) {
  return std::string("KnownCase") + of.param.name;
}

INSTANTIATE_TEST_SUITE_P(Cases, KnownPhysics,
                         testing::Values(KnownCase{"01", 100.0, 0.95},  // servo lag, compliance
                                         KnownCase{"09", 18.0, 0.95}),  // friction wind-up
                         known_name);

// Many seconds each where sanitizers run: scripts/proof physics.
INSTANTIATE_TEST_SUITE_P(
    DISABLED_Long, KnownPhysics,
    testing::Values(KnownCase{"02", 70.0, 0.95},   // eccentricity
                    KnownCase{"03", 18.0, 2.5},    // transmission error, wind-up, compliance of wrong masses
                    KnownCase{"04", 20.0, 0.95},   // zero offsets alone
                    KnownCase{"05", 50.0, 1.0},    // compliance, thermal growth
                    KnownCase{"06", 30.0, 0.95},   // path smoothing, link geometry, transmission error
                    KnownCase{"08", 90.0, 1.05}),  // MuJoCo: compliance, backlash
    known_name);

}  // namespace
}  // namespace ballbar
