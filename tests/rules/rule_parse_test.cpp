#include <gtest/gtest.h>

#include "rules/test_records.hpp"

namespace ballbar {
namespace {

std::string parse(const std::string& text) {
  return test::outcome([&] { parse_rule({"x.lua", text}); });
}

// A good rule, in which the tests change one line each. Line 1 is a comment that holds all the words.
std::string rule_with(const std::string& line, const std::string& replacement) {
  std::string text =
      "-- name on needs where hold_runs keep_runs severity limit_um when text\n"
      "return {\n"
      "  name = \"x\",\n"
      "  on = \"circle\",\n"
      "  needs = { \"ovality_um\" },\n"
      "  where = { test = \"A\" },\n"
      "  hold_runs = 2,\n"
      "  keep_runs = 3,\n"
      "  severity = \"critical\",\n"
      "  limit_um = 25,\n"
      "  when = function(r, h, rule) return r.ovality_um > rule.limit_um end,\n"
      "  text = \"{ovality_um} > {limit_um}\",\n"
      "}\n";
  const std::size_t at = text.find(line);
  EXPECT_NE(at, std::string::npos) << line;
  return text.replace(at, line.size(), replacement);
}

TEST(ParseRule, ReadsAllThatTheFileSays) {
  const Rule rule = parse_rule({"x.lua", rule_with("severity = \"critical\"",
                                                   "severity = \"critical\", unit = \"um\", strict = true")});
  EXPECT_EQ(rule.name, "x");
  EXPECT_EQ(rule.kind, "circle");
  EXPECT_EQ(rule.needs, std::vector<std::string>{"ovality_um"});
  EXPECT_EQ(rule.where.labels, (std::map<std::string, std::string>{{"test", "A"}}));
  EXPECT_FALSE(rule.where.direction.has_value());
  EXPECT_EQ(rule.hold_runs, 2);
  EXPECT_EQ(rule.keep_runs, 3);
  EXPECT_EQ(rule.severity, "critical");
  EXPECT_EQ(std::get<double>(rule.fields.at("limit_um")), 25.0);
  EXPECT_EQ(std::get<std::string>(rule.fields.at("unit")), "um");
  EXPECT_TRUE(std::get<bool>(rule.fields.at("strict")));
  EXPECT_EQ(rule.source.file, "x.lua");
}

TEST(ParseRule, HasDefaultsForTheRest) {
  const Rule rule = parse_rule(test::rule_source("short", "true"));
  EXPECT_EQ(rule.hold_runs, 1);
  EXPECT_EQ(rule.keep_runs, 1);
  EXPECT_EQ(rule.severity, "warning");
  EXPECT_TRUE(rule.where.labels.empty());
  EXPECT_TRUE(rule.fields.empty());
}

struct Mistake {
  const char* line;
  const char* replacement;
  const char* answer;
};

void PrintTo(const Mistake& mistake, std::ostream* out) { *out << mistake.replacement; }

class ParseRuleMistake : public testing::TestWithParam<Mistake> {};

TEST_P(ParseRuleMistake, IsToldWithItsLine) {
  const std::string said = parse(rule_with(GetParam().line, GetParam().replacement));
  EXPECT_EQ(said.substr(0, std::string(GetParam().answer).size()), GetParam().answer);
}

INSTANTIATE_TEST_SUITE_P(
    All, ParseRuleMistake,
    testing::Values(
        Mistake{"\"ovality_um\"", "\"ovalty_um\"",
                "5: needs 'ovalty_um', which is no quantity of a circle; did you mean 'ovality_um'?"},
        Mistake{"\"ovality_um\"", "\"straightness_mz_um\"",
                "5: needs 'straightness_mz_um', which is no quantity of a circle"},
        Mistake{"\"ovality_um\"", "\"harmonic31_um\"",
                "5: needs 'harmonic31_um', which is no quantity of a circle"},
        Mistake{"{ \"ovality_um\" }", "\"ovality_um\"", "5: needs must be a list of names"},
        Mistake{"{ \"ovality_um\" }", "{ 1 }", "5: needs must hold names in quotes, not a number"},
        Mistake{"{ \"ovality_um\" }", "{ a = \"ovality_um\" }", "5: needs must be a list of names"},
        Mistake{"name = \"x\"", "name = \"X y\"", "3: name must be given, and be of small letters"},
        Mistake{"name = \"x\"", "name = 12", "3: name must be a text in quotes, not a number"},
        Mistake{"name = \"x\",", "", "0: name must be given"},
        Mistake{"on = \"circle\"", "on = \"circles\"",
                "4: on must be one of \"circle\" \"line\" \"test\" \"residual\" \"silence\" \"loss\" "
                "\"gap\", not "
                "\"circles\""},
        Mistake{"test = \"A\"", "tests = \"A\"",
                "6: where knows robot, test, series, axis, source, direction and payload_kg, not 'tests'"},
        Mistake{"test = \"A\"", "source = \"joint\"", "6: where.source must be \"bar\""},
        Mistake{"test = \"A\"", "test = 1", "6: where.test must be a text in quotes"},
        Mistake{"test = \"A\"", "direction = 2", "6: where.direction must be 1, -1 or 0"},
        Mistake{"{ test = \"A\" }", "\"A\"", "6: where must be a table"},
        Mistake{"hold_runs = 2", "hold_runs = 0", "7: hold_runs must be a whole number from 1 to 1000"},
        Mistake{"hold_runs = 2", "hold_runs = \"2\"", "7: hold_runs must be a whole number"},
        Mistake{"hold_runs = 2", "hold_s = -1", "7: hold_s must be a number of seconds, 0 to 366 days"},
        Mistake{"hold_runs = 2", "keep_s = '8h'", "7: keep_s must be a number of seconds"},
        Mistake{"hold_runs = 2", "flap_runs = 61", "7: flap_runs must be a whole number from 1 to 60"},
        Mistake{"hold_runs = 2", "flap_fire = 2", "7: unknown key 'flap_fire'; did you mean 'flap_fires'?"},
        Mistake{"hold_runs = 2", "hold_run = 2", "7: unknown key 'hold_run'; did you mean 'hold_runs'?"},
        Mistake{"keep_runs = 3", "keep_runs = 1.5", "8: keep_runs must be a whole number from 0 to 1000"},
        Mistake{"keep_runs = 3", "keep_runs = -1", "8: keep_runs must be a whole number from 0 to 1000"},
        Mistake{"\"critical\"", "\"high\"",
                "9: severity must be one of \"info\" \"warning\" \"critical\", not \"high\""},
        Mistake{"limit_um = 25", "limit_um = 0/0", "10: field 'limit_um' must be a finite number"},
        Mistake{"limit_um = 25", "limit_um = { 25 }",
                "10: field 'limit_um' must be a finite number, a text or true/false, not a table"},
        Mistake{"limit_um = 25", "limit_mm = 0.025",
                "10: field 'limit_mm' is in mm, but what the rule needs is in um: give the limit in um"},
        Mistake{"limit_um = 25", "limit = 25", "10: field 'limit' has no unit: call it limit_um, say"},
        Mistake{
            "limit_um = 25", "limit_um = 25, baseline = \"last\"",
            "10: baseline must be \"series\", \"calibration\", \"first\" or \"series NAME\", not \"last\""},
        Mistake{"limit_um = 25", "limit_um = 25, baseline_runs = 1",
                "10: baseline_runs must be a whole number from 2 to 100"},
        Mistake{"limit_um = 25", "limit_um = 25, noise_um = 1",
                "10: field 'noise_um' has the name of something that results have"},
        Mistake{"limit_um = 25", "limit_um = 25, 26", "2: the rule holds a value without a name"},
        Mistake{"limit_um = 25", "limit_um = 25 26", "10: '}' expected (to close '{' at line 2) near '26'"},
        Mistake{"limit_um = 25", "limit_um = limit", "10: unknown name 'limit'"},
        Mistake{"when = ", "wenn = ", "0: when must be given"},
        Mistake{"{limit_um}", "{limt_um}",
                "12: text: {limt_um} is no quantity, label, field of the rule or name in gives; did you mean "
                "'limit_um'?"},
        Mistake{"{limit_um}", "{limit_um", "12: text: braces enclose one name each"},
        Mistake{"text = \"{ovality_um} > {limit_um}\"", "text = nil", "12: text must be given"},
        Mistake{"limit_um = 25", "limit_um = 25, gives = { \"ovality_um\" }",
                "10: gives 'ovality_um', which every result already has"},
        Mistake{"return {", "local t = {", "0: the file must return a table, not nil"}));

TEST(ParseRule, KnowsHarmonicsAndTheNamesOfBothKinds) {
  EXPECT_EQ(parse(rule_with("\"ovality_um\"", "\"ovality_um\", \"harmonic3_cos_um\", \"payload_kg\"")),
            "fine");
}

TEST(ParseRule, RefusesFilesLongerThan64KiB) {
  EXPECT_EQ(parse(rule_with("return", std::string(kMaxRuleBytes, ' ') + "return")),
            "0: the file is longer than 64 KiB");
}

TEST(ParseRule, AnEndlessLoopInTheFileEnds) {
  EXPECT_EQ(parse(rule_with("return", "while true do end return")),
            "2: over the instruction budget of 1000000: endless loop?");
}

}  // namespace
}  // namespace ballbar
