#pragma once
/// Results as Lua tables. All calls in protected mode.

#include "core/alarm.hpp"
#include "core/result.hpp"

struct lua_State;

namespace ballbar {

/// Pushes a record as rule.hpp describes `result`: labels and quantities by name; values that are not finite
/// are left out.
void push_record(lua_State* lua, const Record& record);

/// Pushes `history` with its two arrays, as far as rules see them.
void push_history(lua_State* lua, const History& history);

/// Gives the table on top of the stack an error for names that it does not hold: "the rule has no 'limt_um'".
void refuse_unknown_fields(lua_State* lua);

}  // namespace ballbar
