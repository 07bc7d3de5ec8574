#include "rules/rule_set.hpp"

#include <algorithm>
#include <optional>
#include <set>

#include "core/error.hpp"
#include "rules/past_records.hpp"
#include "rules/rule_files.hpp"
#include "rules/sandbox.hpp"

namespace ballbar {
namespace {

AlarmKey key_of(const Rule& rule, const Record& record) {
  return {rule.name, record.robot, record.test, record.direction, record.axis};
}

AlarmStatus status_of(const AlarmKey& key, const std::vector<AlarmStatus>& states, std::int64_t ended_us) {
  const auto found =
      std::find_if(states.begin(), states.end(), [&](const AlarmStatus& s) { return s.key == key; });
  if (found != states.end()) return *found;
  AlarmStatus fresh;
  fresh.key = key;
  fresh.since_us = ended_us;
  return fresh;
}

void explain(AlarmStatus& alarm, const Judgement& judgement, const Record& record) {
  alarm.text = judgement.text;
  alarm.numbers = judgement.numbers;
  if (alarm.bad_runs == 1) alarm.runs.clear();
  if (alarm.runs.size() >= kAlarmRuns) alarm.runs.erase(alarm.runs.begin());
  alarm.runs.push_back(record.started_us);
}

const Rule* rule_of_file(const RuleSet* set, const std::string& file) {
  if (set == nullptr) return nullptr;
  for (const Rule& rule : set->rules())
    if (rule.source.file == file) return &rule;
  return nullptr;
}

void check_unused(const Rule& rule, const std::vector<Rule>& earlier) {
  for (const Rule& other : earlier) {
    if (other.name == rule.name)
      throw ScriptError(0, "name '" + rule.name + "' is already taken by " + other.source.file);
  }
  if (earlier.size() >= kMaxRules) throw ScriptError(0, "more than " + std::to_string(kMaxRules) + " rules");
}

// Loads each source by itself; one that fails is reported, and its last good version stays.
class Loader {
 public:
  explicit Loader(const RuleSet* last_good) : last_good_(last_good) {}

  void add(const RuleSource& source) {
    try {
      Rule rule = parse_rule(source);
      check_unused(rule, rules);
      rules.push_back(std::move(rule));
    } catch (const ScriptError& error) {
      refuse(source.file, error);
    }
  }

  void refuse(const std::string& file, const ScriptError& error) {
    const Rule* last = rule_of_file(last_good_, file);
    errors.push_back({last != nullptr ? last->name : "", file, error.line(), error.what()});
    if (last == nullptr) return;
    try {
      check_unused(*last, rules);
      rules.push_back(*last);
      kept.push_back(file);
    } catch (const ScriptError& also) {
      errors.push_back(
          {last->name, file, 0, std::string("its last good version cannot stay: ") + also.what()});
    }
  }

  std::vector<Rule> rules;
  std::vector<RuleError> errors;
  std::vector<std::string> kept;

 private:
  const RuleSet* last_good_;
};

}  // namespace

AlarmDelays delays_of(const Rule& rule) {
  return {rule.hold_runs, rule.keep_runs, rule.hold_s, rule.keep_s, rule.flap_fires, rule.flap_runs};
}

std::string to_string(const RuleError& error) {
  const std::string line = error.line > 0 ? ":" + std::to_string(error.line) : "";
  return error.file + line + ": " + error.message;
}

LoadReport RuleSet::load(const std::filesystem::path& directory, const RuleSet* last_good) {
  return load_folders({directory}, last_good);
}

LoadReport RuleSet::load_folders(const std::vector<std::filesystem::path>& directories,
                                 const RuleSet* last_good) {
  Loader loader(last_good);
  for (const std::filesystem::path& path : rule_files(directories)) {
    try {
      loader.add(read_rule_file(path));
    } catch (const Error& error) {
      loader.refuse(path.filename().string(), ScriptError(0, error.what()));
    }
  }
  RuleSet set;
  set.rules_ = std::move(loader.rules);
  return {std::move(set), std::move(loader.errors), std::move(loader.kept)};
}

LoadReport RuleSet::load(const std::vector<RuleSource>& sources, const RuleSet* last_good) {
  Loader loader(last_good);
  for (const RuleSource& source : sources) loader.add(source);
  RuleSet set;
  set.rules_ = std::move(loader.rules);
  return {std::move(set), std::move(loader.errors), std::move(loader.kept)};
}

EvaluateResult RuleSet::evaluate(const Record& record, const History& history,
                                 const std::vector<AlarmStatus>& states, std::int64_t ended_us) const {
  PastRecords past(record, history);
  return evaluate(record, past, states, ended_us);
}

EvaluateResult RuleSet::evaluate(const Record& record, Past& past, const std::vector<AlarmStatus>& states,
                                 std::int64_t ended_us) const {
  EvaluateResult result;
  for (const Rule& rule : rules_) {
    if (!applies(rule, record)) continue;
    Judgement judgement;
    try {
      judgement = judge(rule, record, past);
    } catch (const ScriptError& error) {
      result.errors.push_back({rule.name, rule.source.file, error.line(), error.what()});
      continue;
    }
    const AlarmStatus before = status_of(key_of(rule, record), states, ended_us);
    AlarmStatus after = advance(before, judgement.bad, delays_of(rule), ended_us);
    after.severity = rule.severity;
    if (judgement.bad) explain(after, judgement, record);  // a clean run leaves what the last bad one said
    if (after.state != before.state) result.events.push_back({after, before.state, record.started_us});
    result.statuses.push_back(std::move(after));
  }
  return result;
}

std::vector<AlarmEvent> RuleSet::retire(const std::vector<AlarmStatus>& states, std::int64_t at_us) const {
  std::set<std::string> names;
  for (const Rule& rule : rules_) names.insert(rule.name);
  std::vector<AlarmEvent> events;
  for (const AlarmStatus& before : states) {
    if (before.state == AlarmState::kInactive || names.count(before.key.rule) != 0 ||
        before.key.rule.starts_with(kOwnRules))
      continue;
    AlarmEvent event{before, before.state, 0};
    event.status.state = AlarmState::kInactive;
    event.status.since_us = at_us;
    event.status.bad_runs = 0;
    event.status.clean_runs = 0;
    event.status.fires = 0;
    event.status.flapping = false;
    event.status.acknowledged = {};
    events.push_back(std::move(event));
  }
  return events;
}

}  // namespace ballbar
