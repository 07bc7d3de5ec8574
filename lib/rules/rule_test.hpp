#pragma once
/// Tests of rules, as tables that need no service and no database.
///
///     return { rule = "ovality_high.lua",
///       { ovality_um = 160.0, expect = "pending"  },   -- one bad run is not an alarm
///       { ovality_um = 155.0, expect = "firing"   },
///       {                     expect = "error"    },   -- a missing quantity is never silence
///     }
///
/// Each row is a result; they come one after another, and the earlier ones are the history of the later ones.
/// A row may set the labels robot ("test" where it does not), test ("A"; "Y" for lines), series ("s"), axis
/// ("X" for lines), direction (1; 0 where the rule is on both), repetition (the row's number), status ("ok"),
/// of a diagnosis verdict, effect and effect_kind, and any quantities. calibrated = true begins a new
/// baseline "calibration" with this row. A script may make its rows in a loop. `expect` is the state of the
/// row's alarm after it: inactive, pending, firing or resolved; or error where the rule cannot say.

#include <filesystem>
#include <string>
#include <vector>

#include "rules/rule_set.hpp"

namespace ballbar {

struct RuleTestReport {
  std::string file;  ///< the table's, without folder
  int rows = 0;      ///< that were judged
  std::vector<RuleError>
      failures;  ///< empty = passed; "row 3: expected firing, got pending", with the row's line where known
};

/// Runs a *_test.lua against the rule beside it. What is wrong with either file is a failure in the report.
/// @throws Error where the test file itself cannot be read
RuleTestReport run_rule_test(const std::filesystem::path& test_file);

/// The same from texts.
RuleTestReport run_rule_test(const RuleSource& table, const RuleSource& rule);

}  // namespace ballbar
