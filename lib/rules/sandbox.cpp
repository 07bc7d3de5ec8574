#include "rules/sandbox.hpp"

#include <algorithm>
#include <cstdlib>
#include <exception>
#include <lua.hpp>
#include <memory>
#include <string_view>

#include "rules/sandbox_library.hpp"

namespace ballbar {

/// What one run of a script may still use.
struct ScriptBudget {
  std::size_t used = 0;
  std::size_t before = 0;  // of `used`, what was there before this run
  int refusals = 0;
  long long instructions = kLuaInstructions;
  int line = 0;  // where it went wrong
  lua_State* lua = nullptr;
};

namespace {

constexpr std::string_view kChunk = "rule:";  // Lua puts "rule:LINE: " before its messages
constexpr std::size_t kMaxMessage = 500;      // [bytes]
constexpr std::size_t kStringHeader = 64;     // [bytes] at least what Lua adds to a string
// Lua answers a refused block with a full collection and a second try. A script that lives at the edge of its
// memory would spend its instructions on collections of milliseconds each, so after this many refusals
// nothing is given any more.
constexpr int kMaxRefusals = 8;

// Garbage of earlier runs that is not worth a collection yet.
constexpr std::size_t kMaxGarbage = std::size_t{512} << 10;  // [bytes]

ScriptBudget& budget_of(lua_State* lua) {
  void* budget = nullptr;
  lua_getallocf(lua, &budget);
  return *static_cast<ScriptBudget*>(budget);
}

// The line of the innermost Lua function that runs; allocates nothing.
int current_line(lua_State* lua) {
  lua_Debug where{};
  for (int level = 0; lua_getstack(lua, level, &where) != 0; ++level) {
    lua_getinfo(lua, "l", &where);
    if (where.currentline > 0) return where.currentline;
  }
  return 0;
}

void* allocate(void* user, void* block, std::size_t old_size, std::size_t new_size) {
  ScriptBudget& budget = *static_cast<ScriptBudget*>(user);
  const bool is_string =
      block == nullptr && old_size == LUA_TSTRING;  // for a new block, old_size is the kind of object
  if (block == nullptr) old_size = 0;
  if (new_size == 0) {
    std::free(block);
    budget.used -= old_size;
    return nullptr;
  }
  if (new_size > old_size) {
    const bool fits = budget.used - old_size + new_size <= budget.before + kLuaMemory &&
                      new_size <= kLuaMaxBlock + kStringHeader &&
                      !(is_string && new_size > kLuaMaxString + kStringHeader);
    if (!fits || budget.refusals >= kMaxRefusals) {
      ++budget.refusals;
      if (budget.lua != nullptr) budget.line = current_line(budget.lua);
      return nullptr;
    }
  }
  void* moved = std::realloc(block, new_size);
  if (moved == nullptr) return new_size <= old_size ? block : nullptr;  // Lua relies on shrinking
  budget.used += new_size - old_size;
  return moved;
}

void count_instructions(lua_State* lua, lua_Debug* /*where*/) { charge(lua, kLuaHookEvery); }

// Runs where the error is, before the stack is taken down.
int note_error(lua_State* lua) {
  budget_of(lua).line = current_line(lua);
  if (lua_type(lua, 1) == LUA_TSTRING) return 1;
  lua_pushfstring(lua, "error(...) was called with a %s instead of a text", luaL_typename(lua, 1));
  return 1;
}

struct Call {
  const std::string& source;
  const std::function<void(lua_State*)>* use;
  std::exception_ptr escaped;  // must not pass through Lua, which would take it for its own
};

const char kChunkKey = 0;  // its address names the compiled text in the registry

int load_chunk(lua_State* lua) {
  const Call& call = *static_cast<const Call*>(lua_touserdata(lua, 1));
  prepare_library(lua);
  std::string_view text = call.source;
  if (text.substr(0, 3) == "\xEF\xBB\xBF") text.remove_prefix(3);  // byte order mark of Windows editors
  if (luaL_loadbufferx(lua, text.data(), text.size(), "=rule", "t") != LUA_OK) return lua_error(lua);
  lua_rawsetp(lua, LUA_REGISTRYINDEX, &kChunkKey);
  return 0;
}

int run_call(lua_State* lua) {
  Call& call = *static_cast<Call*>(lua_touserdata(lua, 1));
  lua_settop(lua, 0);
  lua_rawgetp(lua, LUA_REGISTRYINDEX, &kChunkKey);
  push_environment(lua);
  if (lua_setupvalue(lua, 1, 1) == nullptr) lua_pop(lua, 1);
  lua_call(lua, 0, 1);
  try {
    (*call.use)(lua);
  } catch (const std::exception&) {  // never (...): Lua's own errors are exceptions too, and must pass
    call.escaped = std::current_exception();
  }
  return 0;
}

// Takes "rule:12: " off the message; the line in it knows better than the stack (error levels, syntax
// errors).
ScriptError script_error(std::string message, int line) {
  if (message.compare(0, kChunk.size(), kChunk) == 0) {
    const std::size_t colon = message.find(": ", kChunk.size());
    const std::string number = message.substr(kChunk.size(), colon - kChunk.size());
    if (colon != std::string::npos && !number.empty() && number.size() < 8 &&
        number.find_first_not_of("0123456789") == std::string::npos) {
      line = std::stoi(number);
      message.erase(0, colon + 2);
    }
  }
  if (message.size() > kMaxMessage) message = message.substr(0, kMaxMessage) + "...";
  std::replace_if(
      message.begin(), message.end(), [](unsigned char c) { return c < 0x20 || c == 0x7f; }, ' ');
  return {line, message};
}

ScriptError failure(lua_State* lua, int status, const ScriptBudget& budget) {
  if (status == LUA_ERRMEM) {
    return {budget.line,
            "over the memory budget (4 MiB in all, 4 KiB in one string, about 4000 entries in one table or "
            "in nested calls)"};
  }
  if (status != LUA_ERRRUN || lua_type(lua, -1) != LUA_TSTRING)
    return {budget.line, "failed while an error was handled"};
  std::size_t size = 0;
  const char* message = lua_tolstring(lua, -1, &size);
  return script_error(std::string(message, size), budget.line);
}

}  // namespace

void charge(lua_State* lua, long long cost) {
  ScriptBudget& budget = budget_of(lua);
  budget.instructions -= cost;
  if (budget.instructions >= 0) return;
  // Without luaL_error's position: inside a hook it would name the caller's line.
  lua_pushfstring(lua, "over the instruction budget of %d: endless loop?", kLuaInstructions);
  lua_error(lua);
}

struct Script::State {
  ScriptBudget budget;
  std::unique_ptr<lua_State, void (*)(lua_State*)> lua{lua_newstate(allocate, &budget), lua_close};

  // Runs `work` with `call` in protected mode, with a budget of its own. @return Lua's status
  int protect(lua_CFunction work, Call& call) {
    budget.before = budget.used;
    budget.refusals = 0;
    budget.instructions = kLuaInstructions;
    budget.line = 0;
    budget.lua = lua.get();
    lua_sethook(lua.get(), count_instructions, LUA_MASKCOUNT, kLuaHookEvery);
    lua_pushcfunction(lua.get(), note_error);
    lua_pushcfunction(lua.get(), work);
    lua_pushlightuserdata(lua.get(), &call);
    const int status = lua_pcall(lua.get(), 1, 0, 1);
    budget.lua = nullptr;
    return status;
  }
};

Script::Script(std::string source) : source_(std::move(source)) {}
Script::~Script() = default;

void Script::run(const std::function<void(lua_State*)>& use) {
  // What fails is not run again: `state` goes with the error.
  std::unique_ptr<State> state = std::move(state_);
  Call call{source_, &use, nullptr};
  if (!state) {
    state = std::make_unique<State>();
    if (!state->lua) throw std::bad_alloc();
    const int status = state->protect(load_chunk, call);
    if (status != LUA_OK) throw failure(state->lua.get(), status, state->budget);
    lua_settop(state->lua.get(), 0);
  }
  const int status = state->protect(run_call, call);
  if (call.escaped) std::rethrow_exception(call.escaped);
  if (status != LUA_OK) throw failure(state->lua.get(), status, state->budget);
  lua_settop(state->lua.get(), 0);
  if (state->budget.used > kMaxGarbage) lua_gc(state->lua.get(), LUA_GCCOLLECT);
  state_ = std::move(state);
}

void run_sandboxed(const std::string& source, const std::function<void(lua_State*)>& use) {
  Script(source).run(use);
}

}  // namespace ballbar
