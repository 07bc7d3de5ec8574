// Lines made ready for a diagnosis: what the readings say there, how they change with each joint, and which
// recordings are left aside with a reason.

#include <gtest/gtest.h>

#include <array>
#include <map>
#include <set>

#include "gap/candidates.hpp"
#include "gap/measured_arm.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

struct SeenLine {
  TestSpec test = test::line_at("Y", -0.251);
  RobotSpec spec = test::paper_robot({test}, {});
  GapModel model{AsBuilt(test::lrmate(), spec), spec};

  Observations of(test::MeasuredArm& arm) {
    std::vector<MeasuredRun> runs;
    arm.drive(test, runs);
    return observe(std::move(runs), spec, model.model());
  }
};

TEST(MeasuredArm, IsTheMakersRobot) {
  // Teach pendant's angles and World coordinates, metrology.md 3: J3 of the chain is J3 + J2.
  const auto place = [](std::array<double, 6> deg) {
    test::ArmAngles q;
    for (int j = 0; j < 6; ++j) q[j] = deg[static_cast<std::size_t>(j)] * test::kDeg;
    q[2] += q[1];
    return test::tool_point(q);
  };
  EXPECT_LT((place({30, 20, -10, 40, -50, 60}) - Eigen::Vector3d(0.5472167, 0.2280050, 0.1935655)).norm(),
            1e-7);
  EXPECT_LT(
      (place({-40.1, 50, -70, 0, -20, 40.1}) - Eigen::Vector3d(0.3707855, -0.3122304, -0.2368638)).norm(),
      1e-7);
  for (const double y : {-0.4, 0.1, 0.4}) {
    const Eigen::Vector3d there(0.38, y, -0.2);
    EXPECT_LT((test::tool_point(test::tool_down_at(there)) - there).norm(), 1e-12);
  }
}

TEST(LineObservation, LapsOfOneWayAndAxisAreOneAndAllOfAnAxisShareTheAlignment) {
  SeenLine line;
  test::MeasuredArm arm;
  const Observations seen = line.of(arm);
  ASSERT_EQ(seen.left_aside, std::vector<std::string>{});
  ASSERT_EQ(seen.all.size(), 4u) << "X and Z, both ways";
  std::map<char, std::set<int>> set_ups;
  for (const Observation& one : seen.all) {
    EXPECT_EQ(one.laps.cols(), 2);
    EXPECT_EQ(one.places(), 51);
    EXPECT_TRUE(one.at_rest);
    set_ups[one.instrument.axis].insert(one.set_up);
  }
  EXPECT_EQ(set_ups['X'].size(), 1u);
  EXPECT_EQ(set_ups['Z'].size(), 1u);
  EXPECT_NE(set_ups['X'], set_ups['Z']);
}

TEST(LineObservation, AFirstStopThatTheRobotDidNotDriveToIsNotUsed) {
  SeenLine line;
  test::MeasuredArm arm;
  std::vector<MeasuredRun> runs{arm.line(line.test, 1, 1)};
  ballbar::Run& run = runs.front().run;
  const std::size_t approach = 40;  // samples, until it stands
  run.joint_time.erase(run.joint_time.begin(), run.joint_time.begin() + approach);
  run.joint_position.erase(run.joint_position.begin(), run.joint_position.begin() + 6 * approach);
  const Observations seen = observe(runs, line.spec, line.model.model());
  ASSERT_EQ(seen.all.size(), 2u);
  EXPECT_EQ(seen.all[0].places(), 50);
  EXPECT_GT(seen.all[0].place[0], 0.015);
}

TEST(LineObservation, PredictsWhatTheOpticsReadAtStopsAndWhileMoving) {
  for (const bool stops : {true, false}) {
    SCOPED_TRACE(stops ? "stops" : "moves");
    SeenLine line;
    test::MeasuredArm arm;
    arm.stops = stops;
    arm.noise = 0.0;
    arm.offset = 80e-6;
    arm.slope = 120e-6;
    arm.errors = [](const test::ArmAngles&, const test::ArmAngles&) -> test::ArmAngles {
      test::ArmAngles zero;
      zero << 0.0, 0.3e-3, -0.2e-3, 0.1e-3, 0.4e-3, 0.0;
      return zero;
    };
    const Observations seen = line.of(arm);
    ASSERT_EQ(seen.all.size(), 4u) << (seen.left_aside.empty() ? "" : seen.left_aside.front());
    GapState state = line.model.start(seen.all);
    state.zero << 0.0, 0.3e-3, -0.2e-3, 0.1e-3, 0.4e-3, 0.0;
    for (Eigen::Vector3d& alignment : state.set_up)  // offset in the middle, and from there to the end
      alignment = {80e-6 + 0.4 * 120e-6, 0.4 * 120e-6, 0.0};
    for (std::size_t i = 0; i < seen.all.size(); ++i) {
      const Observation& one = seen.all[i];
      const VectorXd predicted = line.model.predict(line.model.built(state), one, i, state);
      EXPECT_GT((predicted.array() - predicted.mean()).abs().maxCoeff(), 20e-6);
      const VectorXd left = one.measured - one.transform(predicted);
      EXPECT_LT(left.norm() / std::sqrt(static_cast<double>(one.places())), 20e-9) << one.instrument.axis;
    }
  }
}

TEST(LineObservation, ChangesWithEachJointAsTheArmDoes) {
  SeenLine line;
  test::MeasuredArm arm;
  const Observations seen = line.of(arm);
  const GapState state = line.model.start(seen.all);
  constexpr double kStep = 1e-6;
  for (std::size_t i = 0; i < seen.all.size(); ++i) {
    const Observation& one = seen.all[i];
    const Tangent at = line.model.tangent(line.model.built(state), one, i, state);
    const Eigen::Vector3d across =
        one.instrument.axis == 'X' ? Eigen::Vector3d::UnitX() : Eigen::Vector3d::UnitZ();
    for (Index k = 0; k < one.places(); k += 7) {
      const test::ArmAngles q = test::tool_down_at({0.380, one.place[k] - 0.400, -0.251});
      for (int j = 0; j < 6; ++j) {
        test::ArmAngles more = q, less = q;
        more[j] += kStep;
        less[j] -= kStep;
        const double slope = across.dot(test::tool_point(more) - test::tool_point(less)) / (2.0 * kStep);
        EXPECT_NEAR(at.joint(k, j), slope, 1e-6) << one.instrument.axis << " J" << j + 1 << " stop " << k;
      }
    }
  }
}

TEST(LineObservation, ColumnsOfCandidatesAreDifferencesOfTheWholeModel) {
  for (const bool stops : {true, false}) {
    SeenLine line;
    line.spec.gear_ratio = {120, 121, 100, 80, 80, 50};
    const GapModel model{AsBuilt(test::lrmate(), line.spec), line.spec};
    test::MeasuredArm arm;
    arm.stops = stops;
    const Observations seen = line.of(arm);
    const std::vector<Candidate> candidates = candidates_for(model, seen.all);
    ASSERT_GT(candidates.size(), 40u);
    for (std::size_t i = 0; i < seen.all.size(); i += 3) {  // X forward, Z backward
      const GapState state = model.start(seen.all);
      const Tangent at = model.tangent(model.built(state), seen.all[i], i, state);
      Drive drive = at.drive();
      for (const Candidate& candidate : candidates) {
        SCOPED_TRACE(candidate.label() + (stops ? " at stops" : " on the move"));
        const MatrixXd columns = columns_of(model, at, drive, candidate, {}, Slope::kChord);
        for (Index k = 0; k < columns.cols(); ++k) {
          const double size = candidate.curved ? 1.0 : 0.02;
          GapState with = state;
          with.effects.push_back(candidate.with(size * VectorXd::Unit(columns.cols(), k)));
          const VectorXd moved = model.predict(model.built(with), seen.all[i], i, with) - at.predicted;
          // Second order: half the square of 0.3 mrad of lag, on 250 mm of arm.
          const double allowed =
              0.02 * columns.col(k).cwiseAbs().maxCoeff() + (candidate.curved ? 12e-9 : 2e-9) / size;
          EXPECT_LT((moved / size - columns.col(k)).cwiseAbs().maxCoeff(), allowed);
        }
      }
    }
  }
}

struct Aside {
  const char* what;
  void (*change)(ballbar::Run& run);
  const char* says;
};

TEST(LineObservation, RecordingsThatCannotBeUsedAreLeftAsideWithTheReason) {
  const Aside all[] = {
      {"without joints",
       [](ballbar::Run& run) {
         run.joints = 0;
         run.joint_time.clear();
         run.joint_position.clear();
       },
       "no joints were recorded"},
      {"marked the wrong way", [](ballbar::Run& run) { run.direction = -run.direction; },
       "the other way than its mark"},
      {"of another robot",
       [](ballbar::Run& run) {
         for (std::size_t i = 1; i < run.joint_position.size(); i += 6) run.joint_position[i] += 0.1;
       },
       "away from where its readings say"},
      {"with few points",
       [](ballbar::Run& run) { run.readings.erase(run.readings.begin() + 10, run.readings.end()); },
       "stands at 5 usable points"},
      {"with a hole",
       [](ballbar::Run& run) {
         for (std::size_t i = run.joint_time.size() / 2; i < run.joint_time.size(); ++i)
           run.joint_time[i] += 1.0;
       },
       "its joints have holes"},
      {"read along the line",
       [](ballbar::Run& run) {
         for (InterferometerReading& reading : run.readings) reading.axis = 'Y';
       },
       "lies along Y"},
  };
  for (const Aside& one : all) {
    SCOPED_TRACE(one.what);
    SeenLine line;
    test::MeasuredArm arm;
    std::vector<MeasuredRun> runs{arm.line(line.test, 1, 1)};
    one.change(runs.front().run);
    const Observations seen = observe(runs, line.spec, line.model.model());
    EXPECT_TRUE(seen.all.empty());
    ASSERT_FALSE(seen.left_aside.empty());
    EXPECT_NE(seen.left_aside.front().find(one.says), std::string::npos) << seen.left_aside.front();
  }
}

}  // namespace
}  // namespace ballbar
