#include "rules/lua_history.hpp"

#include <algorithm>
#include <cmath>
#include <lua.hpp>
#include <string>

#include "rules/lua_asking.hpp"
#include "rules/lua_questions.hpp"
#include "rules/lua_record.hpp"
#include "rules/names.hpp"
#include "rules/sandbox_library.hpp"

namespace ballbar {
namespace {

constexpr long long kReadCost = 50;  // instructions that a look at one earlier figure is worth

struct Place {
  Asked* asked;
  const char* window;
  std::size_t begin, end;  // of the window
};

// One earlier result: history.recent[3].
int index_earlier(lua_State* lua) {
  charge(lua, kReadCost);
  const auto& place = *static_cast<const Place*>(lua_touserdata(lua, 1));
  const std::string name = luaL_tolstring(lua, 2, nullptr);
  if (push_label(lua, labels(lua, *place.asked, place.window)[place.begin], name)) return 1;
  const std::string& kind = place.asked->record.kind;
  if (!is_quantity_of(name, kind)) return refuse_unknown_name(lua, name, kind);
  const double value = column(lua, *place.asked, place.window, name)[place.begin];
  if (std::isfinite(value)) {
    lua_pushnumber(lua, value);
  } else {
    lua_pushnil(lua);
  }
  return 1;
}

int refuse_pairs(lua_State* lua) {
  return luaL_error(lua, "ask an earlier result by the names of its quantities");
}
int refuse_change_of_history(lua_State* lua) { return luaL_error(lua, "the history cannot be changed"); }

void push_place(lua_State* lua, const Place& place) {
  *static_cast<Place*>(lua_newuserdatauv(lua, sizeof(Place), 0)) = place;
}

int index_window(lua_State* lua) {
  const auto& place = *static_cast<const Place*>(lua_touserdata(lua, 1));
  static constexpr luaL_Reg kMethods[] = {{"__index", index_earlier},
                                          {"__newindex", refuse_change_of_history},
                                          {"__pairs", refuse_pairs},
                                          {nullptr, nullptr}};
  int is_whole = 0;
  const lua_Integer number = lua_tointegerx(lua, 2, &is_whole);
  if (is_whole == 0 || number < 1 || number > static_cast<lua_Integer>(place.end - place.begin)) {
    lua_pushnil(lua);
    return 1;
  }
  const std::size_t at = place.begin + static_cast<std::size_t>(number) - 1;
  push_place(lua, {place.asked, place.window, at, at + 1});
  set_methods(lua, "earlier result", kMethods);
  return 1;
}

int length_of_window(lua_State* lua) {
  const auto& place = *static_cast<const Place*>(lua_touserdata(lua, 1));
  lua_pushinteger(lua, static_cast<lua_Integer>(place.end - place.begin));
  return 1;
}

void push_window(lua_State* lua, Asked& asked, const char* window, bool newest, std::size_t most) {
  static constexpr luaL_Reg kMethods[] = {{"__index", index_window},
                                          {"__newindex", refuse_change_of_history},
                                          {"__len", length_of_window},
                                          {nullptr, nullptr}};
  const std::size_t size = labels(lua, asked, window).size();
  const std::size_t shown = std::min(size, most);
  push_place(lua, newest ? Place{&asked, window, size - shown, size} : Place{&asked, window, 0, shown});
  set_methods(lua, "list of results", kMethods);
}

int index_history(lua_State* lua) {
  Asked& asked = *static_cast<Asked*>(*static_cast<void**>(lua_touserdata(lua, 1)));
  const std::string name = luaL_tolstring(lua, 2, nullptr);
  if (name == "series_first") return push_window(lua, asked, "series", false, kHistoryFirst), 1;
  if (name == "recent") return push_window(lua, asked, "recent", true, kHistoryRecent), 1;
  lua_CFunction function = nullptr;
  std::vector<std::string_view> known{"series_first", "recent"};
  for (const std::span<const luaL_Reg> group : {latest_questions(), baseline_questions()})
    for (const luaL_Reg& entry : group) {
      if (name == entry.name) function = entry.func;
      known.emplace_back(entry.name);
    }
  if (function == nullptr)
    return luaL_error(lua, "blocked function: history.%s%s", name.c_str(),
                      did_you_mean(nearest(name, known, 3)).c_str());
  lua_pushlightuserdata(lua, &asked);
  lua_pushcclosure(lua, function, 1);
  return 1;
}

}  // namespace

void push_history(lua_State* lua, Asked& asked) {
  static constexpr luaL_Reg kMethods[] = {
      {"__index", index_history}, {"__newindex", refuse_change_of_history}, {nullptr, nullptr}};
  *static_cast<void**>(lua_newuserdatauv(lua, sizeof(void*), 0)) = &asked;
  set_methods(lua, "history", kMethods);
}

}  // namespace ballbar
