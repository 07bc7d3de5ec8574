#include "rules/lua_asking.hpp"

#include <cmath>
#include <cstdlib>
#include <lua.hpp>

#include "rules/lua_record.hpp"
#include "rules/names.hpp"

namespace ballbar {
namespace {

// Calls `read`; what the store throws waits until the script has ended.
template <typename Read>
auto guarded(lua_State* lua, Asked& asked, Read read) {
  try {
    return read();
  } catch (const std::exception& error) {
    asked.failed = std::current_exception();
  }
  luaL_error(lua, "the history cannot be read");
  std::abort();  // not reached: luaL_error does not return
}

}  // namespace

const std::vector<double>& column(lua_State* lua, Asked& asked, const std::string& window,
                                  const std::string& name) {
  return *guarded(lua, asked, [&] { return &asked.past.column(window, name); });
}

const std::vector<Record>& labels(lua_State* lua, Asked& asked, const std::string& window) {
  return *guarded(lua, asked, [&] { return &asked.past.window(window); });
}

Asked& asked_of(lua_State* lua) { return *static_cast<Asked*>(lua_touserdata(lua, lua_upvalueindex(1))); }

std::string name_argument(lua_State* lua, const Asked& asked) {
  std::string name = luaL_checkstring(lua, 1);
  if (!is_quantity_of(name, asked.record.kind)) refuse_unknown_name(lua, name, asked.record.kind);
  return name;
}

double present(lua_State* lua, const Asked& asked, const std::string& name) {
  const auto found = asked.record.values.find(name);
  if (found == asked.record.values.end() || !std::isfinite(found->second.value))
    luaL_error(lua, "this %s has no '%s'", asked.record.kind.c_str(), name.c_str());
  return found->second.value;
}

std::size_t count_argument(lua_State* lua, int index, int otherwise, int least, int most) {
  const lua_Integer number = luaL_optinteger(lua, index, otherwise);
  if (number < least || number > most) luaL_error(lua, "so many results must be from %d to %d", least, most);
  return static_cast<std::size_t>(number);
}

double positive_argument(lua_State* lua, int index, double otherwise, double most) {
  const double number = luaL_optnumber(lua, index, otherwise);
  if (!(number > 0.0 && number <= most))
    luaL_error(lua, "argument %d must be more than 0 and at most %f", index, most);
  return number;
}

int nothing(lua_State* lua) {
  lua_pushnil(lua);
  return 1;
}

int answer(lua_State* lua, std::initializer_list<double> numbers) {
  for (const double number : numbers) lua_pushnumber(lua, number);
  return static_cast<int>(numbers.size());
}

}  // namespace ballbar
