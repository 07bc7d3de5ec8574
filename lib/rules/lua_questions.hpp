#pragma once
/// The functions of `history`: lua_history.hpp says what each gives. All calls in protected mode.

#include <span>
#include <string>
#include <vector>

#include "rules/lua_history.hpp"

struct luaL_Reg;

namespace ballbar {

/// By name; upvalue 1 of each is the Asked, as light userdata.
std::span<const luaL_Reg> questions();

/// As Past; what the store throws waits in `asked` until the script has ended.
const std::vector<double>& column(lua_State* lua, Asked& asked, const std::string& window,
                                  const std::string& name);
const std::vector<Record>& labels(lua_State* lua, Asked& asked, const std::string& window);

}  // namespace ballbar
