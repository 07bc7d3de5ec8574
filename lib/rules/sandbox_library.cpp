#include "rules/sandbox_library.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <lua.hpp>
#include <string_view>

namespace ballbar {
namespace {

constexpr long long kMaxCost = 1'000'000'000;  // more than any budget, far from overflow

// C functions run without counting instructions, so each pays before it works. All of these are upper bounds,
// roughly in units of one instruction.
using CostFunction = long long (*)(lua_State*);

long long cost_of_arguments(lua_State* lua) {
  const int count = lua_gettop(lua);
  long long bytes = 0;
  for (int i = 1; i <= count; ++i)
    if (lua_type(lua, i) == LUA_TSTRING) bytes += static_cast<long long>(lua_rawlen(lua, i));
  return count + bytes / 4;
}

long long cost_of_format(lua_State* lua) {
  return 32 * cost_of_arguments(lua);
}  // "%99.99f" takes a microsecond

long long cost_of_table(lua_State* lua) {
  return static_cast<long long>(lua_rawlen(lua, 1)) + cost_of_arguments(lua);
}

long long cost_of_sort(lua_State* lua) { return 16 * cost_of_table(lua); }

long long cost_of_range(lua_State* lua, int from, int to) {
  int has_end = 0;
  const lua_Integer end = lua_tointegerx(lua, to, &has_end);
  if (!has_end) return cost_of_table(lua);
  const auto span = static_cast<double>(end) - static_cast<double>(lua_tointeger(lua, from)) + 1.0;
  return cost_of_table(lua) + static_cast<long long>(std::clamp(span, 0.0, static_cast<double>(kMaxCost)));
}

long long cost_of_unpack(lua_State* lua) { return cost_of_range(lua, 2, 3); }
long long cost_of_concat(lua_State* lua) { return cost_of_range(lua, 3, 4); }

struct Allowed {
  const char* name;
  CostFunction cost = cost_of_arguments;
};

constexpr std::array<Allowed, 9> kBase{{{"assert"},
                                        {"error"},
                                        {"ipairs"},
                                        {"pairs"},
                                        {"next"},
                                        {"select"},
                                        {"tonumber"},
                                        {"tostring"},
                                        {"type"}}};
constexpr std::array<Allowed, 6> kString{
    {{"format", cost_of_format}, {"len"}, {"lower"}, {"upper"}, {"sub"}, {"byte"}}};
constexpr std::array<Allowed, 5> kTable{{{"insert", cost_of_table},
                                         {"remove", cost_of_table},
                                         {"concat", cost_of_concat},
                                         {"sort", cost_of_sort},
                                         {"unpack", cost_of_unpack}}};
constexpr std::array<Allowed, 20> kMath{
    {{"abs"}, {"ceil"}, {"floor"}, {"fmod"}, {"max"}, {"min"}, {"modf"}, {"sqrt"}, {"sin"},  {"cos"},
     {"tan"}, {"asin"}, {"acos"},  {"atan"}, {"exp"}, {"log"}, {"deg"},  {"rad"},  {"type"}, {"tointeger"}}};

// Named only to say "blocked" rather than "unknown": nobody gets at anything by not being listed here.
constexpr std::array<std::string_view, 6> kBlockedLibraries{"os",      "io",        "debug",
                                                            "package", "coroutine", "utf8"};
constexpr std::array<std::string_view, 20> kBlockedFunctions{
    "collectgarbage", "dofile", "getmetatable", "load",   "loadfile", "loadstring", "module",
    "pcall",          "print",  "rawequal",     "rawget", "rawlen",   "rawset",     "require",
    "setmetatable",   "unpack", "warn",         "xpcall", "_G",       "_VERSION"};

int call_charged(lua_State* lua) {
  const auto& allowed = *static_cast<const Allowed*>(lua_touserdata(lua, lua_upvalueindex(2)));
  charge(lua, std::min(allowed.cost(lua), kMaxCost));
  return lua_tocfunction(lua, lua_upvalueindex(1))(lua);
}

// contains(text, part) -> boolean. In place of string.find, whose patterns can run for ever.
int contains(lua_State* lua) {
  std::size_t size = 0;
  const char* begin = luaL_checklstring(lua, 1, &size);
  const std::string_view text(begin, size);
  begin = luaL_checklstring(lua, 2, &size);
  const std::string_view part(begin, size);
  const std::size_t cost = text.size() * part.size() / 64 + text.size() / 4;
  charge(lua, static_cast<long long>(cost));
  lua_pushboolean(lua, text.find(part) != std::string_view::npos);
  return 1;
}

// __index of a library: upvalue 1 is its name.
int refuse_member(lua_State* lua) {
  const char* library = lua_tostring(lua, lua_upvalueindex(1));
  return luaL_error(lua, "blocked function: %s.%s", library, luaL_tolstring(lua, 2, nullptr));
}

// Pushes a metatable whose __index is `refuse`, with `library` as its upvalue.
void push_refusal(lua_State* lua, lua_CFunction refuse, const char* library) {
  lua_createtable(lua, 0, 1);
  lua_pushstring(lua, library);
  lua_pushcclosure(lua, refuse, 1);
  lua_setfield(lua, -2, "__index");
}

// __index of the environment.
int refuse_name(lua_State* lua) {
  const char* name = luaL_tolstring(lua, 2, nullptr);
  if (std::find(kBlockedLibraries.begin(), kBlockedLibraries.end(), name) != kBlockedLibraries.end()) {
    lua_createtable(lua, 0, 0);  // so that the message can name the function too
    push_refusal(lua, refuse_member, name);
    lua_setmetatable(lua, -2);
    return 1;
  }
  if (std::find(kBlockedFunctions.begin(), kBlockedFunctions.end(), name) != kBlockedFunctions.end())
    return luaL_error(lua, "blocked function: %s", name);
  return luaL_error(lua, "unknown name '%s'", name);
}

// Moves the allowed functions from the full library at `from` to the table at `to`.
template <std::size_t n>
void copy_allowed(lua_State* lua, int from, int to, const std::array<Allowed, n>& allowed) {
  for (const Allowed& entry : allowed) {
    lua_getfield(lua, from, entry.name);
    lua_pushlightuserdata(lua, const_cast<Allowed*>(&entry));
    lua_pushcclosure(lua, call_charged, 2);
    lua_setfield(lua, to, entry.name);
  }
}

// Opens a library of Lua's and pushes a table with what is allowed of it.
template <std::size_t n>
void push_library(lua_State* lua, lua_CFunction open, const std::array<Allowed, n>& allowed) {
  lua_pushcfunction(lua, open);
  lua_call(lua, 0, 1);
  lua_createtable(lua, 0, static_cast<int>(n) + 2);
  const int to = lua_gettop(lua);
  copy_allowed(lua, to - 1, to, allowed);
  lua_remove(lua, to - 1);
}

// The metatable of all strings, which luaopen_string gave arithmetic: only __index is left, set by each run.
void limit_strings(lua_State* lua) {
  lua_pushliteral(lua, "");
  lua_createtable(lua, 0, 2);
  lua_pushboolean(lua, 0);
  lua_setfield(lua, -2, "__metatable");
  lua_setmetatable(lua, -2);
  lua_pop(lua, 1);
}

void set_string_methods(lua_State* lua, int library) {
  lua_pushliteral(lua, "");
  if (lua_getmetatable(lua, -1) != 0) {
    lua_pushvalue(lua, library);
    lua_setfield(lua, -2, "__index");
    lua_pop(lua, 1);
  }
  lua_pop(lua, 1);
}

// In the registry: array of { functions, metatable }; the environment's own first, then each library.
const char kLibraryKey = 0;
struct Library {
  const char* name;
  int size;
};
constexpr std::array<Library, 4> kLibraries{{{"", 16}, {"string", 8}, {"table", 6}, {"math", 24}}};

// Pushes a copy of a prepared table (1 to 4), with its metatable.
void push_copy(lua_State* lua, int prepared, int number) {
  lua_createtable(lua, 0, kLibraries[static_cast<std::size_t>(number) - 1].size);
  const int to = lua_gettop(lua);
  lua_rawgeti(lua, prepared, 2LL * number - 1);
  for (lua_pushnil(lua); lua_next(lua, to + 1) != 0;) {
    lua_pushvalue(lua, -2);
    lua_insert(lua, -2);
    lua_rawset(lua, to);
  }
  lua_rawgeti(lua, prepared, 2LL * number);
  lua_setmetatable(lua, to);
  lua_settop(lua, to);
}

}  // namespace

void prepare_library(lua_State* lua) {
  lua_createtable(lua, 8, 0);
  const int prepared = lua_gettop(lua);
  push_library(lua, luaopen_base, kBase);
  lua_rawseti(lua, prepared, 1);
  push_library(lua, luaopen_string, kString);
  lua_pushcfunction(lua, contains);
  lua_setfield(lua, -2, "contains");
  limit_strings(lua);
  lua_rawseti(lua, prepared, 3);
  push_library(lua, luaopen_table, kTable);
  lua_rawseti(lua, prepared, 5);
  push_library(lua, luaopen_math, kMath);
  lua_pushnumber(lua, HUGE_VAL);
  lua_setfield(lua, -2, "huge");
  lua_pushnumber(lua, std::acos(-1.0));
  lua_setfield(lua, -2, "pi");
  lua_rawseti(lua, prepared, 7);
  for (int number = 1; number <= 4; ++number) {
    push_refusal(lua, number == 1 ? refuse_name : refuse_member,
                 kLibraries[static_cast<std::size_t>(number) - 1].name);
    lua_rawseti(lua, prepared, 2LL * number);
  }
  lua_rawsetp(lua, LUA_REGISTRYINDEX, &kLibraryKey);
}

void push_environment(lua_State* lua) {
  lua_rawgetp(lua, LUA_REGISTRYINDEX, &kLibraryKey);
  const int prepared = lua_gettop(lua);
  push_copy(lua, prepared, 1);
  const int environment = lua_gettop(lua);
  for (int number = 2; number <= 4; ++number) {
    push_copy(lua, prepared, number);
    if (number == 2) set_string_methods(lua, lua_gettop(lua));
    lua_setfield(lua, environment, kLibraries[static_cast<std::size_t>(number) - 1].name);
  }
  // The table that luaopen_base filled with everything is out of reach from here on.
  lua_pushvalue(lua, environment);
  lua_rawseti(lua, LUA_REGISTRYINDEX, LUA_RIDX_GLOBALS);
  lua_remove(lua, prepared);
}

}  // namespace ballbar
