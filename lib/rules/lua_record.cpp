#include "rules/lua_record.hpp"

#include <cmath>
#include <lua.hpp>

#include "rules/names.hpp"
#include "rules/sandbox_library.hpp"

namespace ballbar {
namespace {

constexpr const char* kResult = "result";
constexpr long long kRecordCost = 300;  // instructions that listing a whole record is worth

const Record& record_at(lua_State* lua, int index) {
  return *static_cast<const Record*>(*static_cast<const void**>(lua_touserdata(lua, index)));
}

// A quantity may be missing in a run, but a name that none can have is a mistake.
int index_record(lua_State* lua) {
  const Record& record = record_at(lua, 1);
  const std::string name = luaL_tolstring(lua, 2, nullptr);
  if (const auto found = record.values.find(name); found != record.values.end()) {
    if (std::isfinite(found->second.value)) {
      lua_pushnumber(lua, found->second.value);
    } else {
      lua_pushnil(lua);
    }
    return 1;
  }
  if (push_label(lua, record, name)) return 1;
  if (name == "findings" && record.kind == "gap") {
    lua_createtable(lua, static_cast<int>(record.parts.size()), 0);
    lua_Integer number = 0;
    for (const Record& part : record.parts) {
      push_record(lua, part);
      lua_rawseti(lua, -2, ++number);
    }
    return 1;
  }
  if (!is_quantity_of(name, record.kind) && !(is_label(name) && record.kind == "gap"))
    return refuse_unknown_name(lua, name, record.kind);
  lua_pushnil(lua);
  return 1;
}

int refuse_change_of_result(lua_State* lua) { return luaL_error(lua, "a result cannot be changed"); }

int next_of_table(lua_State* lua) {
  luaL_checktype(lua, 1, LUA_TTABLE);
  lua_settop(lua, 2);
  return lua_next(lua, 1) != 0 ? 2 : 1;
}

// pairs(result): of a copy.
int pairs_of_record(lua_State* lua) {
  charge(lua, kRecordCost);
  const Record& record = record_at(lua, 1);
  lua_pushcfunction(lua, next_of_table);
  lua_createtable(lua, 0, static_cast<int>(record.values.size()) + 16);
  for (const std::string_view name : label_names()) {
    if (push_label(lua, record, std::string(name))) lua_setfield(lua, -2, std::string(name).c_str());
  }
  for (const auto& [name, estimate] : record.values) {
    if (!std::isfinite(estimate.value)) continue;
    lua_pushnumber(lua, estimate.value);
    lua_setfield(lua, -2, name.c_str());
  }
  lua_pushnil(lua);
  return 3;
}

int missing_in_rule(lua_State* lua) {
  return luaL_error(lua, "the rule has no '%s'", luaL_tolstring(lua, 2, nullptr));
}

}  // namespace

int refuse_unknown_name(lua_State* lua, const std::string& name, const std::string& kind) {
  return luaL_error(lua, "a %s has no '%s'%s", kind.c_str(), name.c_str(), suggestion(name, kind).c_str());
}

bool push_label(lua_State* lua, const Record& record, const std::string& name) {
  if (const auto word = record.words.find(name); word != record.words.end()) {
    lua_pushlstring(lua, word->second.data(), word->second.size());
    return true;
  }
  const bool word = name == "verdict" || name == "effect" || name == "effect_kind";
  if (word || !is_label(name)) return false;
  if (name == "direction") {
    lua_pushinteger(lua, record.direction);
  } else if (name == "repetition") {
    lua_pushinteger(lua, record.repetition);
  } else if (name == "started_us") {
    lua_pushinteger(lua, record.started_us);
  } else {
    const std::string text = label_text(record, name);
    lua_pushlstring(lua, text.data(), text.size());
  }
  return true;
}

void set_methods(lua_State* lua, const char* name, const luaL_Reg* functions) {
  if (luaL_newmetatable(lua, name) != 0) luaL_setfuncs(lua, functions, 0);
  lua_setmetatable(lua, -2);
}

void push_record(lua_State* lua, const Record& record) {
  static constexpr luaL_Reg kMethods[] = {{"__index", index_record},
                                          {"__newindex", refuse_change_of_result},
                                          {"__pairs", pairs_of_record},
                                          {nullptr, nullptr}};
  *static_cast<const void**>(lua_newuserdatauv(lua, sizeof(void*), 0)) = &record;
  set_methods(lua, kResult, kMethods);
}

void refuse_unknown_fields(lua_State* lua) {
  lua_createtable(lua, 0, 1);
  lua_pushcfunction(lua, missing_in_rule);
  lua_setfield(lua, -2, "__index");
  lua_setmetatable(lua, -2);
}

}  // namespace ballbar
