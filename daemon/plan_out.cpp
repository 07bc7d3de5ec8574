#include "daemon/plan_out.hpp"

#include <unistd.h>

#include <cmath>
#include <cstdio>
#include <set>

#include "core/units.hpp"

namespace ballbar {
namespace {

using nlohmann::ordered_json;

/// As short as it may be while the test stays where it is to a nanometre.
std::string number(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.9g", std::abs(value) < 1e-12 ? 0.0 : value);
  return text;
}

std::string triple(const Vec3& v, double unit) {
  return "[" + number(v[0] / unit) + ", " + number(v[1] / unit) + ", " + number(v[2] / unit) + "]";
}

std::string sds(double value) { return std::to_string(std::lround(value)); }

/// With an article where the text names one.
std::string described(const RankedTest& test) {
  return test.proposed.test.name + ": " + test.proposed.differs + ", " +
         number(std::round(to_mm(test.proposed.test.feed) * 100.0) / 100.0) + " mm/s";
}

ordered_json test_json(const RankedTest& test) {
  return {{"test", test.proposed.test.name},
          {"kind", test.proposed.test.kind == TestKind::kLine ? "line" : "circle"},
          {"differs", test.proposed.differs},
          {"separation_sd", test.noise},
          {"with_formula_error_sd", test.sure},
          {"pairs_decided", test.decided},
          {"robot_test", test_table(test.proposed.test)}};
}

ordered_json tests_json(const std::vector<RankedTest>& tests) {
  ordered_json json = ordered_json::array();
  for (const RankedTest& test : tests) json.push_back(test_json(test));
  return json;
}

std::string circle_keys(const CircleSpec& circle) {
  return "centre_mm = " + triple(circle.centre, kMetresPerMm) + "\n" +
         "normal = " + triple(circle.normal, 1.0) + "\n" + "first_axis = " + triple(circle.first_axis, 1.0) +
         "\n" + "arc_deg = [" + number(circle.arc_start / kRadPerDeg) + ", " +
         number(circle.arc_sweep / kRadPerDeg) + "]\n" +
         "overshoot_deg = " + number(circle.overshoot / kRadPerDeg) + "\n" +
         "radius_mm = " + number(to_mm(circle.radius)) + "\n";
}

std::string line_keys(const LineSpec& line) {
  return "start_mm = " + triple(line.start, kMetresPerMm) + "\n" +
         "end_mm = " + triple(line.end, kMetresPerMm) + "\n" + "points = " + std::to_string(line.points) +
         "\n";
}

}  // namespace

std::string test_table(const TestSpec& test) {
  const bool line = test.kind == TestKind::kLine;
  std::string text = "[[robot.test]]\nname = \"" + test.name + "\"\nkind = \"" + (line ? "line" : "circle") +
                     "\"\n" + (line ? line_keys(test.line) : circle_keys(test.circle));
  text += "feed_mm_s = " + number(to_mm(test.feed)) + "\n";
  if (test.tool_rpy) text += "tool_rpy_deg = " + triple(*test.tool_rpy, kRadPerDeg) + "\n";
  if (test.payload) text += "payload_kg = " + number(*test.payload) + "\n";
  if (!test.posture.empty()) {
    text += "posture_deg = [";
    for (std::size_t i = 0; i < test.posture.size(); ++i)
      text += (i == 0 ? "" : ", ") + number(test.posture[i] / kRadPerDeg);
    text += "]\n";
  }
  return text;
}

std::string to_text(const std::vector<PairPlan>& plans) {
  std::string text;
  std::set<std::string> given;
  std::string tables;
  for (const PairPlan& plan : plans) {
    text += "\n" + plan.a + " or " + plan.b + "? Now " + sds(plan.now.noise) +
            " standard deviations apart. What would decide, each driven both ways, twice:\n";
    for (std::size_t i = 0; i < plan.tests.size(); ++i) {
      const RankedTest& test = plan.tests[i];
      text += "  " + std::to_string(i + 1) + ". " + described(test) + ": " + sds(test.noise) + " sd" +
              (test.sure < kSure ? ", too little to be sure of" : "") + "\n";
      if (i == 0 && given.insert(test.proposed.test.name).second)
        tables += "\n" + test_table(test.proposed.test);
    }
  }
  if (!tables.empty())
    text += "\nThe best of each, reachable on the whole path; below the [[robot]] in the configuration:\n" +
            tables;
  return text;
}

ordered_json to_json(const std::vector<PairPlan>& plans) {
  ordered_json json = ordered_json::array();
  for (const PairPlan& plan : plans)
    json.push_back({{"a", plan.a},
                    {"b", plan.b},
                    {"separation_sd_now", plan.now.noise},
                    {"tests", tests_json(plan.tests)}});
  return json;
}

std::string to_text(const RobotPlan& plan) {
  std::string text = "The tests driven so far show " + std::to_string(plan.visible) + " of " +
                     std::to_string(plan.effects) + " effects at their typical sizes, and tell " +
                     std::to_string(plan.apart) + " of " + std::to_string(plan.pairs) + " pairs apart.\n";
  if (plan.tests.empty()) text += "No further test would tell more apart.\n";
  std::size_t apart = plan.apart;
  for (std::size_t i = 0; i < plan.tests.size(); ++i) {
    apart += plan.tests[i].decided;
    text += "  " + std::to_string(i + 1) + ". " + described(plan.tests[i]) + ": tells " +
            std::to_string(apart) + " pairs apart";
    if (plan.tests[i].noise > 0.0) text += ", " + sds(plan.tests[i].noise) + " standard deviations";
    text += "\n";
  }
  if (!plan.never.empty()) {
    constexpr std::size_t kShown = 12;
    text += "No test that was looked at tells apart:\n";
    for (std::size_t i = 0; i < plan.never.size() && i < kShown; ++i) text += "  " + plan.never[i] + "\n";
    if (plan.never.size() > kShown)
      text += "  and " + std::to_string(plan.never.size() - kShown) + " more: --json has all\n";
  }
  if (!plan.tests.empty()) {
    text +=
        "\nReachable on the whole path; below the [[robot]] in the configuration, each driven both ways, "
        "twice:\n";
    for (const RankedTest& test : plan.tests) text += "\n" + test_table(test.proposed.test);
  }
  return text;
}

ordered_json to_json(const RobotPlan& plan) {
  return {{"effects", plan.effects},
          {"visible", plan.visible},
          {"pairs", plan.pairs},
          {"told_apart", plan.apart},
          {"tests", tests_json(plan.tests)},
          {"told_apart_with_all", plan.apart_with_all},
          {"never_told_apart", plan.never}};
}

ProgressLine::ProgressLine(std::string what)
    : what_(std::move(what)), terminal_(isatty(STDERR_FILENO) == 1) {}

ProgressLine::~ProgressLine() {
  if (terminal_) std::fputs("\r\033[K", stderr);
}

Progress ProgressLine::progress() {
  if (!terminal_) return {};
  return [this](std::size_t done, std::size_t of) {
    std::fprintf(stderr, "\r\033[K%s: %zu of %zu", what_.c_str(), done, of);
  };
}

}  // namespace ballbar
