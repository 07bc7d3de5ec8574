#include <algorithm>
#include <cmath>
#include <lua.hpp>

#include "rules/lua_history.hpp"
#include "rules/lua_record.hpp"
#include "rules/names.hpp"
#include "rules/past_records.hpp"
#include "rules/rule.hpp"
#include "rules/sandbox.hpp"
#include "rules/text.hpp"

namespace ballbar {
namespace {

using Numbers = std::map<std::string, double>;

void check_needs(const Rule& rule, const Record& record) {
  for (const std::string& name : rule.needs) {
    const auto found = record.values.find(name);
    if (found != record.values.end() && std::isfinite(found->second.value)) continue;
    throw ScriptError(line_of(rule.source.text, name),
                      found == record.values.end() ? "needs '" + name + "', which this run does not have"
                                                   : "needs '" + name + "', which is not finite in this run");
  }
}

// The numbers that `when` gave beside its answer, in the table at stack index `index`.
Numbers read_gives(lua_State* lua, int index, const Rule& rule) {
  const int line = line_of(rule.source.text, "when");
  Numbers numbers;
  if (rule.gives.empty()) return numbers;
  if (lua_type(lua, index) != LUA_TTABLE)
    throw ScriptError(line, "when must return a table with '" + rule.gives.front() +
                                "' as its second value, as gives says");
  for (const std::string& name : rule.gives) {
    const bool is_number = lua_getfield(lua, index, name.c_str()) == LUA_TNUMBER;
    const double value = is_number ? lua_tonumber(lua, -1) : 0.0;
    lua_pop(lua, 1);
    if (!is_number || !std::isfinite(value))
      throw ScriptError(line,
                        "when must return a finite number '" + name + "' in its second value, as gives says");
    numbers[name] = value;
  }
  return numbers;
}

// Beside a "false" they need not be there: nobody fills in a text then.
void read_gives_if_there(lua_State* lua, const Rule& rule, Numbers& numbers) {
  try {
    numbers = read_gives(lua, lua_gettop(lua), rule);
  } catch (const ScriptError&) {
    numbers.clear();
  }
}

std::string constant_text(const std::variant<double, std::string, bool>& value) {
  if (const double* number = std::get_if<double>(&value)) return short_number(*number);
  if (const std::string* word = std::get_if<std::string>(&value)) return *word;
  return std::get<bool>(value) ? "yes" : "no";
}

std::string value_of(const std::string& name, const Rule& rule, const Record& record, const Numbers& given) {
  if (const auto it = given.find(name); it != given.end()) return short_number(it->second);
  if (const auto it = rule.fields.find(name); it != rule.fields.end()) return constant_text(it->second);
  if (const auto it = record.values.find(name); it != record.values.end())
    return short_number(it->second.value);
  return is_label(name) ? label_text(record, name) : "(not known)";
}

std::vector<AlarmNumber> numbers_of(const Rule& rule, const Record& record, const Numbers& given) {
  std::vector<AlarmNumber> numbers;
  std::vector<std::string> names = rule.needs;
  for (std::string& name : placeholders(rule.text)) names.push_back(std::move(name));
  for (const std::string& name : names) {
    const auto found = record.values.find(name);
    const bool there = std::any_of(numbers.begin(), numbers.end(),
                                   [&](const AlarmNumber& number) { return number.name == name; });
    if (found != record.values.end() && std::isfinite(found->second.value) && !there)
      numbers.push_back({name, found->second.value, found->second.sd, false});
  }
  for (const auto& [name, value] : given) numbers.push_back({name, value, {}, false});
  for (const auto& [name, field] : rule.fields)
    if (const double* value = std::get_if<double>(&field)) numbers.push_back({name, *value, {}, true});
  if (numbers.size() > kAlarmNumbers) numbers.resize(kAlarmNumbers);
  return numbers;
}

}  // namespace

bool applies(const Rule& rule, const Record& record) {
  // A limit written for the instrument says nothing about what the controller believes. So each alarm is of
  // one source, and needs none in its key.
  if (record.source == kVirtualSource && !rule.where.labels.contains("source")) return false;
  if (record.status != "ok" || record.kind != rule.kind) return false;
  if (rule.where.direction && *rule.where.direction != record.direction) return false;
  if (rule.where.payload_kg) {
    constexpr double kSame = 0.01;  // [kg]
    const auto payload = record.values.find("payload_kg");
    if (payload == record.values.end() || std::abs(payload->second.value - *rule.where.payload_kg) > kSame)
      return false;
  }
  return std::all_of(rule.where.labels.begin(), rule.where.labels.end(),
                     [&](const auto& wanted) { return label_text(record, wanted.first) == wanted.second; });
}

Judgement judge(const Rule& rule, const Record& record, Past& past) {
  check_needs(rule, record);
  Judgement judgement;
  Asked asked{rule, record, past, nullptr};
  try {
    rule.script->run([&](lua_State* lua) {
      if (lua_type(lua, 1) != LUA_TTABLE) throw ScriptError(0, "the file returns a table only sometimes");
      if (lua_getfield(lua, 1, "when") != LUA_TFUNCTION)
        throw ScriptError(0, "the file gives when only sometimes");
      push_record(lua, record);
      push_history(lua, asked);
      lua_pushvalue(lua, 1);
      refuse_unknown_fields(lua);
      lua_call(lua, 3, 2);
      if (lua_type(lua, -2) != LUA_TBOOLEAN) {
        throw ScriptError(line_of(rule.source.text, "when"),
                          std::string("when must return true or false, not ") + luaL_typename(lua, -2));
      }
      judgement.bad = lua_toboolean(lua, -2) != 0;
      if (!judgement.bad) return read_gives_if_there(lua, rule, judgement.given);
      judgement.given = read_gives(lua, lua_gettop(lua), rule);
      judgement.numbers = numbers_of(rule, record, judgement.given);
      judgement.text = fill(
          rule.text, [&](const std::string& name) { return value_of(name, rule, record, judgement.given); });
    });
  } catch (const ScriptError&) {
    if (asked.failed) std::rethrow_exception(asked.failed);
    throw;
  }
  return judgement;
}

Judgement judge(const Rule& rule, const Record& record, const History& history) {
  PastRecords past(record, history);
  return judge(rule, record, past);
}

}  // namespace ballbar
