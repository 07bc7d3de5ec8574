/// Effects concealed in made poses are found again, with the right joint and size; poses without any give
/// none.

#include <gtest/gtest.h>

#include "gap/pose_diagnosis.hpp"
#include "gap/poses_arm.hpp"

namespace ballbar {
namespace {

using test::Angles;
using test::kRad;
using test::MadeError;
using test::MadeSet;

PoseDiagnosis diagnosed(const MadeError& error, const MadeSet& made) {
  const RobotSpec spec;
  const AsBuilt robot(test::arm_model(), spec);
  return diagnose_poses(prepare_poses(test::make_poses(error, made), robot, spec), robot.chain(), {});
}

const PoseFinding* find(const PoseDiagnosis& diagnosis, PoseEffect effect, int joint) {
  for (const PoseFinding& finding : diagnosis.left_out)
    if (finding.term.effect == effect && finding.term.joint == joint) return &finding;
  return nullptr;
}

std::string names(const PoseDiagnosis& diagnosis) {
  std::string all;
  for (const PoseFinding& f : diagnosis.left_out)
    all += "effect " + std::to_string(static_cast<int>(f.term.effect)) + " joint " +
           std::to_string(f.term.joint) + " at " + std::to_string(f.term.setting) + " evidence " +
           std::to_string(f.evidence) + "\n";
  return all;
}

/// One finding and nothing else; 0 where it is not so.
const PoseFinding* only(const PoseDiagnosis& diagnosis, PoseEffect effect, int joint) {
  EXPECT_EQ(diagnosis.left_out.size(), 1U) << names(diagnosis);
  const PoseFinding* finding = find(diagnosis, effect, joint);
  EXPECT_NE(finding, nullptr) << names(diagnosis);
  return finding;
}

/// A value is as planted to three standard deviations, and known well enough for that to say something.
void expect_value(const PoseFinding* finding, double planted, std::size_t which = 0) {
  ASSERT_NE(finding, nullptr);
  EXPECT_NEAR(finding->values[which], planted, 4.0 * finding->sd[which] + 0.002 * std::abs(planted));
  EXPECT_LT(finding->sd[which], 0.15 * std::abs(planted));
}

TEST(PosesTest, NothingIsMissingWhereNothingIs) {
  for (const unsigned seed : {11U, 12U, 13U, 14U}) {
    SCOPED_TRACE(seed);
    MadeSet made;
    made.seed = seed;
    const PoseDiagnosis diagnosis = diagnosed({}, made);
    EXPECT_EQ(diagnosis.verdict, PoseVerdict::kNothingMissing) << names(diagnosis);
    EXPECT_NEAR(diagnosis.after, 20e-6 * std::sqrt(3.0), 2e-6);
  }
}

TEST(PosesTest, AZeroOffsetIsNamedAndTheUnseenPosesArePredictedToTheNoise) {
  MadeError error;
  error.arm.zero[2] = 0.1 * kRad;
  MadeSet made;
  made.hold_out = false;
  const PoseDiagnosis diagnosis = diagnosed(error, made);
  expect_value(only(diagnosis, PoseEffect::kZeroOffset, 3), 0.1 * kRad);
  EXPECT_EQ(diagnosis.verdict, PoseVerdict::kExplained);
  ASSERT_EQ(diagnosis.held_out.size(), 2U) << "blocks and at random";
  for (const PoseProof& proof : diagnosis.held_out) {
    SCOPED_TRACE(proof.how);
    EXPECT_GT(proof.before().held_out, 300e-6);
    EXPECT_LT(proof.after().held_out, 40e-6);
  }
}

TEST(PosesTest, ALengthIsNamed) {
  MadeError error;
  error.arm.a2 += 0.4e-3;
  const PoseDiagnosis diagnosis = diagnosed(error, {});
  expect_value(only(diagnosis, PoseEffect::kLinkA, 3), 0.4e-3);
}

TEST(PosesTest, ARippleIsFoundAtWhateverRateItHas) {
  for (const double cycles : {17.37, 4.6, 163.2}) {
    SCOPED_TRACE(cycles);
    MadeError error;
    error.angle = [cycles](std::size_t joint, const Angles& q, const Angles&) {
      return joint == 1 ? 1.2e-4 * std::sin(cycles * q[1] + 0.7) : 0.0;
    };
    const PoseDiagnosis diagnosis = diagnosed(error, {});
    const PoseFinding* ripple = only(diagnosis, PoseEffect::kRipple, 2);
    ASSERT_NE(ripple, nullptr);
    EXPECT_NEAR(ripple->term.setting, cycles, 0.05);
    EXPECT_NEAR(std::hypot(ripple->values[0], ripple->values[1]), 1.2e-4, 0.1e-4);
  }
}

TEST(PosesTest, SeveralLinesAtOneJointAreToldApart) {
  MadeError error;
  error.angle = [](std::size_t joint, const Angles& q, const Angles&) {
    return joint != 2 ? 0.0 : 1.5e-4 * std::sin(9.3 * q[2]) + 0.9e-4 * std::cos(31.8 * q[2]);
  };
  const PoseDiagnosis diagnosis = diagnosed(error, {});
  ASSERT_EQ(diagnosis.left_out.size(), 2U) << names(diagnosis);
  EXPECT_NEAR(diagnosis.left_out[0].term.setting, 9.3, 0.05);
  EXPECT_NEAR(diagnosis.left_out[1].term.setting, 31.8, 0.2);  // 27 um of ripple under 20 um of noise
}

TEST(PosesTest, AnArmThatBendsUnderGravityHasACompliance) {
  MadeError error;
  const test::Arm arm;
  error.angle = [arm](std::size_t joint, const Angles& q, const Angles&) {
    return joint == 1 ? -1.2e-5 * arm.torque(q, 1) : 0.0;
  };
  const PoseDiagnosis diagnosis = diagnosed(error, {});
  expect_value(only(diagnosis, PoseEffect::kCompliance, 2), 1.2e-5);
}

TEST(PosesTest, AReadingThatLacksAPartOfTheMoveIsNotTakenForGeometry) {
  MadeError error;
  error.arm.zero[1] = 0.05 * kRad;
  error.reading = [](double angle, double before, std::size_t) { return angle - 5e-4 * (angle - before); };
  const PoseDiagnosis diagnosis = diagnosed(error, {});
  EXPECT_EQ(diagnosis.left_out.size(), 2U) << names(diagnosis);
  expect_value(find(diagnosis, PoseEffect::kReadbackMove, 0), 5e-4);
  expect_value(find(diagnosis, PoseEffect::kZeroOffset, 2), 0.05 * kRad);
}

TEST(PosesTest, ARoundedReadingIsSeenAgainstTheCommand) {
  MadeError error;
  error.commands = true;
  error.reading = [](double angle, double, std::size_t) {
    return std::round(angle / kRad / 0.05) * 0.05 * kRad;
  };
  const PoseDiagnosis diagnosis = diagnosed(error, {});
  expect_value(only(diagnosis, PoseEffect::kReadbackCommand, 0), 1.0);
  EXPECT_NEAR(diagnosis.reading_step, 0.05 * kRad, 1e-9);
  EXPECT_FALSE(diagnosis.command_follows_move);
}

TEST(PosesTest, AnInstrumentThatJumpsIsNotARobotThatIsWrong) {
  MadeError error;
  error.displacement = [](int row, double) {
    return row >= 151 ? Eigen::Vector3d(0, 0, 80e-6) : Eigen::Vector3d(0, 0, 0);
  };
  const PoseDiagnosis diagnosis = diagnosed(error, {});
  const PoseFinding* jump = only(diagnosis, PoseEffect::kJump, 0);
  ASSERT_NE(jump, nullptr);
  EXPECT_NEAR(jump->term.setting, 151, 2);
  expect_value(jump, 80e-6, 2);
}

TEST(PosesTest, ADriftIsNamedWithItsRate) {
  MadeError error;
  error.displacement = [](int, double seconds) { return Eigen::Vector3d(150e-6 * seconds / 3600.0, 0, 0); };
  const PoseDiagnosis diagnosis = diagnosed(error, {});
  expect_value(only(diagnosis, PoseEffect::kDrift, 0), 150e-6 / 3600.0);
}

TEST(PosesTest, LostMotionIsSeenFromBothSides) {
  MadeSet made;
  made.both_sides = true;
  made.poses = 150;
  const PoseDiagnosis diagnosis = diagnosed({}, made);
  expect_value(only(diagnosis, PoseEffect::kLostMotion, 2), 2.5e-4);
}

TEST(PosesTest, LengthsToOneFixedPointAreEnough) {
  MadeError error;
  error.arm.zero[2] = 0.1 * kRad;
  error.angle = [](std::size_t joint, const Angles& q, const Angles&) {
    return joint == 1 ? 2.5e-4 * std::sin(12.6 * q[1]) : 0.0;
  };
  MadeSet made;
  made.lengths = true;
  made.poses = 400;
  const PoseDiagnosis diagnosis = diagnosed(error, made);
  const PoseFinding* ripple = find(diagnosis, PoseEffect::kRipple, 2);
  ASSERT_NE(ripple, nullptr) << names(diagnosis);
  EXPECT_NEAR(ripple->term.setting, 12.6, 0.05);
  EXPECT_NE(find(diagnosis, PoseEffect::kZeroOffset, 3), nullptr) << names(diagnosis);
  EXPECT_LT(diagnosis.after, 22e-6);
}

TEST(PosesTest, AnErrorOutsideTheCatalogueIsNotGivenItsNames) {
  MadeError error;  // one bump: no line, no offset
  error.angle = [](std::size_t joint, const Angles& q, const Angles&) {
    return joint == 1 ? 4e-4 * std::exp(-0.5 * std::pow((q[1] - 0.4) / 0.12, 2)) : 0.0;
  };
  MadeSet made;
  made.poses = 500;
  const PoseDiagnosis diagnosis = diagnosed(error, made);
  for (const PoseFinding& finding : diagnosis.left_out)
    if (finding.share > 0.1) {
      EXPECT_EQ(finding.term.joint, 2) << names(diagnosis);
    }
  for (const PoseProof& proof : diagnosis.held_out)
    EXPECT_LT(proof.after().held_out, 0.5 * proof.before().held_out);
}

TEST(PosesTest, ReadingsThatWanderInTimeAreAnUnknownEffect) {
  MadeError error;
  error.displacement = [](int row, double) { return Eigen::Vector3d(0, 120e-6 * std::sin(0.08 * row), 0); };
  const PoseDiagnosis diagnosis = diagnosed(error, {});
  ASSERT_FALSE(diagnosis.left_out.empty());
  EXPECT_EQ(diagnosis.left_out.front().term.effect, PoseEffect::kTimeCurve) << names(diagnosis);
  EXPECT_EQ(diagnosis.verdict, PoseVerdict::kUnknownEffect) << names(diagnosis);
}

TEST(PosesTest, ReadingsThatAreOldInMotionAreNamedWithTheirAge) {
  MadeSet made;
  made.poses = 1000;
  PoseSet set = test::make_poses({}, made);
  const test::Arm arm;
  for (std::size_t i = 0; i < set.poses.size(); ++i) {
    const double now = 0.02 * static_cast<double>(i);
    const auto angle = [](std::size_t j, double time) {
      return 0.5 * std::sin((1.1 + 0.37 * static_cast<double>(j)) * time + static_cast<double>(j));
    };
    Angles truth{};
    for (std::size_t j = 0; j < 6; ++j) {
      truth[j] = angle(j, now);
      set.poses[i].joints[j] = angle(j, j == 1 ? now - 0.004 : now);
    }
    const Eigen::Vector3d point = arm.flange(truth) * Eigen::Vector3d(0.13, 0.04, 0.06);
    std::mt19937 random(static_cast<unsigned>(i));
    for (std::size_t k = 0; k < 3; ++k)
      set.poses[i].point[k] = point[static_cast<Eigen::Index>(k)] + 20e-6 * test::normal(random);
    set.poses[i].time = now;
  }
  const RobotSpec spec;
  const AsBuilt robot(test::arm_model(), spec);
  const PoseDiagnosis diagnosis = diagnose_poses(prepare_poses(set, robot, spec), robot.chain(), {});
  expect_value(only(diagnosis, PoseEffect::kReadbackTime, 2), 0.004);
}

TEST(PosesTest, RepeatsGiveTheNoiseAndAreOneRow) {
  MadeSet made;
  made.poses = 60;
  made.repeats = 4;
  const RobotSpec spec;
  const AsBuilt robot(test::arm_model(), spec);
  const PoseRows rows = prepare_poses(test::make_poses({}, made), robot, spec);
  EXPECT_EQ(rows.rows.size(), 60U);
  EXPECT_EQ(rows.repeat_dof, 60 * 3 * 3);
  EXPECT_NEAR(rows.repeat_sd, 20e-6, 2e-6);
}

TEST(PosesTest, WhatIsConfiguredIsNotLeftOut) {
  MadeError error;
  error.arm.zero[2] = 0.1 * kRad;
  error.angle = [](std::size_t joint, const Angles& q, const Angles&) {
    return joint == 1 ? 1.2e-4 * std::sin(17.37 * q[1] + 0.7) : 0.0;
  };
  RobotSpec spec;
  spec.effects = {{"joint_zero_offset", 3, {{"offset_deg", 0.1}}, {}},
                  {"transmission_error",
                   2,
                   {{"cycles_per_turn", 17.37}, {"amplitude_deg", 1.2e-4 / kRad}, {"phase_deg", 0.7 / kRad}},
                   {}}};
  spec.gear_ratio = {100, 100, 100, 100, 100, 100};
  const AsBuilt robot(test::arm_model(), spec);
  const PoseDiagnosis diagnosis =
      diagnose_poses(prepare_poses(test::make_poses(error, {}), robot, spec), robot.chain(), {});
  EXPECT_EQ(diagnosis.verdict, PoseVerdict::kNothingMissing) << names(diagnosis);
}

TEST(PosesTest, AHeldOutSeriesHasASetUpOfItsOwn) {
  MadeError error;
  error.arm.zero[2] = 0.1 * kRad;
  MadeSet made;
  made.hold_out = false;
  PoseSet set = test::make_poses(error, made);
  const Eigen::Isometry3d moved =
      Eigen::Translation3d(0.4, 0.1, -0.2) * Eigen::AngleAxisd(0.3, Eigen::Vector3d::UnitZ());
  for (std::size_t i = 160; i < set.poses.size(); ++i) {
    set.poses[i].series = "later-held-out";
    const Eigen::Vector3d p =
        moved * Eigen::Vector3d(set.poses[i].point[0], set.poses[i].point[1], set.poses[i].point[2]);
    set.poses[i].point = {p.x(), p.y(), p.z()};
  }
  const RobotSpec spec;
  const AsBuilt robot(test::arm_model(), spec);
  const PoseDiagnosis diagnosis = diagnose_poses(prepare_poses(set, robot, spec), robot.chain(), {});
  ASSERT_EQ(diagnosis.held_out.size(), 1U);
  const PoseProof& proof = diagnosis.held_out.front();
  EXPECT_EQ(proof.how, "series");
  EXPECT_EQ(proof.rows, 80);
  EXPECT_GT(proof.before().held_out, 300e-6);
  EXPECT_LT(proof.after().held_out, 40e-6);
}

TEST(PosesTest, PredictionsOutsideTheFittedRangeAreCounted) {
  PoseSet set = test::make_poses({}, {});
  int outside = 0;
  for (Pose& pose : set.poses) {
    pose.held_out = pose.joints[1] > 1.0;
    outside += pose.joints[1] > 1.05 ? 1 : 0;
  }
  const RobotSpec spec;
  const AsBuilt robot(test::arm_model(), spec);
  const PoseDiagnosis diagnosis = diagnose_poses(prepare_poses(set, robot, spec), robot.chain(), {});
  const PoseCoverage& coverage = diagnosis.held_out.front().coverage;
  EXPECT_GE(coverage.outside, outside);
  ASSERT_FALSE(coverage.joints.empty());
  EXPECT_TRUE(std::any_of(coverage.joints.begin(), coverage.joints.end(),
                          [](const auto& j) { return j.joint == 2; }));
}

TEST(PosesTest, TheSamePosesGiveTheSameBits) {
  MadeError error;
  error.angle = [](std::size_t joint, const Angles& q, const Angles&) {
    return joint == 1 ? 1.2e-4 * std::sin(17.37 * q[1] + 0.7) : 0.0;
  };
  const PoseDiagnosis one = diagnosed(error, {}), other = diagnosed(error, {});
  ASSERT_EQ(one.state.values.size(), other.state.values.size());
  for (std::size_t i = 0; i < one.state.values.size(); ++i)
    EXPECT_EQ(one.state.values[i], other.state.values[i]);
  EXPECT_EQ(one.held_out.front().after().held_out, other.held_out.front().after().held_out);
}

/// Columns against differences of the forward model, for every effect.
TEST(PosesTest, ColumnsAreTheDerivativesOfThePrediction) {
  for (const bool lengths : {false, true}) {
    MadeSet made;
    made.poses = 20;
    made.both_sides = true;
    made.lengths = lengths;
    MadeError error;
    error.commands = true;
    error.reading = [](double angle, double before, std::size_t) { return angle - 1e-3 * (angle - before); };
    const RobotSpec spec;
    const AsBuilt robot(test::arm_model(), spec);
    PoseRows rows = prepare_poses(test::make_poses(error, made), robot, spec);
    for (PoseRow& row : rows.rows) row.speed = row.q;
    const PoseModel model(robot.chain(), lengths);
    PoseState state = start_poses(model, rows);
    state.tools.front() = {0.02, -0.03, 0.05};
    for (PoseTerm term : geometry_terms(robot.chain())) state.terms.push_back(term);
    for (const PoseTerm& term : effect_candidates(rows, rows.rows)) state.terms.push_back(term);
    state.terms.push_back({PoseEffect::kRipple, 2, 7.3, 1.0, 1e-4, 2});
    state.terms.push_back({PoseEffect::kReadbackTime, 0, 0.0, 0.0, 1e-3, 1});
    state.terms.push_back({PoseEffect::kGrowth, 0, 300.0, 0.0, 1e-4, 1});
    state.terms.push_back({PoseEffect::kJump, 0, 9.0, 0.0, 1e-4, lengths ? 1 : 3});
    state.terms.push_back({PoseEffect::kAngleCurve, 3, -1.0, 2.0, 1e-4, kAngleKnots});
    state.terms.push_back({PoseEffect::kTimeCurve, 0, 0.0, 0.0, 1e-4, 3 * kTimeKnots});
    for (const PoseTerm& term : state.terms)
      for (int k = 0; k < term.width; ++k) state.values.push_back(0.3 * term.typical);
    std::vector<PoseGeometry> geometry;
    const Eigen::VectorXd here = model.residual(rows.rows, state, &geometry);
    const Eigen::MatrixXd columns = pose_columns(model, rows.rows, state, geometry);
    for (Eigen::Index k = 0; k < columns.cols(); ++k) {
      const double step = 1e-3 / std::max(1.0, columns.col(k).cwiseAbs().maxCoeff()) * 0.01;
      Eigen::VectorXd up = Eigen::VectorXd::Zero(columns.cols());
      up[k] = step;
      const Eigen::VectorXd slope = (model.residual(rows.rows, model.moved(state, -up)) -
                                     model.residual(rows.rows, model.moved(state, up))) /
                                    (2.0 * step);
      const double size = std::max(1e-3, columns.col(k).norm());
      EXPECT_LT((slope - columns.col(k)).norm() / size, 2e-3)
          << "column " << k << (lengths ? " of lengths" : "");
    }
  }
}

}  // namespace
}  // namespace ballbar
