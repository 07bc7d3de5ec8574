#pragma once
/// The paper's robot with the circles that docs/diagnose.md asks for.

#include <algorithm>
#include <stdexcept>
#include <string>
#include <vector>

#include "gap/paper_robot.hpp"
#include "gap/proposed_tests.hpp"

namespace ballbar::test {

/// Circle A, flat, and of those that are proposed beside it the first whose description begins with each of
/// `differs`; with at most 3 kg.
inline RobotSpec planned_robot(const std::vector<std::string>& differs) {
  RobotSpec robot = paper_robot({paper_circle("A")}, {});
  robot.payload = 0.438;
  robot.payload_com = {0, 0, 0.05};
  const GapModel model(AsBuilt(lrmate(), robot), robot);
  const std::vector<ProposedTest> proposed = proposed_tests(model, {.payload = 3.0});
  for (const std::string& words : differs) {
    const auto one = std::find_if(proposed.begin(), proposed.end(),
                                  [&](const ProposedTest& p) { return p.differs.starts_with(words); });
    if (one == proposed.end()) throw std::runtime_error("no circle is proposed with " + words);
    robot.tests.push_back(one->test);
  }
  return robot;
}

}  // namespace ballbar::test
