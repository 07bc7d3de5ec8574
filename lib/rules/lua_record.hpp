#pragma once
/// Results as Lua sees them: read by name, never written. All calls in protected mode.

#include <string>

#include "core/result.hpp"

struct lua_State;
struct luaL_Reg;

namespace ballbar {

/// Pushes a record as rule.hpp describes `result`: labels, words and quantities by name; values that are not
/// finite are nil. `record` must outlive the run of the script.
void push_record(lua_State* lua, const Record& record);

/// Pushes the label or word of that name, or nothing. @return whether there is one
bool push_label(lua_State* lua, const Record& record, const std::string& name);

/// Raises the error for a name that no record of `kind` can have.
int refuse_unknown_name(lua_State* lua, const std::string& name, const std::string& kind);

/// Gives the table on top of the stack an error for names that it does not hold: "the rule has no 'limt_um'".
void refuse_unknown_fields(lua_State* lua);

/// Gives the userdata on top of the stack a metatable of `name`, made once per state.
/// @param functions  __index and the like, ended by {nullptr, nullptr}
void set_methods(lua_State* lua, const char* name, const luaL_Reg* functions);

}  // namespace ballbar
