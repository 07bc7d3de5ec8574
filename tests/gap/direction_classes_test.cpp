// Which joints' lost motion two flat circles do not tell apart, and that a tilted one does.

#include "gap/direction_classes.hpp"

#include <gtest/gtest.h>

#include <set>

#include "gap/paper_robot.hpp"
#include "gap/proposed_tests.hpp"

namespace ballbar {
namespace {

/// Joints that could as well be it, where an effect of joint 2 was found on these circles.
std::set<int> twins_of_joint_2(const std::vector<TestSpec>& circles, const std::string& effect) {
  const RobotSpec spec = test::paper_robot(circles, {});
  const GapModel model(AsBuilt(test::lrmate(), spec), spec);
  std::vector<Observation> seen;
  for (std::size_t i = 0; i < circles.size(); ++i)
    for (Observation& one : as_observed(model, circles[i], static_cast<int>(i), lap_noise_of({})))
      seen.push_back(std::move(one));
  Diagnosis diagnosis;
  diagnosis.left_out.resize(1);
  diagnosis.left_out[0].spec = {effect, 2, {}, {}};
  add_direction_classes(GapFitter(model, seen), diagnosis);
  std::set<int> joints;
  for (const Twin& twin : diagnosis.left_out[0].twins) {
    EXPECT_EQ(twin.effect, effect);
    EXPECT_NE(twin.to_tell_apart.find("tilted"), std::string::npos);
    joints.insert(twin.joint);
  }
  return joints;
}

// The robot's upper arm, forearm and wrist move in one vertical plane: the paper's circles turn all three
// back where they are nearest to the robot's axis and farthest from it.
TEST(DirectionClasses, OnThePapersCirclesJoints2And3And5AreOne) {
  const std::vector<TestSpec> circles{test::paper_circle("A"), test::paper_circle("B")};
  EXPECT_EQ(twins_of_joint_2(circles, "joint_lost_motion"), (std::set<int>{3, 5}));
  EXPECT_EQ(twins_of_joint_2(circles, "servo_lag"), (std::set<int>{3, 5}));
  EXPECT_TRUE(twins_of_joint_2(circles, "joint_compliance").empty()) << "it hangs on no direction";
}

TEST(DirectionClasses, ATiltedCircleTellsThemApart) {
  TestSpec tilted = test::paper_circle("T");
  tilted.circle.normal = {-0.5, 0.0, std::sqrt(0.75)};
  tilted.circle.first_axis = {std::sqrt(0.75), 0.0, 0.5};
  tilted.tool_rpy = Vec3{test::kDeg * 180.0, -test::kDeg * 30.0, 0.0};
  EXPECT_TRUE(
      twins_of_joint_2({test::paper_circle("A"), test::paper_circle("B"), tilted}, "joint_lost_motion")
          .empty());
}

}  // namespace
}  // namespace ballbar
