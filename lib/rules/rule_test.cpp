#include "rules/rule_test.hpp"

#include <algorithm>
#include <cmath>
#include <lua.hpp>
#include <map>
#include <optional>

#include "core/error.hpp"
#include "rules/lua_table.hpp"
#include "rules/names.hpp"
#include "rules/past_records.hpp"
#include "rules/rule_files.hpp"
#include "rules/sandbox.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kRowUs = 60'000'000;  // one run a minute, each of half a minute
constexpr std::int64_t kRunUs = 30'000'000;

using Fields = std::map<std::string, std::variant<double, std::string, bool>>;

struct Row {
  Fields fields;
  std::string expect;
  int line = 0;
  bool calibrated = false;
};

struct Table {
  std::string rule_file;
  std::vector<Row> rows;
};

Row read_row(const LuaTable& table, int number) {
  const std::string name = "row " + std::to_string(number);
  Row row;
  if (lua_type(table.lua(), -1) != LUA_TTABLE)
    table.fail("return", name + " must be a table: { ..., expect = \"firing\" }");
  table.each(-1, name.c_str(), [&](const std::string& key) {
    const auto value = table.constant();
    if (!value) table.fail(key, name + ": " + key + " must be a finite number or a text");
    row.fields[key] = *value;
  });
  const auto found = row.fields.find("expect");
  const std::string* expect = found != row.fields.end() ? std::get_if<std::string>(&found->second) : nullptr;
  static const std::vector<std::string> words{"inactive", "pending", "firing", "resolved", "error"};
  if (expect == nullptr || std::find(words.begin(), words.end(), *expect) == words.end())
    table.fail("expect", name + ": expect must be inactive, pending, firing, resolved or error");
  row.expect = *expect;
  row.fields.erase(found);
  if (const auto mark = row.fields.find("calibrated"); mark != row.fields.end()) {
    const bool* yes = std::get_if<bool>(&mark->second);
    if (yes == nullptr) table.fail("calibrated", name + ": calibrated must be true or false");
    row.calibrated = *yes;
    row.fields.erase(mark);
  }
  return row;
}

Table read_table(const RuleSource& source) {
  Table table;
  run_sandboxed(source.text, [&](lua_State* lua) {
    const LuaTable reader(lua, source);
    table.rule_file = reader.word("rule").value_or("");
    if (table.rule_file.empty() || table.rule_file.find('/') != std::string::npos)
      reader.fail("rule", "rule must name the rule's file, without a folder: rule = \"ovality_high.lua\"");
    const auto size = static_cast<int>(lua_rawlen(lua, 1));
    int entries = 0;
    for (lua_pushnil(lua); lua_next(lua, 1) != 0; lua_pop(lua, 1)) ++entries;
    if (size == 0 || entries != size + 1)
      reader.fail("return", "a table holds rule = \"...\", at least one row, and nothing else");
    for (int i = 1; i <= size; ++i) {
      lua_rawgeti(lua, 1, i);
      table.rows.push_back(read_row(reader, i));
      lua_pop(lua, 1);
    }
  });
  // Lua forgets where a row stood. Where each row is written out, the n-th `expect` is the n-th row's.
  const std::vector<int> lines = lines_with(source.text, "expect");
  if (lines.size() == table.rows.size())
    for (std::size_t i = 0; i < lines.size(); ++i) table.rows[i].line = lines[i];
  return table;
}

bool is_word_of_gap(const std::string& name) {
  return name == "verdict" || name == "effect" || name == "effect_kind";
}

// Sets one label or quantity; false where the name or the type is wrong.
bool set_field(Record& record, const std::string& name,
               const std::variant<double, std::string, bool>& value) {
  const std::map<std::string, std::string*> words{{"robot", &record.robot},
                                                  {"test", &record.test},
                                                  {"series", &record.series},
                                                  {"axis", &record.axis},
                                                  {"status", &record.status},
                                                  {"angle_source", &record.angle_source},
                                                  {"source", &record.source},
                                                  {"verdict", &record.words["verdict"]},
                                                  {"effect", &record.words["effect"]},
                                                  {"effect_kind", &record.words["effect_kind"]}};
  if (record.kind != "gap") record.words.clear();
  if (is_word_of_gap(name) && record.kind != "gap") return false;
  if (const auto label = words.find(name); label != words.end()) {
    const std::string* word = std::get_if<std::string>(&value);
    if (word != nullptr) *label->second = *word;
    return word != nullptr;
  }
  const double* number = std::get_if<double>(&value);
  if (number == nullptr) return false;
  if (name == "direction" || name == "repetition") {
    if (*number != std::trunc(*number) || std::abs(*number) > 1e6) return false;
    (name == "direction" ? record.direction : record.repetition) = static_cast<int>(*number);
    return true;
  }
  record.values[name] = {*number, std::nullopt};
  return is_quantity_of(name, record.kind);
}

Record make_record(const Row& row, int number, const std::string& kind) {
  Record record;
  record.kind = kind;
  const bool is_run = kind != "silence" && kind != "loss" && kind != "gap";
  record.robot = "test";
  if (is_run || kind == "silence") record.test = kind == "line" ? "Y" : "A";
  record.axis = kind == "line" ? "X" : "";
  if (is_run) record.source = kind == "line" ? "interferometer" : "bar";
  record.series = "s";
  record.status = "ok";
  record.direction = is_run && kind != "test" ? 1 : 0;
  record.repetition = number;
  record.started_us = number * kRowUs;
  for (const auto& [name, value] : row.fields) {
    if (!set_field(record, name, value)) {
      std::string message = "row " + std::to_string(number) + ": " + name;
      message += " is no quantity or label of a " + kind + ", or of the wrong type" + suggestion(name, kind);
      throw ScriptError(row.line, message);
    }
  }
  if (kind == "gap" && !record.words["effect"].empty()) {  // one row, one finding
    Record part = record;
    record.parts.push_back(std::move(part));
  }
  return record;
}

void remember(std::vector<AlarmStatus>& states, const AlarmStatus& status) {
  const auto same =
      std::find_if(states.begin(), states.end(), [&](const AlarmStatus& s) { return s.key == status.key; });
  if (same != states.end()) {
    *same = status;
  } else {
    states.push_back(status);
  }
}

// What one row comes to: a state's name, "error", and the message where it is an error.
struct Outcome {
  std::string word = "inactive";
  std::string message;
};

Outcome feed(const RuleSet& rules, const Record& record, const std::vector<Record>& earlier,
             const std::vector<std::int64_t>& marks_us, std::vector<AlarmStatus>& states) {
  PastRecords past(record, earlier, marks_us);
  const EvaluateResult result = rules.evaluate(record, past, states, record.started_us + kRunUs);
  if (!result.errors.empty()) return {"error", " (" + to_string(result.errors.front()) + ")"};
  for (const AlarmStatus& status : result.statuses) remember(states, status);
  const AlarmKey key{rules.rules().front().name, record.robot, record.test, record.direction, record.axis};
  for (const AlarmStatus& status : states)
    if (status.key == key) return {to_string(status.state), ""};
  return {};
}

void run_rows(const Table& table, const RuleSet& rules, RuleTestReport& report) {
  std::vector<Record> earlier;
  std::vector<std::int64_t> marks_us;
  std::vector<AlarmStatus> states;
  for (const Row& row : table.rows) {
    const int number = ++report.rows;
    const Record record = make_record(row, number, rules.rules().front().kind);
    if (row.calibrated) marks_us.push_back(record.started_us);
    const Outcome outcome = feed(rules, record, earlier, marks_us, states);
    if (outcome.word != row.expect) {
      report.failures.push_back({rules.rules().front().name, report.file, row.line,
                                 "row " + std::to_string(number) + ": expected " + row.expect + ", got " +
                                     outcome.word + outcome.message});
    }
    earlier.push_back(record);
  }
}

// Runs `test`, whose ScriptErrors are failures of the table.
template <typename Test>
RuleTestReport report_of(const std::string& file, Test test) {
  RuleTestReport report;
  report.file = file;
  try {
    test(report);
  } catch (const ScriptError& error) {
    report.failures.push_back({"", file, error.line(), error.what()});
  }
  return report;
}

void run_table(const Table& table, const RuleSource& rule, RuleTestReport& report) {
  const LoadReport loaded = RuleSet::load({rule});
  report.failures = loaded.errors;
  if (loaded.errors.empty()) run_rows(table, loaded.rules, report);
}

}  // namespace

RuleTestReport run_rule_test(const RuleSource& table, const RuleSource& rule) {
  return report_of(table.file, [&](RuleTestReport& report) { run_table(read_table(table), rule, report); });
}

RuleTestReport run_rule_test(const std::filesystem::path& test_file) {
  const RuleSource source = read_rule_file(test_file);
  return report_of(source.file, [&](RuleTestReport& report) {
    const Table table = read_table(source);
    try {
      run_table(table, read_rule_file(test_file.parent_path() / table.rule_file), report);
    } catch (const Error& error) {
      throw ScriptError(line_of(source.text, "rule"), table.rule_file + ": " + error.what());
    }
  });
}

}  // namespace ballbar
