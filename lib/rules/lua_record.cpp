#include "rules/lua_record.hpp"

#include <algorithm>
#include <cmath>
#include <lua.hpp>
#include <string>

#include "rules/names.hpp"
#include "rules/rule.hpp"

namespace ballbar {
namespace {

// __index of a result: a quantity may be missing in a run, but a name that none can have is a mistake.
// Upvalue 1: the kind.
int missing_in_result(lua_State* lua) {
  const std::string name = luaL_tolstring(lua, 2, nullptr);
  const std::string kind = lua_tostring(lua, lua_upvalueindex(1));
  if (is_label(name) || is_quantity_of(name, kind)) {
    lua_pushnil(lua);
    return 1;
  }
  return luaL_error(lua, "a %s has no '%s'%s", kind.c_str(), name.c_str(), suggestion(name, kind).c_str());
}

int missing_in_rule(lua_State* lua) {
  return luaL_error(lua, "the rule has no '%s'", luaL_tolstring(lua, 2, nullptr));
}

void set_word(lua_State* lua, const char* key, const std::string& value) {
  lua_pushlstring(lua, value.data(), value.size());
  lua_setfield(lua, -2, key);
}

void set_integer(lua_State* lua, const char* key, lua_Integer value) {
  lua_pushinteger(lua, value);
  lua_setfield(lua, -2, key);
}

template <typename Iterator>
void push_array(lua_State* lua, Iterator begin, Iterator end) {
  lua_createtable(lua, static_cast<int>(end - begin), 0);
  lua_Integer index = 0;
  for (Iterator it = begin; it != end; ++it) {
    push_record(lua, **it);
    lua_rawseti(lua, -2, ++index);
  }
}

std::vector<const Record*> usable(const std::vector<Record>& records) {
  std::vector<const Record*> found;
  for (const Record& record : records)
    if (record.status == "ok") found.push_back(&record);
  return found;
}

}  // namespace

void push_record(lua_State* lua, const Record& record) {
  lua_createtable(lua, 0, static_cast<int>(record.values.size()) + 14);
  set_word(lua, "robot", record.robot);
  set_word(lua, "test", record.test);
  set_word(lua, "kind", record.kind);
  set_word(lua, "series", record.series);
  set_word(lua, "axis", record.axis);
  set_word(lua, "status", record.status);
  set_word(lua, "angle_source", record.angle_source);
  set_word(lua, "source", record.source);
  set_word(lua, "plane", record.plane);
  set_word(lua, "predicted_from", record.predicted_from);
  set_integer(lua, "direction", record.direction);
  set_integer(lua, "repetition", record.repetition);
  set_integer(lua, "started_us", record.started_us);
  for (const auto& [name, estimate] : record.values) {
    if (!std::isfinite(estimate.value)) continue;
    lua_pushnumber(lua, estimate.value);
    lua_setfield(lua, -2, name.c_str());
  }
  lua_createtable(lua, 0, 1);
  lua_pushlstring(lua, record.kind.data(), record.kind.size());
  lua_pushcclosure(lua, missing_in_result, 1);
  lua_setfield(lua, -2, "__index");
  lua_setmetatable(lua, -2);
}

void push_history(lua_State* lua, const History& history) {
  const std::vector<const Record*> first = usable(history.series_first);
  const std::vector<const Record*> recent = usable(history.recent);
  lua_createtable(lua, 0, 2);
  push_array(lua, first.begin(),
             first.begin() + static_cast<std::ptrdiff_t>(std::min(first.size(), kHistoryFirst)));
  lua_setfield(lua, -2, "series_first");
  push_array(lua, recent.end() - static_cast<std::ptrdiff_t>(std::min(recent.size(), kHistoryRecent)),
             recent.end());
  lua_setfield(lua, -2, "recent");
}

void refuse_unknown_fields(lua_State* lua) {
  lua_createtable(lua, 0, 1);
  lua_pushcfunction(lua, missing_in_rule);
  lua_setfield(lua, -2, "__index");
  lua_setmetatable(lua, -2);
}

}  // namespace ballbar
