#pragma once
/// One rule = one Lua file. It says only whether a condition holds for a result; the alarm machine keeps the
/// state.
///
///     return {
///       name = "ovality_high",            -- [a-z0-9_]+, no other rule has it
///       on = "circle",                    -- which results it is asked about: see below
///       needs = { "ovality_um" },         -- quantities without which it cannot say anything
///       where = { test = "A" },           -- optional: only these robot, test, series, axis, source,
///       direction,
///                                         -- payload_kg (within 10 g)
///       hold_runs = 2,                    -- bad runs in a row until pending becomes firing (1)
///       keep_runs = 1,                    -- clean runs in a row that firing outlasts (1)
///       hold_s = 0, keep_s = 0,           -- and seconds that the bad runs, the clean runs must span (0)
///       flap_fires = 3, flap_runs = 20,   -- flapping: began to fire 3 times within 20 runs (flap_fires 0:
///       never) severity = "warning",             -- or "info", "critical" baseline = "series", -- or
///       "calibration", "first", "series NAME": whose first baseline_runs = 10,               -- so many
///       results the functions of `history` compare with limit_um = 150.0,                 -- any further
///       numbers, words and true/false are the rule's own gives = { "over_um" },            -- optional:
///       numbers that `when` returns in a table, for the text when = function(result, history, rule)
///         return result.ovality_um > rule.limit_um, { over_um = result.ovality_um - rule.limit_um }
///       end,
///       text = "ovality {ovality_um} um is {over_um} um above {limit_um} um",
///     }
///
/// `on` is one of kSubjects in names.hpp: "circle" and "line" as they are measured; "test", a circle in both
/// directions; "residual", measured minus predicted of a circle or line; "silence" and "loss", made by the
/// service's clock; "gap", a diagnosis.
///
/// `result` holds the labels (names.hpp) and every quantity of the run by its name with unit; a quantity that
/// this run does not have is nil, a name that no run can have is an error. `history` answers questions about
/// earlier results of the same robot, test, direction, axis and source: lua_history.hpp. `rule` is the table
/// itself. Results of the virtual ballbar are shown only to rules that ask for them: where = { source =
/// "joints" }. A rule keeps nothing between two calls: each starts from its text.

#include <cstddef>
#include <map>
#include <memory>
#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "core/alarm.hpp"
#include "core/past.hpp"
#include "core/result.hpp"

namespace ballbar {

inline constexpr std::size_t kMaxRuleBytes = std::size_t{64} << 10;  ///< of one file
inline constexpr std::size_t kHistoryFirst =
    20;  ///< of History::series_first, the oldest, are shown to a rule
inline constexpr std::size_t kHistoryRecent = 50;  ///< of History::recent, the newest, are shown to a rule
inline constexpr const char* kVirtualSource = "joints";  ///< Record::source of a virtual ballbar
inline constexpr int kMaxRuns = 1000;                    ///< the largest hold_runs and keep_runs
inline constexpr double kMaxDelay = 366.0 * 86'400.0;    ///< [s] the largest hold_s and keep_s
inline constexpr const char* kOwnRules = "ballbard_";    ///< names of alarms about ballbard itself begin so

class Script;

struct RuleSource {
  std::string file;  ///< its name without folder
  std::string text;
};

/// Which results a rule is asked about, beside their kind. Absent = all.
struct RuleFilter {
  std::map<std::string, std::string> labels;  ///< robot, test, series, axis, source
  std::optional<double> payload_kg;
  std::optional<int> direction;
};

/// A rule that was loaded and found well formed.
struct Rule {
  std::string name;
  std::string kind;  ///< "circle" or "line"; `on` in the file
  std::vector<std::string> needs;
  std::vector<std::string> gives;
  RuleFilter where;
  int hold_runs = 1;
  int keep_runs = 1;
  double hold_s = 0.0, keep_s = 0.0;   ///< [s]
  int flap_fires = 3, flap_runs = 20;  ///< as in AlarmDelays
  std::string severity = "warning";
  std::string text;
  std::map<std::string, std::variant<double, std::string, bool>> fields;  ///< the rule's own
  std::string baseline = "series";  ///< window of core/past.hpp whose first results are the baseline
  int baseline_runs = 10;
  RuleSource source;
  std::shared_ptr<Script> script;  ///< the compiled source: saves time, holds no state
};

/// What a rule says of one result.
struct Judgement {
  bool bad = false;
  std::string text;                     ///< filled in where bad, else empty
  std::vector<AlarmNumber> numbers;     ///< where bad: needs, what the text shows, gives, numbers of the rule
  std::map<std::string, double> given;  ///< the numbers that `gives` names, where `when` returned them
};

/// Loads a rule from its text.
/// @throws ScriptError with the line, where it can be named
Rule parse_rule(RuleSource source);

/// True where the rule is asked about this result. Results whose status is not "ok" are not shown to rules.
bool applies(const Rule& rule, const Record& record);

/// Asks a rule about a result.
/// @throws ScriptError where it cannot say: a needed quantity is missing or not finite, an error in the
/// script, over budget
Judgement judge(const Rule& rule, const Record& record, Past& past);

/// The same with a history in memory; results in it whose status is not "ok" are left out.
Judgement judge(const Rule& rule, const Record& record, const History& history);

}  // namespace ballbar
