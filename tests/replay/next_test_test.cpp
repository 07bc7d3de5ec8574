// The next test: two effects that the paper's two circles confuse are simulated on the circle that was
// proposed, and there they part by as much as was promised. The truth is the nonlinear fit of noisy
// recordings.

#include "gap/next_test.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <nlohmann/json.hpp>

#include "gap/diagnose.hpp"
#include "gap/paper_robot.hpp"
#include "support/observed.hpp"
#include "support/process.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

const std::string kConfig = BALLBAR_SOURCE_DIR "/scripts/robots/lrmate200ic.toml";

constexpr std::uint64_t kSeed = 11;

RobotSpec two_circles() {
  RobotSpec robot = test::paper_robot({test::paper_circle("A"), test::paper_circle("B")}, {});
  robot.gear_ratio = {120, 121, 100, 80, 80, 50};
  robot.payload = 0.438;
  robot.payload_com = {0, 0, 0.05};
  return robot;
}

SimulateOptions noisy() {
  SimulateOptions options;
  options.repetitions = 2;
  options.noise = 2e-6;
  options.seed = kSeed;
  return options;
}

/// Of the nonlinear fit with this effect alone; the clocks are released last.
double chi2_with(const GapModel& model, const std::vector<Observation>& observations,
                 const Candidate& candidate, double size) {
  GapPriors held;
  held.shift = 0.0;
  GapFit fit;
  fit.state = model.start(observations);
  fit.named = {{candidate, size * Eigen::VectorXd::Ones(candidate.width())}};
  const GapFitter fitter(model, observations);
  return fitter.fit(fitter.fit(fit, held, false, 12), GapPriors{}, false, 12).chi2;
}

Candidate candidate_of(const GapModel& model, const std::string& label) {
  for (const Candidate& candidate : candidates_for(model, {}))
    if (candidate.label() == label) return candidate;
  throw std::runtime_error("no candidate " + label);
}

struct Confused {
  const char *a, *b;
  EffectSpec planted;  ///< a at its size
  double size;         ///< in typical sizes
};

class NextTest : public testing::TestWithParam<Confused> {};

TEST_P(NextTest, PartsTheTwoByWhatItPromises) {
  const Confused& pair = GetParam();
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  const RobotModel arm = test::lrmate();
  RobotSpec robot = two_circles();
  const GapModel model(AsBuilt(arm, robot), robot);
  std::vector<Observation> driven = test::observed(robot, arm, {pair.planted}, noisy());
  assign_noise(driven);
  const std::vector<Suspect> suspects{suspect_of(candidate_of(model, pair.a), pair.size),
                                      suspect_of(candidate_of(model, pair.b), pair.size)};
  const RobotPlan plan = plan_for_robot(model, driven, suspects, proposed_tests(model), 1);
  EXPECT_EQ(plan.apart, 0u) << "the two circles confuse them";
  ASSERT_EQ(plan.tests.size(), 1u);
  const RankedTest& best = plan.tests.front();
  ASSERT_GT(best.sure, kSure) << best.proposed.differs;

  robot.tests.push_back(best.proposed.test);
  const GapModel more(AsBuilt(arm, robot), robot);
  std::vector<Observation> with = test::observed(robot, arm, {pair.planted}, noisy());
  const NoiseLevel noise = assign_noise(with);
  const double wrong = chi2_with(more, with, candidate_of(more, pair.b), pair.size);
  const double right = chi2_with(more, with, candidate_of(more, pair.a), pair.size);
  ASSERT_GT(wrong, right);
  EXPECT_NEAR(std::sqrt(wrong - right), best.noise, 3.0 + 0.2 * best.noise) << best.proposed.differs;

  const Diagnosis diagnosis = diagnose(more, with, {}, noise);
  bool named = false;
  for (const LeftOut& one : diagnosis.left_out) {
    if (one.level == 1) continue;
    EXPECT_EQ(one.spec.effect, pair.planted.effect);
    EXPECT_EQ(one.spec.joint, pair.planted.joint);
    named = true;
    for (const Twin& twin : one.twins) EXPECT_NE(twin.label, pair.b);
  }
  EXPECT_TRUE(named);
}

std::string short_name(const testing::TestParamInfo<Confused>& info) {
  std::string name = info.param.planted.effect;
  std::erase(name, '_');
  return name;
}

INSTANTIATE_TEST_SUITE_P(Pairs, NextTest,
                         testing::Values(Confused{
                             "joint_lost_motion J2 friction_windup",
                             "joint_lost_motion J5 friction_windup",
                             {"joint_lost_motion", 2, {{"width_deg", 0.007}}, {{"kind", "friction_windup"}}},
                             1.0}),
                         short_name);

INSTANTIATE_TEST_SUITE_P(DISABLED_Long, NextTest,
                         testing::Values(Confused{
                             "joint_compliance J3",
                             "joint_compliance J2",
                             {"joint_compliance", 3, {{"compliance_rad_per_nm", 1.2e-5}}, {}},
                             0.3}),
                         short_name);

TEST(NextTests, CanAllBeDrivenAndAreReadByTheConfiguration) {
  const test::TempDir dir;
  const test::Outcome planned =
      test::run({test::kBallbar, "diagnose", "--plan", "--json", "--config", kConfig});
  ASSERT_EQ(planned.code, 0) << planned.err;
  const nlohmann::json plan = nlohmann::json::parse(planned.out);
  ASSERT_GE(plan["tests"].size(), 1u);
  EXPECT_GT(plan["told_apart_with_all"].get<int>(), plan["told_apart"].get<int>());
  std::string text = test::read_file(kConfig);
  const std::string urdf = "urdf = \"";
  text.insert(text.find(urdf) + urdf.size(), BALLBAR_SOURCE_DIR "/scripts/robots/");
  std::string names;
  for (const nlohmann::json& one : plan["tests"]) {
    text += "\n" + one["robot_test"].get<std::string>();
    names += (names.empty() ? "" : ",") + one["test"].get<std::string>();
  }
  test::write_file(dir.path() + "/more.toml", text);
  const test::Outcome driven =
      test::run({test::kBallbar, "simulate", "--config", dir.path() + "/more.toml", "--test", names});
  EXPECT_EQ(driven.code, 0) << driven.err;
}

TEST(NextTests, OfAnEffectThatIsNoneAreRefusedWithOneLine) {
  const test::Outcome outcome = test::run(
      {test::kBallbar, "diagnose", "--plan", "--effects", "servo_lag:9,servo_lag:2", "--config", kConfig});
  EXPECT_EQ(outcome.code, 2);
  EXPECT_NE(outcome.err.find("servo_lag:9"), std::string::npos) << outcome.err;
}

}  // namespace
}  // namespace ballbar
