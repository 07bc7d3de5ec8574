#pragma once
/// What the functions of `history` share: their arguments, what they read, what they answer. All calls in
/// protected mode; a wrong argument is an error of the script.

#include <cstddef>
#include <initializer_list>
#include <string>
#include <vector>

#include "rules/lua_history.hpp"

namespace ballbar {

/// Instructions that a question about two hundred figures is worth.
inline constexpr long long kQuestionCost = 2000;

/// Of a function whose upvalue 1 is the Asked, as light userdata.
Asked& asked_of(lua_State* lua);

/// As Past; what the store throws waits in `asked` until the script has ended.
const std::vector<double>& column(lua_State* lua, Asked& asked, const std::string& window,
                                  const std::string& name);
const std::vector<Record>& labels(lua_State* lua, Asked& asked, const std::string& window);

/// Argument 1: a quantity of the result.
std::string name_argument(lua_State* lua, const Asked& asked);

/// The quantity of the result that is being judged.
double present(lua_State* lua, const Asked& asked, const std::string& name);

std::size_t count_argument(lua_State* lua, int index, int otherwise, int least, int most);
double positive_argument(lua_State* lua, int index, double otherwise, double most);

int nothing(lua_State* lua);
int answer(lua_State* lua, std::initializer_list<double> numbers);

}  // namespace ballbar
