#pragma once
/// Robots with effects, and motions for them.

#include <cmath>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "kinematics/robots.hpp"
#include "physics/as_built.hpp"

namespace ballbar::test {

inline EffectSpec effect(const std::string& name, int joint, std::map<std::string, double> parameters,
                         std::map<std::string, std::string> words = {}) {
  return {name, joint, std::move(parameters), std::move(words)};
}

inline RobotSpec with_effects(std::vector<EffectSpec> effects) {
  RobotSpec spec;
  spec.name = "r";
  spec.payload_com = {0, 0, 0.050};
  spec.effects = std::move(effects);
  return spec;
}

inline AsBuilt lrmate_with(std::vector<EffectSpec> effects,
                           JointConvention convention = JointConvention::kFanuc) {
  return {lrmate_model(convention), with_effects(std::move(effects))};
}

/// One joint about `axis`: 2 kg 0.3 m along x, the tool point 0.5 m along x. About "0 -1 0" the angle is that
/// above the horizontal; about "0 0 1" gravity has no part.
inline AsBuilt arm_with(std::vector<EffectSpec> effects, const std::string& axis = "0 -1 0") {
  const std::string urdf = R"(<robot name="arm"><link name="base"/>
    <link name="l1"><inertial><origin xyz="0.3 0 0"/><mass value="2"/>
      <inertia ixx="0" ixy="0" ixz="0" iyy="0.02" iyz="0" izz="0.02"/></inertial></link>
    <link name="tool0"/><link name="tcp"/>
    <joint name="j1" type="continuous"><parent link="base"/><child link="l1"/><axis xyz=")" +
                           axis + R"("/></joint>
    <joint name="f" type="fixed"><parent link="l1"/><child link="tool0"/><origin xyz="0.4 0 0"/></joint>
    <joint name="t" type="fixed"><parent link="tool0"/><child link="tcp"/><origin xyz="0.1 0 0"/></joint></robot>)";
  return {RobotModel(urdf, "base", "tcp", JointConvention::kSerial), with_effects(std::move(effects))};
}

/// n samples of one joint at `rate` [1/s].
inline Motion single(int n, double rate, const std::function<double(double)>& angle) {
  Motion motion{Eigen::VectorXd::LinSpaced(n, 0.0, (n - 1) / rate), Eigen::MatrixXd(1, n)};
  for (int k = 0; k < n; ++k) motion.q(0, k) = angle(motion.time(k));
  return motion;
}

/// All joints swing, each at its own rate, about a posture with bent elbow and wrist; they start at rest.
inline Motion swing(int n, double rate, double speed = 1.0) {
  const std::vector<double> middle = radians({-40, 20, -30, 15, -70, 25});
  Motion motion{Eigen::VectorXd::LinSpaced(n, 0.0, (n - 1) / rate), Eigen::MatrixXd(6, n)};
  for (int k = 0; k < n; ++k)
    for (int j = 0; j < 6; ++j)
      motion.q(j, k) = middle[static_cast<std::size_t>(j)] +
                       0.2 * (1.0 - std::cos((0.5 + 0.1 * j) * speed * motion.time(k)));
  return motion;
}

inline std::vector<double> column(const Motion& motion, int k) {
  return {motion.q.col(k).data(), motion.q.col(k).data() + motion.q.rows()};
}

}  // namespace ballbar::test
