#include "rules/lua_table.hpp"

#include <cmath>
#include <lua.hpp>

#include "rules/names.hpp"
#include "rules/sandbox.hpp"

namespace ballbar {

LuaTable::LuaTable(lua_State* lua, const RuleSource& source) : lua_(lua), source_(source) {
  if (lua_type(lua_, 1) != LUA_TTABLE)
    fail("return", std::string("the file must return a table, not ") + luaL_typename(lua_, 1));
}

void LuaTable::fail(const std::string& word, const std::string& message) const {
  throw ScriptError(word == "return" ? line_of_return(source_.text) : line_of(source_.text, word), message);
}

std::optional<std::string> LuaTable::word(const char* key) const {
  const int type = lua_getfield(lua_, 1, key);
  if (type != LUA_TNIL && type != LUA_TSTRING)
    fail(key, std::string(key) + " must be a text in quotes, not a " + luaL_typename(lua_, -1));
  std::optional<std::string> value;
  if (type == LUA_TSTRING) value = lua_tostring(lua_, -1);
  lua_pop(lua_, 1);
  return value;
}

std::optional<int> LuaTable::whole_number(const char* key, int least, int most) const {
  const int type = lua_getfield(lua_, 1, key);
  int is_whole = 0;
  const lua_Integer value = lua_tointegerx(lua_, -1, &is_whole);
  lua_pop(lua_, 1);
  if (type == LUA_TNIL) return std::nullopt;
  if (type != LUA_TNUMBER || is_whole == 0 || value < least || value > most) {
    fail(key, std::string(key) + " must be a whole number from " + std::to_string(least) + " to " +
                  std::to_string(most));
  }
  return static_cast<int>(value);
}

std::vector<std::string> LuaTable::list_of_words(const char* key) const {
  std::vector<std::string> words;
  const int type = lua_getfield(lua_, 1, key);
  if (type != LUA_TNIL && type != LUA_TTABLE)
    fail(key, std::string(key) + " must be a list of names: { \"...\", \"...\" }");
  if (type == LUA_TTABLE) {
    const lua_Unsigned size = lua_rawlen(lua_, -1);
    lua_Unsigned entries = 0;
    for (lua_pushnil(lua_); lua_next(lua_, -2) != 0; lua_pop(lua_, 1)) ++entries;
    if (entries != size) fail(key, std::string(key) + " must be a list of names: { \"...\", \"...\" }");
    for (lua_Unsigned i = 1; i <= size; ++i) {
      if (lua_rawgeti(lua_, -1, static_cast<lua_Integer>(i)) != LUA_TSTRING)
        fail(key, std::string(key) + " must hold names in quotes, not a " + luaL_typename(lua_, -1));
      words.emplace_back(lua_tostring(lua_, -1));
      lua_pop(lua_, 1);
    }
  }
  lua_pop(lua_, 1);
  return words;
}

bool LuaTable::has_function(const char* key) const {
  const bool found = lua_getfield(lua_, 1, key) == LUA_TFUNCTION;
  lua_pop(lua_, 1);
  return found;
}

void LuaTable::each(int index, const char* what, const std::function<void(const std::string&)>& visit) const {
  index = lua_absindex(lua_, index);
  for (lua_pushnil(lua_); lua_next(lua_, index) != 0; lua_pop(lua_, 1)) {
    if (lua_type(lua_, -2) != LUA_TSTRING)
      fail("return", std::string(what) + " holds a value without a name (name = value)");
    visit(lua_tostring(lua_, -2));
  }
}

std::optional<std::variant<double, std::string, bool>> LuaTable::constant() const {
  std::variant<double, std::string, bool> value;
  switch (lua_type(lua_, -1)) {
    case LUA_TNUMBER:
      value = static_cast<double>(lua_tonumber(lua_, -1));
      break;
    case LUA_TSTRING:
      value = std::string(lua_tostring(lua_, -1));
      break;
    case LUA_TBOOLEAN:
      value = lua_toboolean(lua_, -1) != 0;
      break;
    default:
      return std::nullopt;
  }
  if (const double* number = std::get_if<double>(&value); number != nullptr && !std::isfinite(*number))
    return std::nullopt;
  return value;
}

}  // namespace ballbar
