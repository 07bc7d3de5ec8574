// The URDF as built, read back: its tool point is that of the model with the effects, for every shipped
// robot.

#include "daemon/urdf_out.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <random>

#include "core/error.hpp"
#include "daemon/config.hpp"
#include "daemon/service.hpp"

namespace ballbar {
namespace {

namespace fs = std::filesystem;

TEST(UrdfAsBuilt, ReadBackPredictsTheSameForEveryShippedRobot) {
  constexpr unsigned kSeed = 51;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937 random(kSeed);
  std::uniform_real_distribution<double> uniform(-1.0, 1.0);
  int robots = 0;
  for (const auto& entry : fs::directory_iterator(BALLBAR_SOURCE_DIR "/scripts/robots")) {
    if (entry.path().extension() != ".toml") continue;
    SCOPED_TRACE(entry.path().string());
    const Config config = load_config(entry.path().string());
    RobotSpec spec = config.robots.front();
    const std::string urdf = read_text(spec.urdf_path);
    const RobotModel nominal(urdf, spec.base, spec.tip, spec.joint_convention);
    spec.effects.clear();
    for (int joint = 1; joint <= nominal.joints(); ++joint) {
      spec.effects.push_back({"joint_zero_offset", joint, {{"offset_deg", 0.2 * uniform(random)}}, {}});
      std::map<std::string, double> link{{"a_mm", uniform(random)}, {"alpha_deg", 0.1 * uniform(random)}};
      if (joint > 1) link["d_mm"] = uniform(random);
      spec.effects.push_back({"link_geometry", joint, link, {}});
    }
    spec.effects.push_back({"tool_offset", 0, {{"x_mm", 0.7}, {"y_mm", -0.4}, {"z_mm", 1.1}}, {}});
    spec.effects.push_back({"joint_eccentricity", 2, {{"amplitude_deg", 0.01}, {"phase_deg", 30.0}}, {}});
    const AsBuilt built(nominal, spec);
    const std::string text = as_built_urdf(urdf, spec, built);
    EXPECT_NE(text.find("joint_eccentricity of joint 2"), std::string::npos) << "what is not in it is said";
    const RobotModel again(text, spec.base, spec.tip, spec.joint_convention);
    double moved = 0.0;
    for (int i = 0; i < 200; ++i) {
      std::vector<double> q(static_cast<std::size_t>(nominal.joints()));
      for (double& angle : q) angle = 3.0 * uniform(random);
      std::vector<double> chain = q;
      nominal.to_chain(chain);
      const Eigen::Isometry3d wanted = built.chain().forward(chain);
      ASSERT_LT((again.forward(q).translation() - wanted.translation()).norm(), 1e-9);
      moved = std::max(moved, (nominal.forward(q).translation() - wanted.translation()).norm());
    }
    EXPECT_GT(moved, 1e-3) << "the effects did something";
    ++robots;
  }
  EXPECT_GE(robots, 2);
}

TEST(UrdfAsBuilt, RefusesAToolThatHasNoPlace) {
  const std::string urdf =
      "<robot name='r'><link name='base'/><link name='tcp'/><joint name='j1' type='continuous'>"
      "<parent link='base'/><child link='tcp'/><origin xyz='1 0 0'/><axis xyz='0 0 1'/></joint></robot>";
  RobotSpec spec;
  spec.effects.push_back({"tool_offset", 0, {{"x_mm", 1.0}}, {}});
  const RobotModel model(urdf, "base", "tcp", JointConvention::kSerial);
  try {
    as_built_urdf(urdf, spec, AsBuilt(model, spec));
    FAIL() << "the tool is off by 1 mm and the tip turns with the joint";
  } catch (const Error& error) {
    EXPECT_EQ(error.cause(), Cause::kInput);
    EXPECT_NE(std::string(error.what()).find("fixed joint"), std::string::npos);
  }
}

}  // namespace
}  // namespace ballbar
