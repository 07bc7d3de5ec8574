#pragma once
/// Robots with effects, and motions for them.

#include <cmath>
#include <initializer_list>
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

inline AsBuilt lrmate_with(std::vector<EffectSpec> effects) {
  return {lrmate_model(), with_effects(std::move(effects))};
}

/// All joints swing, each at its own rate, about a posture with bent elbow and wrist; they start at rest.
inline Motion swing(int samples, double rate, double speed = 1.0) {
  const std::vector<double> middle = radians({-40, 20, -30, 15, -70, 25});
  Motion motion;
  motion.time = Eigen::VectorXd::LinSpaced(samples, 0.0, (samples - 1) / rate);
  motion.q.resize(6, samples);
  for (int k = 0; k < samples; ++k)
    for (int j = 0; j < 6; ++j)
      motion.q(j, k) = middle[static_cast<std::size_t>(j)] +
                       0.2 * (1.0 - std::cos((0.5 + 0.1 * j) * speed * motion.time(k)));
  return motion;
}

}  // namespace ballbar::test
