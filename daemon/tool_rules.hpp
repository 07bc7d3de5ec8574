#pragma once
/// Working on rules with what is stored: `rules backtest`, `rules explain`.

#include "daemon/tool.hpp"

namespace ballbar {

/// @param rules  the verb `rules`
void add_rule_history(CLI::App& rules, Action& action);

}  // namespace ballbar
