#pragma once
/// Which effects a case conceals, and how large. All by chance, from the seed.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "random.hpp"
#include "truth.hpp"

namespace blind {

using nlohmann::ordered_json;

/// One concealed effect: how it alters the physics, and how the answer names it.
struct Planted {
  std::function<void(Physics&)> apply;
  ordered_json answer;  ///< effect, joint, kind, parameters, accept_*
};

struct Kind {
  std::string plan = "PM";
  double size = 1.0;  ///< of concealed effects
  double noise = 1.0;
  double background_least_um = 0.0, background_most_um = 0.0;
  bool none = false;     ///< nothing is concealed
  bool engine = false;   ///< another program moves the arm; only effects that it knows
  bool outside = false;  ///< one effect that no catalogue has
  std::string only{};    ///< one effect of this name
};

/// By name: main, null, weak, noisy, clutter, heavy-clutter, outside, slip, p0, p3, mujoco. Throws
/// std::invalid_argument.
Kind kind_named(const std::string& name);

/// Zero offsets, wrong masses: in every case.
Physics always_present(Random& random);

/// Effects of the catalogue by the shares 20 % none, 45 % one, 25 % two, 10 % three; no two alike.
std::vector<Planted> draw_effects(const Kind& kind, const Plan& plan, double epoch_us, Random& random);

/// The same of those that an engine knows: compliance, backlash, lengths, the tool.
std::vector<Planted> draw_for_engine(Random& random);

/// An effect outside the catalogue whose size can be set: the answer's amplitude follows.
struct Outsider {
  Strange strange;
  ordered_json answer;
};
/// `visited`: least and greatest angle of each joint over the fitted circles.
Outsider draw_outsider(const std::vector<std::pair<double, double>>& visited, Random& random);

/// A little of everything at every joint, of random size.
Physics draw_background(Random& random);
/// `physics` with `factor` times the background on top.
Physics with_background(Physics physics, const Physics& background, double factor);

}  // namespace blind
