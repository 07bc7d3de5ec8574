#pragma once
/// What a script may call. Only for sandbox.cpp.

struct lua_State;

namespace ballbar {

/// Takes `cost` instructions off the budget of the running script; raises a Lua error where it is used up. In
/// sandbox.cpp.
void charge(lua_State* lua, long long cost);

/// Makes the allowed functions once for a state. Raises Lua errors: to be called in protected mode.
void prepare_library(lua_State* lua);

/// Pushes a fresh environment that holds the allowed functions and nothing else, and gives strings the same
/// methods. After prepare_library. Raises Lua errors.
void push_environment(lua_State* lua);

}  // namespace ballbar
