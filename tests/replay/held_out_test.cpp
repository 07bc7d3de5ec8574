// The proof on circles that were not fitted: what is expected to be missed there, and an explanation that
// does not hold there. Truth: what was planted, and the scatter over many recordings.

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "core/units.hpp"
#include "gap/diagnose.hpp"
#include "gap/planned_robot.hpp"
#include "support/observed.hpp"

namespace ballbar {
namespace {

constexpr std::uint64_t kFirstSeed = 21;
constexpr std::uint64_t kManySeeds = 12;

const std::string kTilted = "plane and tool tilted by -30 deg about Y about",
                  kOther = "plane and tool tilted by 30 deg about X about",
                  kProof = "tool tilted by 30 deg about Y";

EffectSpec play_of_j2(double width_deg) {
  return {"joint_lost_motion", 2, {{"width_deg", width_deg}}, {{"kind", "friction_windup"}}};
}

/// Of all circles but the last one, which is the proof.
/// @param later  effects while that was driven
Diagnosis diagnosis_of(const RobotSpec& robot, const std::vector<EffectSpec>& effects,
                       const std::vector<EffectSpec>& later, std::uint64_t seed) {
  const RobotModel arm = test::lrmate();
  SimulateOptions options;
  options.repetitions = 2;
  options.noise = 2e-6;
  options.seed = seed;
  const std::string proof = robot.tests.back().name;
  std::vector<Observation> all;
  const auto drive = [&](const std::vector<EffectSpec>& now, bool last_one) {
    for (Observation& seen : test::observed(robot, arm, now, options))
      if ((seen.test == proof) == last_one) all.push_back(std::move(seen));
  };
  drive(effects, false);
  drive(later, true);
  const NoiseLevel noise = assign_noise(all);
  std::vector<Observation> fitted, held;
  for (Observation& seen : all) (seen.test == proof ? held : fitted).push_back(std::move(seen));
  return diagnose(GapModel(AsBuilt(arm, robot), robot), fitted, held, noise);
}

TEST(HeldOut, IsMissedByAsMuchAsTheStandardDeviationsOfTheFitSay) {
  // One flat circle leaves the zeros of J2 to J6 nearly open; what it leaves open shows on a tilted one.
  SCOPED_TRACE("seeds from " + std::to_string(kFirstSeed));
  const RobotSpec robot = test::planned_robot({kTilted});
  double missed = 0.0, expected = 0.0, floor = 0.0;
  for (std::uint64_t seed = kFirstSeed; seed < kFirstSeed + kManySeeds; ++seed) {
    std::mt19937_64 random(seed);
    std::normal_distribution<double> zero_deg(0.0, GapPriors{}.zero / kRadPerDeg);
    std::vector<EffectSpec> zeros;
    for (int joint = 2; joint <= 6; ++joint) zeros.push_back(test::zero_offset(joint, zero_deg(random)));
    const FitFigures held = diagnosis_of(robot, zeros, zeros, seed).held_out;
    missed += held.after * held.after;
    expected += held.expected * held.expected;
    floor += held.floor * held.floor;
  }
  EXPECT_GT(expected, 100.0 * floor) << "there is something to be uncertain of";
  EXPECT_NEAR(std::sqrt(missed / expected), 1.0, 0.3);
}

TEST(HeldOut, AnExplanationThatMissesOtherCirclesIsNotWhole) {
  const Diagnosis grown = diagnosis_of(test::planned_robot({kTilted, kOther, kProof}), {play_of_j2(0.007)},
                                       {play_of_j2(0.014)}, kFirstSeed);
  EXPECT_FALSE(grown.holds_elsewhere);
  EXPECT_EQ(grown.remainder.structure, "none") << "where it was fitted, all is explained";
  EXPECT_EQ(grown.verdict, Verdict::kPartlyExplained) << to_string(grown.verdict);
}

TEST(HeldOut, WhatIsMissingThereAloneIsAnUnknownEffect) {
  const Diagnosis fresh =
      diagnosis_of(test::planned_robot({kTilted, kOther, kProof}), {}, {play_of_j2(0.014)}, kFirstSeed);
  EXPECT_FALSE(fresh.holds_elsewhere);
  EXPECT_TRUE(fresh.left_out.empty());
  EXPECT_EQ(fresh.verdict, Verdict::kUnknownEffect) << to_string(fresh.verdict);
}

}  // namespace
}  // namespace ballbar
