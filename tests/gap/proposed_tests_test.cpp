// Circles and lines that are proposed beside the paper's circle A and line Y: each changes what it says, by
// as much as it says.

#include "gap/proposed_tests.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>
#include <tuple>

#include "gap/measured_arm.hpp"
#include "gap/next_test.hpp"

namespace ballbar {
namespace {

using Eigen::Vector3d;

class ProposedTests : public testing::Test {
 protected:
  static RobotSpec robot() {
    RobotSpec spec = test::paper_robot({test::paper_circle("A")}, {});
    spec.payload = 0.438;
    return spec;
  }
  ProposedTests() : model_(AsBuilt(test::lrmate(), robot()), robot()), all_(proposed_tests(model_)) {}

  /// The one that differs in this; an empty one where there is none.
  TestSpec with(const std::string& differs) const {
    for (const ProposedTest& one : all_)
      if (one.differs == differs + " about the centre of A") return one.test;
    ADD_FAILURE() << "no circle with " << differs;
    return {};
  }
  static double tilt_deg(const TestSpec& test) {
    const Vec3& n = test.circle.normal;
    return std::acos(n[2] / std::hypot(n[0], n[1], n[2])) / test::kDeg;
  }

  GapModel model_;
  std::vector<ProposedTest> all_;
};

TEST_F(ProposedTests, ChangeWhatTheySay) {
  const TestSpec same = with("nothing changed");
  EXPECT_EQ(same.circle.radius, 0.1);
  EXPECT_EQ(same.feed, 0.05533);
  EXPECT_DOUBLE_EQ(with("twice the feed").feed, 2 * 0.05533);
  EXPECT_DOUBLE_EQ(with("half the radius").circle.radius, 0.05);
  EXPECT_DOUBLE_EQ(with("raised by 130 mm").circle.centre[2], -0.251 + 0.13);
  EXPECT_DOUBLE_EQ(with("2.44 kg").payload.value_or(0.0), 2.438) << "2 kg more than the lightest";
  std::set<std::string> names;
  for (const ProposedTest& one : all_) names.insert(one.test.name);
  EXPECT_EQ(names.size(), all_.size()) << "names are given once";
}

// Where 30 degrees are out of reach it is 20: the words say which.
TEST_F(ProposedTests, TiltPlaneAndToolByWhatTheySay) {
  int tilted = 0;
  for (const ProposedTest& one : all_) {
    SCOPED_TRACE(one.differs);
    const bool plane = one.differs.starts_with("plane and tool tilted by ");
    const bool tool = one.differs.starts_with("tool tilted by ");
    const double said =
        plane || tool ? std::abs(std::stod(one.differs.substr(one.differs.find(" by ") + 4))) : 0.0;
    EXPECT_NEAR(tilt_deg(one.test), plane ? said : 0.0, 1e-6);
    // Fixed-axis angles; the tool of circle A points straight down.
    const Vec3& rpy = *one.test.tool_rpy;
    const Eigen::Matrix3d turn =
        (Eigen::AngleAxisd(rpy[2], Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy[1], Vector3d::UnitY()) *
         Eigen::AngleAxisd(rpy[0], Vector3d::UnitX()))
            .toRotationMatrix();
    EXPECT_NEAR(std::acos(std::clamp(-turn(2, 2), -1.0, 1.0)) / test::kDeg, said, 1e-5);
    tilted += plane || tool ? 1 : 0;
  }
  EXPECT_GE(tilted, 3);
}

TEST_F(ProposedTests, AreObservedBothWaysWithTheNoiseOfTwoLaps) {
  const TestSpec small = with("half the radius");
  const LapNoise noise{Eigen::VectorXd::LinSpaced(181, 0.0, 180.0), Eigen::VectorXd::Constant(181, 4e-12),
                       20.0};
  const std::vector<Observation> both = as_observed(model_, small, 3, noise);
  ASSERT_EQ(both.size(), 2u);
  EXPECT_EQ(both[0].direction + both[1].direction, 0);
  const double time_per_turn = 2.0 * std::numbers::pi * 0.05 / small.feed;
  for (const Observation& seen : both) {
    EXPECT_EQ(seen.set_up, 3);
    EXPECT_EQ(seen.places(), 400);
    EXPECT_EQ(seen.measured.cwiseAbs().maxCoeff(), 0.0) << "nothing is measured yet";
    // As many readings a second as in the lap of 20 s.
    EXPECT_NEAR(seen.variance[7] * time_per_turn / 20.0, 0.5 * 4e-12, 1e-18);
  }
}

RobotSpec with_line() {
  RobotSpec spec = test::paper_robot({test::paper_circle("A"), test::paper_line()}, {});
  spec.payload = 0.438;
  return spec;
}

Vector3d point(const Vec3& v) { return {v[0], v[1], v[2]}; }

/// Joint angles with the tool straight down exist there, by two triangles.
bool within_reach(const Vector3d& place) { return test::tool_down_at(place).allFinite(); }

class ProposedLines : public testing::Test {
 protected:
  ProposedLines() : model_(AsBuilt(test::lrmate(), with_line()), with_line()), all_(proposed_tests(model_)) {
    std::erase_if(all_, [](const ProposedTest& one) { return one.test.kind != TestKind::kLine; });
  }

  TestSpec that_begins(const std::string& differs) const {
    for (const ProposedTest& one : all_)
      if (one.differs.starts_with(differs)) return one.test;
    ADD_FAILURE() << "no " << differs;
    return {};
  }

  GapModel model_;
  std::vector<ProposedTest> all_;
};

TEST(ProposedTestsOfKinds, LinesAreProposedOnlyWhereThereAreOpticsOrWhereAskedFor) {
  const RobotSpec spec = test::paper_robot({test::paper_circle("A")}, {});
  const GapModel model(AsBuilt(test::lrmate(), spec), spec);
  const auto lines = [](const std::vector<ProposedTest>& all) {
    return std::count_if(all.begin(), all.end(),
                         [](const ProposedTest& one) { return one.test.kind == TestKind::kLine; });
  };
  EXPECT_EQ(lines(proposed_tests(model)), 0);
  const std::vector<ProposedTest> asked = proposed_tests(model, {.lines = true});
  EXPECT_GE(lines(asked), 5);
  EXPECT_GT(static_cast<std::ptrdiff_t>(asked.size()), lines(asked)) << "circles stay";
  for (const ProposedTest& one : asked)
    if (one.test.kind == TestKind::kLine) {
      EXPECT_NE(one.differs.find("the centre of A"), std::string::npos) << one.differs;
    }
}

TEST_F(ProposedLines, AreWhatTheySay) {
  std::set<std::string> names;
  for (const ProposedTest& one : all_) {
    SCOPED_TRACE(one.differs);
    names.insert(one.test.name);
    const Vector3d start = point(one.test.line.start), way = point(one.test.line.end) - start;
    const double said_mm = std::stod(one.differs.substr(one.differs.find(", ") + 2));
    EXPECT_NEAR(1e3 * way.norm(), said_mm, 0.51);
    for (int axis = 0; axis < 3; ++axis)
      if (one.differs.starts_with(std::string("line along ") + "XYZ"[axis])) {
        EXPECT_NEAR(std::abs(way[axis]), way.norm(), 1e-9);
      }
    Vector3d middle = start + 0.5 * way;
    if (one.differs.find("130 mm above") != std::string::npos) middle[2] -= 0.13;
    if (one.differs.find("130 mm below") != std::string::npos) middle[2] += 0.13;
    if (one.differs.find("further out") != std::string::npos) middle[0] -= 0.1;
    if (one.differs.find("nearer") != std::string::npos) middle[0] += 0.1;
    EXPECT_LT((middle - Vector3d(0.380, 0.0, -0.251)).norm(), 1e-9);
    EXPECT_EQ(one.test.line.points, 51);
    EXPECT_EQ(one.test.feed, 0.05533) << "at stops the feed tells nothing";
    if (one.differs.find("2.44 kg") != std::string::npos) {
      EXPECT_DOUBLE_EQ(one.test.payload.value_or(0.0), 2.438);
    }
  }
  EXPECT_EQ(names.size(), all_.size()) << "names are given once";
  for (const char* along : {"line along X", "line along Y", "line along Z", "line along [0.71 0.71 0]"})
    that_begins(along);
}

// 940 mm along X reach into the robot's foot and beyond its arm.
TEST_F(ProposedLines, StayWithinReach) {
  const Vector3d middle(0.380, 0.0, -0.251);
  ASSERT_FALSE(within_reach(middle + Vector3d(0.470, 0.0, 0.0)));
  const TestSpec out = that_begins("line along X");
  EXPECT_LT((point(out.line.end) - point(out.line.start)).norm(), 0.75);
  for (const ProposedTest& one : all_) {
    if (one.test.tool_rpy != Vec3{std::numbers::pi, 0.0, 0.0}) continue;
    SCOPED_TRACE(one.differs);
    const Vector3d start = point(one.test.line.start), way = point(one.test.line.end) - start;
    for (int k = 0; k <= 20; ++k) EXPECT_TRUE(within_reach(start + 0.05 * k * way));
  }
}

TEST(ProposedTestsOfKinds, OfALineThatCannotBeReachedNothingIsProposedThere) {
  TestSpec far = test::paper_line();
  far.line = {{1.5, -0.4, 0.0}, {1.5, 0.4, 0.0}, 51};
  const RobotSpec spec = test::paper_robot({far}, {});
  EXPECT_TRUE(proposed_tests(GapModel(AsBuilt(test::lrmate(), spec), spec)).empty());
}

TEST_F(ProposedLines, AreObservedBothWaysAlongBothAxesAcross) {
  const TestSpec line = that_begins("line along Y, 940 mm long");
  const LapNoise noise{Eigen::VectorXd::LinSpaced(51, 0.0, 25.0), Eigen::VectorXd::Constant(51, 4e-12), 20.0};
  const std::vector<Observation> all = as_observed(model_, line, 3, noise);
  ASSERT_EQ(all.size(), 4u);
  std::set<std::tuple<int, char, int>> kinds;
  for (const Observation& seen : all) {
    kinds.insert({seen.direction, seen.instrument.axis, seen.set_up});
    EXPECT_TRUE(seen.at_rest);
    EXPECT_EQ(seen.places(), 50) << "how the robot came to the first stop is not in the recording";
    EXPECT_DOUBLE_EQ(seen.variance[7], 0.5 * 4e-12) << "as many readings at each stop, however fast";
    EXPECT_EQ(seen.measured.cwiseAbs().maxCoeff(), 0.0) << "nothing is measured yet";
  }
  EXPECT_EQ(kinds,
            (std::set<std::tuple<int, char, int>>{{1, 'X', 3}, {-1, 'X', 3}, {1, 'Z', 4}, {-1, 'Z', 4}}));
}

TEST_F(ProposedLines, ThatAreReadOnTheWayHaveFewerReadingsWhenDrivenFaster) {
  std::vector<ProposedTest> all = proposed_tests(model_, {.on_the_way = true});
  const auto fast = std::find_if(all.begin(), all.end(), [](const ProposedTest& one) {
    return one.differs ==
           "line along Y, 940 mm long, twice the feed, through the middle of Y, read on the way";
  });
  ASSERT_NE(fast, all.end());
  EXPECT_DOUBLE_EQ(fast->test.feed, 2 * 0.05533);
  const LapNoise noise{Eigen::VectorXd::LinSpaced(181, 0.0, 180.0), Eigen::VectorXd::Constant(181, 4e-12),
                       0.940 / 0.05533, false};
  for (const Observation& seen : as_observed(model_, fast->test, 0, noise)) {
    EXPECT_FALSE(seen.at_rest);
    EXPECT_EQ(seen.places(), 400);
    EXPECT_NEAR(seen.transform.frequency().tail(1)[0], 180.0, 0.5);
    EXPECT_NEAR(seen.variance[7], 2.0 * 0.5 * 4e-12, 1e-15);
  }
}

/// How far an effect stands out of the noise of a line.
double shows(const GapModel& model, const std::vector<Observation>& seen, const std::string& label) {
  for (const Candidate& candidate : candidates_for(model, {})) {
    if (candidate.label() != label) continue;
    const std::vector<Suspect> suspects{suspect_of(candidate)};
    return Judge(information_of(model, seen, model.start(seen), suspects), suspects, model.joints())
        .of(0)
        .noise;
  }
  throw std::runtime_error("no candidate " + label);
}

// The line is driven by an arm of school geometry that shares no code with what plans it.
class PlannedLine : public testing::TestWithParam<std::tuple<bool, std::string>> {};

TEST_P(PlannedLine, ShowsAsMuchAsOneThatIsRecorded) {
  const auto& [at_stops, label] = GetParam();
  const TestSpec line = test::line_at("Y", -0.251);
  RobotSpec spec = test::paper_robot({line}, {});
  spec.payload = 0.5;  // of the arm that drives
  const GapModel model(AsBuilt(test::lrmate(), spec), spec);
  const LapNoise noise{Eigen::VectorXd::LinSpaced(181, 0.0, 180.0), Eigen::VectorXd::Constant(181, 2e-12),
                       0.8 / line.feed, at_stops};
  test::MeasuredArm arm;
  arm.stops = at_stops;
  std::vector<MeasuredRun> runs;
  arm.drive(line, runs);
  std::vector<Observation> recorded = observe(std::move(runs), spec, model.model()).all;
  ASSERT_EQ(recorded.size(), 4u);
  for (Observation& seen : recorded) {
    EXPECT_EQ(seen.at_rest, at_stops);
    seen.variance = Eigen::VectorXd::Constant(seen.measured.size(), 1e-12);
  }
  const double planned = shows(model, as_observed(model, line, 0, noise), label);
  EXPECT_GT(planned, 3.0);
  EXPECT_NEAR(planned, shows(model, recorded, label), 0.1 * planned);
}

INSTANTIATE_TEST_SUITE_P(AtStops, PlannedLine,
                         testing::Combine(testing::Values(true),
                                          testing::Values("joint_lost_motion J1 friction_windup",
                                                          "joint_compliance J2")));
INSTANTIATE_TEST_SUITE_P(OnTheWay, PlannedLine,
                         testing::Combine(testing::Values(false),
                                          testing::Values("joint_lost_motion J1 friction_windup",
                                                          "joint_compliance J2", "servo_lag J1")));

}  // namespace
}  // namespace ballbar
