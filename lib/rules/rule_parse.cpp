#include <algorithm>
#include <lua.hpp>
#include <set>
#include <stdexcept>

#include "rules/alarm_machine.hpp"
#include "rules/lua_table.hpp"
#include "rules/names.hpp"
#include "rules/rule.hpp"
#include "rules/sandbox.hpp"
#include "rules/text.hpp"

namespace ballbar {
namespace {

constexpr std::size_t kMaxText = 400;  // [bytes] of a text before it is filled in
constexpr std::size_t kMaxName = 64;   // [bytes]

const std::vector<std::string_view>& keys() {
  static const std::vector<std::string_view> known{
      "name",       "on",        "needs",    "when", "hold_runs", "keep_runs", "hold_s",   "keep_s",
      "flap_fires", "flap_runs", "severity", "text", "where",     "gives",     "baseline", "baseline_runs"};
  return known;
}

bool is_name(const std::string& word) {
  return !word.empty() && word.size() <= kMaxName &&
         word.find_first_not_of("abcdefghijklmnopqrstuvwxyz0123456789_") == std::string::npos;
}

std::string one_of(const LuaTable& table, const char* key, const std::vector<std::string>& allowed,
                   const std::string& otherwise) {
  std::string value = table.word(key).value_or(otherwise);
  if (std::find(allowed.begin(), allowed.end(), value) != allowed.end()) return value;
  std::string message = std::string(key) + " must be one of";
  for (const std::string& word : allowed) message += " \"" + word + "\"";
  table.fail(key, message + (value.empty() ? "" : ", not \"" + value + "\""));
}

double seconds(const LuaTable& table, const char* key) {
  lua_State* lua = table.lua();
  const int type = lua_getfield(lua, 1, key);
  const double value = type == LUA_TNUMBER ? lua_tonumber(lua, -1) : type == LUA_TNIL ? 0.0 : -1.0;
  lua_pop(lua, 1);
  if (!(value >= 0.0 && value <= kMaxDelay))
    table.fail(key, std::string(key) + " must be a number of seconds, 0 to 366 days: " + key + " = 8 * 3600");
  return value;
}

void read_delays(const LuaTable& table, Rule& rule) {
  rule.hold_s = seconds(table, "hold_s");
  rule.keep_s = seconds(table, "keep_s");
  rule.flap_fires = table.whole_number("flap_fires", 0, kMaxFlapRuns).value_or(rule.flap_fires);
  rule.flap_runs = table.whole_number("flap_runs", 1, kMaxFlapRuns).value_or(rule.flap_runs);
}

void read_baseline(const LuaTable& table, Rule& rule) {
  constexpr int kLeast = 2;
  rule.baseline = table.word("baseline").value_or("series");
  rule.baseline_runs = table.whole_number("baseline_runs", kLeast, static_cast<int>(kPastFirst)).value_or(10);
  const bool known = rule.baseline == "series" || rule.baseline == "calibration" ||
                     rule.baseline == "first" ||
                     (rule.baseline.starts_with("series ") && rule.baseline.size() > sizeof "series");
  if (!known)
    table.fail("baseline",
               "baseline must be \"series\", \"calibration\", \"first\" or \"series NAME\", not \"" +
                   rule.baseline + "\"");
}

[[noreturn]] void fail_unit(const LuaTable& table, const std::string& name, const std::string& unit,
                            const std::string& needed) {
  table.fail(name, "field '" + name + "' is in " + unit + ", but what the rule needs is in " + needed +
                       ": give the limit in " + needed);
}

/// A limit in mm beside needs in um would be a thousand times too wide, and nobody would ever hear of it.
void check_units(const LuaTable& table, const Rule& rule) {
  static const std::vector<std::string> lengths{"um", "mm", "m"};
  std::set<std::string> units;
  for (const std::string& name : rule.needs) units.insert(name.substr(name.rfind('_') + 1));
  for (const auto& [name, value] : rule.fields) {
    const std::string unit = name.substr(name.rfind('_') + 1);
    const bool is_limit = name.starts_with("limit") && std::holds_alternative<double>(value);
    if (!is_limit || units.empty() || units.contains(unit)) continue;
    const bool is_length = std::find(lengths.begin(), lengths.end(), unit) != lengths.end();
    const auto other = std::find_if(lengths.begin(), lengths.end(),
                                    [&](const std::string& length) { return units.contains(length); });
    if (is_length && other != lengths.end()) fail_unit(table, name, unit, *other);
    if (name == "limit")
      table.fail(name, "field 'limit' has no unit: call it limit_" + *units.begin() + ", say");
  }
}

void read_names(const LuaTable& table, Rule& rule) {
  rule.name = table.word("name").value_or("");
  if (!is_name(rule.name))
    table.fail("name", "name must be given, and be of small letters, digits and _: name = \"ovality_high\"");
  if (rule.name.starts_with(kOwnRules))
    table.fail("name",
               std::string("names that begin with ") + kOwnRules + " are of alarms about ballbard itself");
  rule.kind = one_of(table, "on", subjects(), "");
  rule.severity = one_of(table, "severity", {"info", "warning", "critical"}, "warning");
  rule.hold_runs = table.whole_number("hold_runs", 1, kMaxRuns).value_or(1);
  rule.keep_runs = table.whole_number("keep_runs", 0, kMaxRuns).value_or(1);
  read_delays(table, rule);

  rule.needs = table.list_of_words("needs");
  for (const std::string& name : rule.needs) {
    if (!is_quantity_of(name, rule.kind))
      table.fail(
          name, "needs '" + name + "', which is no quantity of a " + rule.kind + suggestion(name, rule.kind));
  }
  read_baseline(table, rule);
  rule.gives = table.list_of_words("gives");
  for (const std::string& name : rule.gives) {
    if (!is_name(name)) table.fail("gives", "gives '" + name + "': names are of small letters, digits and _");
    if (is_label(name) || is_quantity_of(name, rule.kind))
      table.fail("gives", "gives '" + name + "', which every result already has: choose another name");
  }
  if (!table.has_function("when"))
    table.fail("when", "when must be given: when = function(result, history, rule) return ... end");
}

void read_where(const LuaTable& table, Rule& rule) {
  lua_State* lua = table.lua();
  const int type = lua_getfield(lua, 1, "where");
  if (type != LUA_TNIL && type != LUA_TTABLE)
    table.fail("where", "where must be a table: where = { test = \"A\" }");
  if (type == LUA_TTABLE) {
    table.each(-1, "where", [&](const std::string& key) {
      const auto value = table.constant();
      if (key == "direction") {
        const double* number = value ? std::get_if<double>(&*value) : nullptr;
        if (number == nullptr || (*number != 1.0 && *number != -1.0 && *number != 0.0))
          table.fail("where", "where.direction must be 1, -1 or 0");
        rule.where.direction = static_cast<int>(*number);
        return;
      }
      if (key == "payload_kg") {
        const double* number = value ? std::get_if<double>(&*value) : nullptr;
        if (number == nullptr || *number < 0.0)
          table.fail("where", "where.payload_kg must be a number of kg");
        rule.where.payload_kg = *number;
        return;
      }
      if (key != "robot" && key != "test" && key != "series" && key != "axis" && key != "source")
        table.fail("where", "where knows robot, test, series, axis, source, direction and payload_kg, not '" +
                                key + "'");
      const std::string* word = value ? std::get_if<std::string>(&*value) : nullptr;
      if (word == nullptr) table.fail("where", "where." + key + " must be a text in quotes");
      if (key == "source" && *word != "bar" && *word != kVirtualSource && *word != "interferometer")
        table.fail("where",
                   "where.source must be \"bar\", \"joints\" (virtual ballbar) or \"interferometer\"");
      rule.where.labels[key] = *word;
    });
  }
  lua_pop(lua, 1);
}

void read_own_fields(const LuaTable& table, Rule& rule) {
  table.each(1, "the rule", [&](const std::string& key) {
    if (std::find(keys().begin(), keys().end(), key) != keys().end()) return;
    // A misspelt key would silently leave the default in force. Only for the long ones: short words resemble
    // too much.
    const std::string meant =
        nearest(key, {"hold_runs", "keep_runs", "flap_fires", "flap_runs", "severity", "baseline_runs"}, 2);
    if (!meant.empty()) table.fail(key, "unknown key '" + key + "'" + did_you_mean(meant));
    if (is_label(key) || is_quantity_of(key, rule.kind))
      table.fail(key,
                 "field '" + key +
                     "' has the name of something that results have: choose another (filters go into where)");
    const auto value = table.constant();
    if (!value) {
      table.fail(key, "field '" + key + "' must be a finite number, a text or true/false, not a " +
                          luaL_typename(table.lua(), -1) + " (helpers go above the return, as local)");
    }
    rule.fields[key] = *value;
  });
}

void read_text(const LuaTable& table, Rule& rule) {
  rule.text = table.word("text").value_or("");
  if (rule.text.empty() || rule.text.size() > kMaxText)
    table.fail("text", "text must be given, with at most " + std::to_string(kMaxText) + " letters");
  std::vector<std::string> names;
  try {
    names = placeholders(rule.text);
  } catch (const std::invalid_argument& error) {
    table.fail("text", std::string("text: ") + error.what());
  }
  std::vector<std::string_view> own(rule.gives.begin(), rule.gives.end());
  for (const auto& [name, value] : rule.fields) own.emplace_back(name);
  for (const std::string& name : names) {
    if (is_label(name) || is_quantity_of(name, rule.kind) ||
        std::find(own.begin(), own.end(), name) != own.end())
      continue;
    table.fail(name, "text: {" + name + "} is no quantity, label, field of the rule or name in gives" +
                         suggestion(name, rule.kind, own));
  }
}

}  // namespace

Rule parse_rule(RuleSource source) {
  if (source.text.size() > kMaxRuleBytes) throw ScriptError(0, "the file is longer than 64 KiB");
  Rule rule;
  rule.source = std::move(source);
  rule.script = std::make_shared<Script>(rule.source.text);
  rule.script->run([&](lua_State* lua) {
    const LuaTable table(lua, rule.source);
    read_names(table, rule);
    read_where(table, rule);
    read_own_fields(table, rule);
    check_units(table, rule);
    read_text(table, rule);
  });
  return rule;
}

}  // namespace ballbar
