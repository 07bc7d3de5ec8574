#pragma once
/// Short ways to results and rules for the tests of rules/.

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/result.hpp"
#include "rules/past_records.hpp"
#include "rules/rule.hpp"
#include "rules/sandbox.hpp"

namespace ballbar::test {

inline Record circle(const std::map<std::string, double>& values) {
  Record record;
  record.robot = "r1";
  record.test = "A";
  record.kind = "circle";
  record.series = "s";
  record.status = "ok";
  record.direction = 1;
  record.repetition = 1;
  record.started_us = 1'000'000;
  for (const auto& [name, value] : values) record.values[name] = {value, std::nullopt};
  return record;
}

/// A rule file; `more` goes into the table and wins over what stands there already.
inline RuleSource rule_source(const std::string& name, const std::string& condition,
                              const std::string& more = "") {
  return {name + ".lua", "return { name = \"" + name +
                             "\", on = \"circle\", needs = { \"ovality_um\" },\n"
                             "when = function(result, history, rule) return " +
                             condition + " end,\ntext = \"ovality {ovality_um}\",\n" + more + "}\n"};
}

/// What comes of `work`: "fine", or "LINE: message" of its ScriptError.
template <typename Work>
std::string outcome(Work work) {
  try {
    work();
  } catch (const ScriptError& error) {
    return std::to_string(error.line()) + ": " + error.what();
  }
  return "fine";
}

inline constexpr std::int64_t kRecordDayUs = 86'400'000'000;

/// Circles a day apart with these ovalities; the last one is being judged.
inline std::vector<Record> days(const std::vector<double>& ovality_um) {
  std::vector<Record> records;
  for (std::size_t i = 0; i < ovality_um.size(); ++i) {
    records.push_back(circle({{"ovality_um", ovality_um[i]}}));
    records.back().started_us = static_cast<std::int64_t>(i + 1) * kRecordDayUs;
  }
  return records;
}

/// What an expression of a rule comes to, as text: three values.
/// @param more      goes into the rule's table
/// @param marks_us  times of calibrations
inline std::string value_of(const std::string& expression, const std::vector<Record>& records,
                            const std::string& more = "", const std::vector<std::int64_t>& marks_us = {}) {
  const Rule rule =
      parse_rule(rule_source("x",
                             "(function() local a, b, c = " + expression +
                                 " error(tostring(a) .. ' ' .. tostring(b) .. ' ' .. tostring(c), 0) end)()",
                             more));
  const Record now = records.back();
  PastRecords past(now, records, marks_us);
  const std::string said = outcome([&] { judge(rule, now, past); });
  return said.substr(said.find(' ') + 1);
}

}  // namespace ballbar::test
