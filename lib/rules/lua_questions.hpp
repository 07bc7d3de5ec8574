#pragma once
/// The functions of `history`: lua_history.hpp says what each gives. By name; upvalue 1 of each is the Asked,
/// as light userdata.

#include <span>

struct luaL_Reg;

namespace ballbar {

/// Of the latest results: count, last, mean, median, spread, slope, days_until, percent.
std::span<const luaL_Reg> latest_questions();

/// Against the baseline: baseline, ewma, cusum, distance, vector_cusum.
std::span<const luaL_Reg> baseline_questions();

}  // namespace ballbar
