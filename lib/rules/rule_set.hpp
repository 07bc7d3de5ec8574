#pragma once
/// All rules of a folder, and what they make of one result.

#include <cstdint>
#include <filesystem>
#include <string>
#include <vector>

#include "core/alarm.hpp"
#include "rules/alarm_machine.hpp"
#include "rules/rule.hpp"

namespace ballbar {

inline constexpr std::size_t kMaxRules = 200;

/// What is wrong with a rule, for people who edit it.
struct RuleError {
  std::string rule;  ///< its name; empty where it is not known
  std::string file;  ///< without folder
  int line = 0;      ///< from 1; 0 where none can be named
  std::string message;
  auto operator<=>(const RuleError&) const =
      default;  // NOLINT(modernize-use-nullptr): clang-tidy 14 mistakes it
};

/// How long bad and clean runs must go on until the rule's alarm moves.
AlarmDelays delays_of(const Rule& rule);

/// "ovality_high.lua:12: message"
std::string to_string(const RuleError& error);

struct EvaluateResult {
  std::vector<AlarmStatus> statuses;  ///< of every rule that judged the result, changed or not: to be stored
  std::vector<AlarmEvent> events;     ///< where a state changed
  std::vector<RuleError> errors;      ///< rules that could not say; their alarms stay as they were
};

struct LoadReport;

/// A value: copies are independent, evaluate changes nothing.
class RuleSet {
 public:
  /// Loads every *.lua of a folder that is not hidden and not a *_test.lua, by name.
  ///
  /// A file that cannot be loaded is reported and does not touch the others; where `last_good` holds a
  /// version of the same file, that one stays in use. Rules of files that are gone, go.
  ///
  /// @param last_good  the set in use until now, or null
  /// @throws Error where the folder cannot be read
  static LoadReport load(const std::filesystem::path& directory, const RuleSet* last_good = nullptr);

  /// The same of several folders, see rule_files().
  static LoadReport load_folders(const std::vector<std::filesystem::path>& directories,
                                 const RuleSet* last_good = nullptr);

  /// The same from texts, in the order given.
  static LoadReport load(const std::vector<RuleSource>& sources, const RuleSet* last_good = nullptr);

  /// Asks each rule that applies about a result, and moves its alarm. Results whose status is not "ok" move
  /// nothing.
  ///
  /// @param states    the alarms as they are; only those with the result's own keys are looked at
  /// @param ended_us  end of the run
  EvaluateResult evaluate(const Record& record, Past& past, const std::vector<AlarmStatus>& states,
                          std::int64_t ended_us) const;
  EvaluateResult evaluate(const Record& record, const History& history,
                          const std::vector<AlarmStatus>& states, std::int64_t ended_us) const;

  /// Alarms whose rule is no longer there: they go to inactive, since nothing could ever resolve them.
  /// @param at_us  when the rules were loaded
  std::vector<AlarmEvent> retire(const std::vector<AlarmStatus>& states, std::int64_t at_us) const;

  /// By file name. Their sources are all that is needed to load the set again (the last good set, across a
  /// restart).
  const std::vector<Rule>& rules() const { return rules_; }

 private:
  std::vector<Rule> rules_;
};

struct LoadReport {
  RuleSet rules;
  std::vector<RuleError> errors;
  std::vector<std::string> kept;  ///< files among the errors whose last good version stays in use
};

}  // namespace ballbar
