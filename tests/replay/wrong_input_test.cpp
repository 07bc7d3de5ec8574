// Recordings that are not what they are said to be, or too few: the diagnosis says so.

#include <gtest/gtest.h>

#include <algorithm>
#include <regex>

#include "gap/diagnose.hpp"
#include "gap/planned_robot.hpp"
#include "support/observed.hpp"
#include "support/process.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

constexpr std::uint64_t kWrongInputSeed = 5;

RobotSpec planned_robot() {
  return test::planned_robot({"plane and tool tilted by -30 deg about Y about",
                              "tool tilted by 30 deg about Y, 3 kg",
                              "plane and tool tilted by 30 deg about X, 3 kg"});
}

std::vector<EffectSpec> worn() {
  return {test::zero_offset(2, 0.08),
          test::zero_offset(3, -0.05),
          test::zero_offset(4, 0.1),
          test::zero_offset(5, 0.06),
          {"joint_compliance", 2, {{"compliance_rad_per_nm", 4e-5}}, {}},
          {"joint_compliance", 3, {{"compliance_rad_per_nm", 6e-5}}, {}}};
}

Diagnosis diagnosis_of(const RobotSpec& robot, const RobotModel& arm, const std::function<void(Run&)>& change,
                       int repetitions = 2) {
  SimulateOptions options;
  options.repetitions = repetitions;
  options.noise = 2e-6;
  options.seed = kWrongInputSeed;
  std::vector<Observation> seen = test::observed(robot, arm, worn(), options, change);
  const NoiseLevel noise = assign_noise(seen);
  return diagnose(GapModel(AsBuilt(arm, robot), robot), seen, {}, noise);
}

std::string warnings_of(const Diagnosis& diagnosis) {
  std::string text;
  for (const std::string& warning : diagnosis.warnings) text += warning + "\n";
  return text;
}

testing::AssertionResult says(const Diagnosis& diagnosis, const std::string& words) {
  if (warnings_of(diagnosis).find(words) != std::string::npos)
    return testing::AssertionSuccess() << "it says " << words;
  return testing::AssertionFailure() << "no '" << words << "' in: " << warnings_of(diagnosis);
}

TEST(WrongInput, SoundRecordingsRaiseNoDoubt) {
  const Diagnosis sound = diagnosis_of(planned_robot(), test::lrmate(), {});
  EXPECT_EQ(sound.verdict, Verdict::kExplained) << to_string(sound.verdict);
  EXPECT_FALSE(says(sound, "Swapped"));
  EXPECT_FALSE(says(sound, "Doubtful"));
  EXPECT_FALSE(says(sound, "No circle was repeated"));
}

TEST(WrongInput, ReadingsOfTheOtherDirectionAreFound) {
  // The bar's file of one direction went with the joints of the other: both of circle A.
  const Diagnosis swapped = diagnosis_of(planned_robot(), test::lrmate(), [](ballbar::Run& run) {
    if (run.test == "A") std::reverse(run.bar_deviation.begin(), run.bar_deviation.end());
  });
  EXPECT_TRUE(says(swapped, "Swapped directions: A+1, A-1 "));
  EXPECT_EQ(swapped.verdict, Verdict::kUnknownEffect);
  EXPECT_TRUE(swapped.left_out.empty()) << "no physics is named on such recordings";
}

TEST(WrongInput, APayloadThatWasNotThereIsDoubted) {
  const RobotSpec robot = planned_robot();
  const std::string loaded = robot.tests[3].name;
  const Diagnosis wrong = diagnosis_of(robot, test::lrmate(), [&](ballbar::Run& run) {
    if (run.test == loaded) run.payload = 0.438;
  });
  EXPECT_TRUE(says(
      wrong, "Doubtful payload: " + loaded + ", recorded with 0.44 kg, fit as if driven with about 3 kg"));
  EXPECT_EQ(wrong.verdict, Verdict::kUnknownEffect);
  EXPECT_TRUE(wrong.left_out.empty()) << "no physics is named on such recordings";
}

TEST(WrongInput, APayloadThatIsAThirdForAllIsDoubted) {
  const Diagnosis wrong = diagnosis_of(planned_robot(), test::lrmate(), [&](ballbar::Run& run) {
    if (run.payload > 1.0) run.payload = 1.0;
  });
  EXPECT_TRUE(says(wrong, "recorded with 1 kg, fit as if driven with about 3 kg"));
}

TEST(WrongInput, OneCircleWithoutRepeatsIsSaidToShowLittle) {
  RobotSpec robot = planned_robot();
  robot.tests.resize(1);
  const Diagnosis thin = diagnosis_of(robot, test::lrmate(), {}, 1);
  EXPECT_FALSE(thin.noise_from_repeats);
  EXPECT_TRUE(says(thin, "No circle was repeated"));
  EXPECT_TRUE(says(thin, "Only one circle"));
}

/// Through the tool: circle A of an LR Mate 200iC, diagnosed with another URDF.
test::Outcome diagnosed_with(const std::string& urdf) {
  const test::TempDir dir;
  const std::string robots = BALLBAR_SOURCE_DIR "/scripts/robots/";
  const std::string log = dir.path() + "/a.lcm", config = dir.path() + "/other.toml";
  const test::Outcome simulated =
      test::run({test::kBallbar, "simulate", "--config", robots + "lrmate200ic.toml", "--test", "A",
                 "--noise-um", "1", "--effect", "joint_zero_offset,joint=3,offset_deg=0.1", "-o", log});
  EXPECT_EQ(simulated.code, 0) << simulated.err;
  test::write_file(dir.path() + "/other.urdf", urdf);
  std::string text = test::read_file(robots + "lrmate200ic.toml");
  const std::string named = "lrmate200ic.urdf";
  text.replace(text.find(named), named.size(), "other.urdf");
  test::write_file(config, text);
  return test::run({test::kBallbar, "diagnose", log, "--config", config});
}

TEST(WrongInput, ARecordingOfAnotherRobotIsRefusedAndSaysWhatItsJointsDrive) {
  const test::Outcome other =
      diagnosed_with(test::read_file(BALLBAR_SOURCE_DIR "/scripts/robots/lrmate200id.urdf"));
  EXPECT_EQ(other.code, 2);
  EXPECT_NE(other.err.find("wrong_path: the joints drive a circle of"), std::string::npos) << other.err;
  EXPECT_NE(other.err.find("recording of another robot"), std::string::npos) << other.err;
  EXPECT_EQ(other.out, "");
}

TEST(WrongInput, WithoutMassesNoComplianceIsToBeTrusted) {
  const std::string whole = test::read_file(BALLBAR_SOURCE_DIR "/scripts/robots/lrmate200ic.urdf");
  const std::string without = std::regex_replace(whole, std::regex("<inertial>[^]*?</inertial>"), "");
  ASSERT_LT(without.size(), whole.size());
  const test::Outcome thin = diagnosed_with(without);
  EXPECT_LE(thin.code, 1) << thin.err;
  EXPECT_NE(thin.out.find("The URDF gives the links no mass"), std::string::npos) << thin.out;
}

}  // namespace
}  // namespace ballbar
