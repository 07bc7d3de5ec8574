// Recordings that are not what they are said to be, or too few: the diagnosis says so.

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>

#include "gap/diagnose.hpp"
#include "gap/paper_robot.hpp"
#include "gap/proposed_tests.hpp"
#include "support/observed.hpp"
#include "support/process.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

constexpr std::uint64_t kSeed = 5;

/// Four circles of the plan in docs/diagnose.md: flat, tilted, and two with 3 kg.
RobotSpec planned_robot() {
  RobotSpec robot = test::paper_robot({test::paper_circle("A")}, {});
  robot.payload = 0.438;
  robot.payload_com = {0, 0, 0.05};
  const GapModel model(AsBuilt(test::lrmate(), robot), robot);
  for (const char* differs :
       {"plane and tool tilted by -30 deg about Y about", "tool tilted by 30 deg about Y, 3 kg",
        "plane and tool tilted by 30 deg about X, 3 kg"})
    for (const ProposedTest& one : proposed_tests(model, 3.0))
      if (one.differs.starts_with(differs)) robot.tests.push_back(one.test);
  if (robot.tests.size() != 4) throw std::runtime_error("the plan's circles are not among those proposed");
  return robot;
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
  options.seed = kSeed;
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

TEST(WrongInput, SingleLapsAreSaidToKnowLittleOfTheirNoise) {
  const Diagnosis single = diagnosis_of(planned_robot(), test::lrmate(), {}, 1);
  EXPECT_FALSE(single.noise_from_repeats);
  EXPECT_TRUE(says(single, "No circle was repeated"));
}

}  // namespace
}  // namespace ballbar
