// The joints of a small URDF, and the same file with other origins.

#include "files/urdf_joints.hpp"

#include <gtest/gtest.h>

#include "core/error.hpp"

namespace ballbar {
namespace {

const std::string kTwoJoints = R"(<robot name="two">
  <!-- made by hand -->
  <link name="base"><inertial><mass value="1.5"/></inertial></link><link name="arm"/><link name="tcp"/>
  <joint name="j1" type="revolute">
    <origin rpy="0 0 1.5" xyz="0.1 -2e-3 0.35"/><parent link="base"/><child link="arm"/><axis xyz="0 0 1"/>
  </joint>
  <joint name="flange" type="fixed"><parent link="arm"/><child link="tcp"/></joint>
</robot>)";

TEST(UrdfJoints, AreThoseOfTheFileInItsSequence) {
  const std::vector<UrdfJoint> joints = urdf_joints(kTwoJoints);
  ASSERT_EQ(joints.size(), 2u);
  EXPECT_EQ(joints[0].name, "j1");
  EXPECT_EQ(joints[0].parent, "base");
  EXPECT_EQ(joints[0].child, "arm");
  EXPECT_TRUE(joints[0].moves);
  EXPECT_EQ(joints[0].xyz, (Vec3{0.1, -0.002, 0.35}));
  EXPECT_EQ(joints[0].rpy, (Vec3{0, 0, 1.5}));
  EXPECT_EQ(joints[1].name, "flange");
  EXPECT_FALSE(joints[1].moves);
  EXPECT_EQ(joints[1].xyz, (Vec3{})) << "no origin is the parent's";
}

TEST(UrdfJoints, OtherOriginsAreReadBackToTheBitAndTheRestStays) {
  std::vector<UrdfJoint> changed{urdf_joints(kTwoJoints)[1]};
  changed[0].xyz = {1.0 / 3.0, 1e-17, -0.1};
  changed[0].rpy = {0.1 + 0.2, 0.0, -3e300};
  const std::string text = with_origins(kTwoJoints, changed, " as built ");
  const std::vector<UrdfJoint> joints = urdf_joints(text);
  ASSERT_EQ(joints.size(), 2u);
  EXPECT_EQ(joints[1].xyz, changed[0].xyz);
  EXPECT_EQ(joints[1].rpy, changed[0].rpy);
  EXPECT_EQ(joints[0].xyz, (Vec3{0.1, -0.002, 0.35}));
  for (const char* kept :
       {"<!-- made by hand -->", "<mass value=\"1.5\"", "<origin rpy=\"0 0 1.5\" xyz=\"0.1 -2e-3 0.35\""})
    EXPECT_NE(text.find(kept), std::string::npos) << kept << " is not in\n" << text;
  EXPECT_LT(text.find("<!-- as built -->"), text.find("made by hand"));
  EXPECT_GT(text.find("<!-- as built -->"), text.find("<robot"));
}

TEST(UrdfJoints, OfWhatIsNoRobotAreAnError) {
  for (const char* text : {"", "no XML", "<sdf/>", "<robot>"}) {
    EXPECT_THROW(urdf_joints(text), Error) << text;
    EXPECT_THROW(with_origins(text, {}, ""), Error) << text;
  }
}

}  // namespace
}  // namespace ballbar
