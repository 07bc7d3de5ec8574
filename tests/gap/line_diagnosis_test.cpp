// What was left out of the model, found from circles and lines together and from lines alone, of an arm that
// shares no code with lib/.

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "gap/diagnose.hpp"
#include "gap/measured_arm.hpp"

namespace ballbar {
namespace {

using test::ArmAngles;
using test::MeasuredArm;

constexpr double kPlantedRipple = 60e-6;  // [rad], 12 seconds of arc: of a middling gear

/// Sine of the motor's angle, so many cycles a turn of the joint.
test::JointErrors rippled(int joint, double cycles) {
  return [=](const ArmAngles& motor, const ArmAngles&) -> ArmAngles {
    return kPlantedRipple * std::sin(cycles * motor[joint - 1] + 0.7) * ArmAngles::Unit(joint - 1);
  };
}

/// A gap that is crossed whenever the motor turns back: the link stays behind by half of it.
test::JointErrors slack(int joint, double width) {
  return [=](const ArmAngles&, const ArmAngles& came) -> ArmAngles {
    return -0.5 * width * came[joint - 1] * ArmAngles::Unit(joint - 1);
  };
}

struct LineCell {
  std::vector<TestSpec> tests;
  MeasuredArm arm;

  Diagnosis diagnosed(const std::vector<std::string>& hold_out = {}) {
    RobotSpec spec = test::paper_robot(tests, {});
    spec.gear_ratio = {120, 121, 100, 80, 80, 50};
    std::vector<MeasuredRun> runs;
    for (const TestSpec& each : tests) arm.drive(each, runs);
    const GapModel model{AsBuilt(test::lrmate(), spec), spec};
    const Observations seen = observe(std::move(runs), spec, model.model());
    EXPECT_EQ(seen.left_aside, std::vector<std::string>{});
    std::vector<Observation> fitted, held;
    for (const Observation& one : seen.all)
      (std::find(hold_out.begin(), hold_out.end(), one.test) == hold_out.end() ? fitted : held)
          .push_back(one);
    const NoiseLevel noise = assign_noise(fitted);
    assign_noise(held);
    return diagnose(model, fitted, held, noise);
  }
};

/// "transmission_error 3", without zero offsets.
std::set<std::string> named_by(const Diagnosis& diagnosis) {
  std::set<std::string> names;
  for (const LeftOut& one : diagnosis.left_out)
    if (one.spec.effect != "joint_zero_offset")
      names.insert(one.spec.effect + " " + std::to_string(one.spec.joint));
  return names;
}

double nuisance_of(const Diagnosis& diagnosis, const std::string& name) {
  for (const Nuisance& one : diagnosis.nuisance)
    if (one.name == name) return one.value;
  ADD_FAILURE() << "no " << name;
  return 0.0;
}

const TestSpec kRight = test::paper_circle("A"), kLeft = test::paper_circle("B");

TEST(LineDiagnosis, CirclesAndALineNameOneEffectTogetherAndProveItOnALineThatWasNotFitted) {
  LineCell cell{{kRight, kLeft, test::line_at("Y", -0.251), test::line_at("high", -0.051)}, {}};
  cell.arm.errors = rippled(3, 200.0);
  const Diagnosis found = cell.diagnosed({"high"});
  EXPECT_EQ(found.verdict, Verdict::kExplained);
  EXPECT_EQ(named_by(found), std::set<std::string>{"transmission_error 3"});
  EXPECT_TRUE(found.circles && found.lines);
  EXPECT_EQ(found.held_out.runs, (std::vector<std::string>{"high+1#1", "high+1#2", "high-1#1", "high-1#2"}));
  EXPECT_GT(found.held_out.before, 5e-6);
  EXPECT_LT(found.held_out.after, 1.5 * found.held_out.floor);
  for (const LeftOut& one : found.left_out)
    if (one.spec.effect == "transmission_error") {
      EXPECT_NEAR(one.spec.parameters.at("amplitude_deg") * test::kDeg, kPlantedRipple,
                  0.05 * kPlantedRipple);
    }
}

// The tool stands as high as the shoulder: J2 moves it straight up and down, to which a bar in the plane of
// the circle is blind in the first order.
TEST(LineDiagnosis, AnEffectToWhichTheCirclesAreBlindIsNamedFromALine) {
  const std::vector<TestSpec> circles{test::circle_at("P", {0.42, -0.15, 0.0}),
                                      test::circle_at("Q", {0.42, 0.15, 0.0})};
  LineCell blind{circles, {}}, seeing{circles, {}};
  seeing.tests.push_back(test::line_at("Y", 0.0));
  blind.arm.errors = seeing.arm.errors = rippled(2, 242.0);
  EXPECT_EQ(named_by(blind.diagnosed()), std::set<std::string>{});
  const Diagnosis found = seeing.diagnosed();
  EXPECT_EQ(named_by(found), std::set<std::string>{"transmission_error 2"});
  ASSERT_EQ(found.located.size(), 1u);
  EXPECT_EQ(found.located.front().kind, TestKind::kLine);
  EXPECT_EQ(found.located.front().axis, 'Z');
  EXPECT_NE(found.located.front().says.find(" mm"), std::string::npos) << found.located.front().says;
}

TEST(LineDiagnosis, HowTheOpticsWereAlignedChangesNothingThatIsNamed) {
  LineCell plain{{kRight, kLeft, test::line_at("Y", -0.251)}, {}};
  plain.arm.errors = slack(1, 50e-6);
  plain.arm.noise = 1e-6;
  LineCell askew = plain;
  askew.arm.offset = 0.7e-3;
  askew.arm.slope = 1.5e-3;
  const Diagnosis a = plain.diagnosed(), b = askew.diagnosed();
  EXPECT_EQ(named_by(a), std::set<std::string>{"joint_lost_motion 1"});
  EXPECT_EQ(named_by(a), named_by(b));
  EXPECT_NEAR(a.fit.after, b.fit.after, 1e-9);
  for (const LeftOut& one : a.left_out)
    for (const LeftOut& other : b.left_out)
      if (one.spec.effect == other.spec.effect && one.spec.joint == other.spec.joint) {
        EXPECT_NEAR(one.size, other.size, 1e-8) << one.spec.effect;
      }
  // J1's zero turns a line as its optics do, and takes a five-hundredth.
  EXPECT_NEAR(nuisance_of(b, "set_up3_slope_urad") - nuisance_of(a, "set_up3_slope_urad"), 1500.0, 5.0);
  EXPECT_NEAR(nuisance_of(b, "set_up3_offset_um") - nuisance_of(a, "set_up3_offset_um"), 700.0 + 0.4 * 1500.0,
              0.5);
}

TEST(LineDiagnosis, LinesAloneNameWhatTheyShowAndWarnOfWhatTheyDoNotCarry) {
  LineCell cell{{test::line_at("Y", -0.251), test::line_at("high", -0.051)}, {}};
  cell.arm.errors = rippled(3, 200.0);
  const Diagnosis found = cell.diagnosed();
  EXPECT_EQ(named_by(found), std::set<std::string>{"transmission_error 3"});
  EXPECT_TRUE(std::any_of(found.warnings.begin(), found.warnings.end(),
                          [](const std::string& warning) { return warning.starts_with("Only lines"); }));
}

TEST(LineDiagnosis, ALineThatIsReadWhileItIsDrivenDoesAsWell) {
  LineCell cell{{kRight, kLeft, test::line_at("Y", -0.251)}, {}};
  cell.arm.errors = rippled(3, 200.0);
  cell.arm.stops = false;
  const Diagnosis found = cell.diagnosed();
  EXPECT_EQ(named_by(found), std::set<std::string>{"transmission_error 3"});
  EXPECT_LT(found.fit.after, 1.3 * found.noise_floor);
}

TEST(LineDiagnosis, OfASoundArmNothingIsNamed) {
  LineCell cell{{kRight, kLeft, test::line_at("Y", -0.251)}, {}};
  const Diagnosis found = cell.diagnosed();
  EXPECT_EQ(found.verdict, Verdict::kNothingMissing);
  EXPECT_EQ(named_by(found), std::set<std::string>{});
  EXPECT_LT(found.fit.after, 1.2 * found.noise_floor);
}

}  // namespace
}  // namespace ballbar
