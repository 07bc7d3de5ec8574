#pragma once
/// Short ways to results and rules for the tests of rules/.

#include <map>
#include <string>
#include <utility>

#include "core/result.hpp"
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

}  // namespace ballbar::test
