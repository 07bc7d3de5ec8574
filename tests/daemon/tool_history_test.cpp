// A robot over its life, as a person asks for it: since when it is another, what has changed since the
// baseline.

#include "support/tool_test.hpp"

namespace ballbar {
namespace {

using test::ballbar;
using test::Outcome;

constexpr double kOffsetDeg = 0.02;  // of joint 3, from the second day on

class ToolHistory : public test::ToolTest {
 protected:
  /// Circle A, both ways, measured on a day of 2026 and put into life.db.
  static void day(const std::string& series, int number, int repetitions, const test::Words& more = {}) {
    test::Words words{"simulate", "--config", path("lrmate.toml"), "--test", "A",
                      "--series", series,     "--noise-um",        "0.7"};
    const std::int64_t start_us = 1'767'225'600'000'000 + number * std::int64_t{86'400'000'000};
    words.insert(words.end(),
                 {"--repetitions", std::to_string(repetitions), "--seed", std::to_string(number + 1),
                  "--start-us", std::to_string(start_us), "-o", path("day.lcm")});
    words.insert(words.end(), more.begin(), more.end());
    ASSERT_EQ(ballbar(words).code, 0);
    const Outcome replayed = ask({"replay", path("day.lcm"), "--quiet"});
    ASSERT_EQ(replayed.code, 0) << replayed.err;
  }
  static Outcome ask(test::Words words) {
    words.insert(words.end(), {"--config", path("lrmate.toml"), "--db", path("life.db")});
    return ballbar(words);
  }
};

TEST_F(ToolHistory, ARobotThatWasMasteredAnew) {
  day("before", 0, 5);
  const Outcome same = ask({"diagnose", "--since-when"});
  EXPECT_EQ(same.code, 0) << same.out;
  EXPECT_EQ(same.out.find("looks like"), std::string::npos) << same.out;

  const Outcome no_baseline = ask({"diagnose", "--series", "before", "--against-baseline"});
  EXPECT_EQ(no_baseline.code, 2);
  EXPECT_NE(no_baseline.err.find("ballbar baseline keep"), std::string::npos) << no_baseline.err;
  EXPECT_EQ(ask({"baseline", "keep", "--series", "nowhere"}).code, 2);
  const Outcome kept = ask({"baseline", "keep", "--series", "before"});
  ASSERT_EQ(kept.code, 0) << kept.err;
  const Outcome shown = ask({"baseline", "show"});
  EXPECT_EQ(shown.code, 0) << shown.err;
  EXPECT_NE(shown.out.find("series before"), std::string::npos) << shown.out;

  day("after", 1, 3, {"--effect", "joint_zero_offset,joint=3,offset_deg=" + std::to_string(kOffsetDeg)});
  const Outcome changed = ask({"diagnose", "--since-when"});
  EXPECT_EQ(changed.code, 1) << changed.err;
  for (const char* text : {"changed between 2026-01-01 ", " and 2026-01-02 00:00:00 (UTC, 95 %)",
                           "It looks like joint_zero_offset of joint 3"})
    EXPECT_NE(changed.out.find(text), std::string::npos) << text << "\n" << changed.out;

  const Outcome against = ask({"diagnose", "--series", "after", "--against-baseline", "--json"});
  ASSERT_EQ(against.code, 0) << against.err;
  const nlohmann::json diagnosis = nlohmann::json::parse(against.out);
  EXPECT_EQ(diagnosis["verdict"], "nothing_missing") << "zeros are no physics that is missing";
  ASSERT_EQ(diagnosis["left_out"].size(), 1u);
  const nlohmann::json& named = diagnosis["left_out"][0];
  EXPECT_EQ(named["effect"], "joint_zero_offset");
  EXPECT_EQ(named["joint"], 3);
  const nlohmann::json& offset = named["parameters"][0];
  EXPECT_NEAR(offset["value"].get<double>(), kOffsetDeg, 4.0 * offset["sd"].get<double>());
  EXPECT_LT(offset["sd"].get<double>(), 0.02 * kOffsetDeg);
}

}  // namespace
}  // namespace ballbar
