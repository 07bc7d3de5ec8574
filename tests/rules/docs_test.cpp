// What docs/rules.md shows works as it stands there.

#include <gtest/gtest.h>

#include <fstream>
#include <sstream>
#include <string>
#include <vector>

#include "rules/rule_test.hpp"

namespace ballbar {
namespace {

std::vector<std::string> lua_blocks(const std::string& path) {
  std::ifstream file(path);
  std::vector<std::string> blocks;
  bool inside = false;
  for (std::string line; std::getline(file, line);) {
    if (line == "```lua") {
      blocks.emplace_back();
      inside = true;
    } else if (line == "```") {
      inside = false;
    } else if (inside) {
      blocks.back() += line + "\n";
    }
  }
  return blocks;
}

TEST(RuleDocs, TheExampleAndItsTablePass) {
  const std::vector<std::string> blocks = lua_blocks(BALLBAR_SOURCE_DIR "/docs/rules.md");
  ASSERT_EQ(blocks.size(), 2u);
  const RuleTestReport report = run_rule_test({"noise_up_test.lua", blocks[1]}, {"noise_up.lua", blocks[0]});
  EXPECT_EQ(report.rows, 6);
  for (const RuleError& failure : report.failures) ADD_FAILURE() << to_string(failure);
}

}  // namespace
}  // namespace ballbar
