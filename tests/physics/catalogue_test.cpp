// The catalogue: what is refused and how it is said, and what must hold for every effect in it.

#include "physics/catalogue.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <iterator>
#include <random>
#include <set>
#include <sstream>

#include "core/error.hpp"
#include "physics/physics_test.hpp"

namespace ballbar {
namespace {

using test::effect;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(EffectCatalogue, RefusesWithWhatIsWrongAndWhatToDo) {
  struct Row {
    EffectSpec spec;
    std::string key, says;
  };
  const std::map<std::string, std::string> backlash{{"kind", "backlash"}};
  const std::vector<Row> rows{
      {effect("joint_zero_ofset", 3, {{"offset_deg", 1}}), "effect",
       "unknown effect 'joint_zero_ofset'; did you mean 'joint_zero_offset'?"},
      {effect("gremlins", 0, {}), "effect",
       "unknown effect 'gremlins'; known are: joint_zero_offset, link_geometry"},
      {effect("", 0, {}), "effect", "known are: "},
      {effect("not_in_catalogue", 2, {}, {{"driver", "angle"}}), "effect",
       "nothing can be predicted from it"},
      {effect("joint_zero_offset", 0, {{"offset_deg", 1}}), "joint",
       "'joint_zero_offset' needs 'joint', counted from 1 at the base"},
      {effect("joint_zero_offset", 7, {{"offset_deg", 1}}), "joint",
       "'joint' = 7, but the robot's joints are 1 to 6"},
      {effect("joint_zero_offset", -1, {{"offset_deg", 1}}), "joint", "'joint' = -1"},
      {effect("tool_offset", 2, {{"x_mm", 1}}), "joint", "belongs to no joint; leave 'joint' out"},
      {effect("thermal_growth", 6, {{"strain_ppm", 1}, {"time_constant_min", 30}}), "joint",
       "moves the tool only; 'thermal_growth' takes 1 to 5, or 0 for all links"},
      {effect("joint_zero_offset", 3, {{"offset_rad", 1}}), "offset_rad",
       "has no parameter 'offset_rad'; did you mean 'offset_deg'?"},
      {effect("joint_zero_offset", 3, {{"size", 1}}), "size", "known are: offset_deg"},
      {effect("joint_zero_offset", 3, {}), "", "'joint_zero_offset' needs 'offset_deg'"},
      {effect("joint_zero_offset", 3, {{"offset_deg", kNan}}), "offset_deg",
       "'offset_deg' = nan is outside -360 .. 360"},
      {effect("joint_zero_offset", 3, {}, {{"offset_deg", "0.1"}}), "offset_deg",
       "'offset_deg' must be a number"},
      {effect("link_geometry", 3, {}), "", "needs at least one of: a_mm, d_mm, alpha_deg, beta_deg"},
      {effect("joint_compliance", 2, {{"compliance_rad_per_nm", -1e-5}}), "compliance_rad_per_nm",
       "outside 0 .. 1"},
      {effect("joint_lost_motion", 2, {{"width_deg", 0.01}}), "",
       "needs 'kind': backlash, friction_windup, load_friction, unresolved"},
      {effect("joint_lost_motion", 2, {{"width_deg", 0.01}}, {{"kind", "backlsh"}}), "kind",
       "'kind' cannot be \"backlsh\"; did you mean 'backlash'?"},
      {effect("joint_lost_motion", 2, {{"width_deg", 0.01}}, {{"kind", "magic"}}), "kind",
       "known are: backlash, "},
      {effect("joint_lost_motion", 2, {{"width_deg", 0.01}, {"kind", 1}}), "kind",
       "'kind' is a word: backlash"},
      {effect("joint_lost_motion", 2, {{"friction_nm", 1}}, backlash), "", "needs 'width_deg'"},
      {effect("joint_lost_motion", 2, {{"width_deg", 0.01}}, {{"kind", "backlash"}, {"colour", "red"}}),
       "colour", "has no parameter 'colour'; known are: width_deg, friction_nm, kind"},
      {effect("joint_readback_lag", 0, {}), "", "needs exactly one of: lag_ms, fraction_of_move"},
      {effect("joint_readback_lag", 0, {{"lag_ms", 1}, {"fraction_of_move", 0.1}}), "",
       "needs exactly one of: lag_ms, fraction_of_move"},
      {effect("gauge_jump", 0, {{"jump_um", 1}}), "", "needs exactly one of: time_us, row"},
      {effect("structural_vibration", 0, {{"frequency_hz", 0}, {"amplitude_um", 1}}), "frequency_hz",
       "is outside"},
  };
  for (const Row& row : rows) {
    SCOPED_TRACE(row.spec.effect + ": " + row.says);
    const std::optional<EffectFault> fault = effect_fault(row.spec, 6);
    ASSERT_TRUE(fault);
    EXPECT_EQ(fault->key, row.key);
    EXPECT_NE(fault->what.find(row.says), std::string::npos) << fault->what;
    EXPECT_EQ(fault->what.find('\n'), std::string::npos);
    try {
      test::lrmate_with({row.spec});
      ADD_FAILURE() << "taken";
    } catch (const Error& error) {
      EXPECT_EQ(error.cause(), Cause::kInput);
      EXPECT_TRUE(std::string(error.what()).starts_with("robot 'r': effect '" + row.spec.effect))
          << error.what();
    }
  }
}

TEST(EffectCatalogue, AnEffectThatNeedsThePayloadNeedsAPlaceForIt) {
  const std::string urdf = R"(<robot name="bare"><link name="base"/><link name="tcp"/>
    <joint name="j1" type="continuous"><parent link="base"/><child link="tcp"/><axis xyz="0 0 1"/></joint></robot>)";
  const RobotModel model(urdf, "base", "tcp", JointConvention::kSerial);
  EXPECT_NO_THROW(AsBuilt(model, test::with_effects({effect("servo_lag", 1, {{"lag_ms", 2}})})));
  EXPECT_THROW(
      AsBuilt(model, test::with_effects({effect("joint_compliance", 1, {{"compliance_rad_per_nm", 1e-5}})})),
      Error);
}

/// All that a robot does with a motion, in one column.
Eigen::VectorXd outcome(const AsBuilt& robot) {
  const Motion motion = test::swing(300, 50);
  const Conditions conditions{.payload = 2.0, .series_time = 900.0, .start_us = 1'773'219'600'000'000};
  const Motion motor = robot.follow(motion, conditions);
  const Eigen::MatrixXd readback = robot.readback(motor, conditions);
  const Eigen::Matrix3Xd points = robot.tool_points(motor, conditions);
  const Eigen::Matrix3Xd ball = robot.ball_displacement(motion.time, conditions);
  const Eigen::VectorXd gauge = robot.gauge_offset(motion.time, conditions);
  Eigen::VectorXd all(readback.size() + points.size() + ball.size() + gauge.size());
  all << readback.reshaped(), points.reshaped(), ball.reshaped(), gauge;
  return all;
}

/// Each effect with each word and each alternative of its parameters, sizes times a factor.
std::vector<EffectSpec> every_effect(double factor) {
  const std::set<std::string_view> shape{"cycles_per_turn", "phase_deg", "time_constant_min", "frequency_hz",
                                         "friction_nm"};
  std::vector<EffectSpec> all;
  for (const EffectKind& kind : effect_catalogue()) {
    if (!kind.forward) continue;
    EffectSpec spec = effect(std::string(kind.name), kind.joint == JointUse::kNone ? 0 : 2, {});
    for (const ParameterKind& p : kind.parameters) {
      if (p.need == Need::kOneOf || p.name.starts_with("centre_")) continue;  // which ball, of any size
      const std::string name(p.name);
      spec.parameters[name] = name == "time_us"      ? 1'773'219'601'000'000.0
                              : shape.contains(name) ? p.typical
                                                     : factor * p.typical;
    }
    std::vector<EffectSpec> variants;
    for (const ParameterKind& p : kind.parameters) {
      if (p.need != Need::kOneOf) continue;
      variants.push_back(spec);
      const std::string name(p.name);
      variants.back().parameters[name] = name == "time_us" ? 1'773'219'601'000'000.0
                                         : name == "row"   ? 100.0
                                                           : factor * p.typical;
    }
    if (variants.empty()) variants.push_back(spec);
    for (const EffectSpec& variant : variants) {
      if (kind.word.name.empty()) all.push_back(variant);
      for (const std::string_view word : kind.word.allowed) {
        all.push_back(variant);
        all.back().words[std::string(kind.word.name)] = word;
      }
    }
  }
  return all;
}

TEST(EffectCatalogue, EveryEffectDoesSomethingAndNothingAtSizeZero) {
  const Eigen::VectorXd nominal = outcome(test::lrmate_with({}));
  const std::vector<EffectSpec> typical = every_effect(1.0), zero = every_effect(0.0);
  ASSERT_GE(typical.size(), 20u);
  for (std::size_t i = 0; i < typical.size(); ++i) {
    SCOPED_TRACE(typical[i].effect + " " + std::to_string(i));
    EXPECT_GT((outcome(test::lrmate_with({typical[i]})) - nominal).cwiseAbs().maxCoeff(), 1e-7);
    EXPECT_LT((outcome(test::lrmate_with({zero[i]})) - nominal).cwiseAbs().maxCoeff(), 1e-15);
  }
}

TEST(EffectCatalogue, TheOrderInTheFileDoesNotMatterToTheLastBit) {
  std::vector<EffectSpec> effects = every_effect(1.0);
  const Eigen::VectorXd first = outcome(test::lrmate_with(effects));
  std::mt19937_64 random(17);
  SCOPED_TRACE("random 17");
  for (int i = 0; i < 5; ++i) {
    std::shuffle(effects.begin(), effects.end(), random);
    EXPECT_EQ(outcome(test::lrmate_with(effects)), first);
  }
}

TEST(EffectCatalogue, TwoOfAKindAddUp) {
  const auto sag = [](double c) { return effect("joint_compliance", 2, {{"compliance_rad_per_nm", c}}); };
  const Eigen::VectorXd two = outcome(test::lrmate_with({sag(1e-5), sag(2e-5)}));
  EXPECT_LT((two - outcome(test::lrmate_with({sag(3e-5)}))).cwiseAbs().maxCoeff(), 1e-14);
}

TEST(EffectCatalogue, NamesAreUniqueAndCarryTheirUnits) {
  const std::set<std::string> units{"_deg", "_mm", "_um", "_us", "_ms", "_nm", "_hz", "_min", "_ppm"};
  const std::set<std::string_view> bare{"cycles_per_turn", "fraction_of_move", "row"};
  std::set<std::string_view> names;
  for (const EffectKind& kind : effect_catalogue()) {
    EXPECT_TRUE(names.insert(kind.name).second) << kind.name;
    EXPECT_EQ(find_effect_kind(kind.name), &kind);
    EXPECT_FALSE(kind.meaning.empty() || kind.source.empty()) << kind.name;
    for (const ParameterKind& p : kind.parameters) {
      const bool unit =
          std::any_of(units.begin(), units.end(), [&](const auto& u) { return p.name.ends_with(u); });
      EXPECT_TRUE(unit || bare.contains(p.name)) << p.name;
      EXPECT_FALSE(p.meaning.empty()) << p.name;
      EXPECT_TRUE(p.name == "row" || p.name == "time_us" || (p.typical >= p.least && p.typical <= p.most))
          << p.name;
    }
  }
}

}  // namespace
}  // namespace ballbar
