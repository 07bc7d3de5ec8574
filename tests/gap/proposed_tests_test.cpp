// Circles that are proposed beside the paper's circle A: each changes what it says, by as much as it says.

#include "gap/proposed_tests.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numbers>
#include <set>

#include "gap/paper_robot.hpp"

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

}  // namespace
}  // namespace ballbar
