#pragma once
/// Why an alarm fires: `ballbar alarms show`.

#include <cstdint>
#include <string>

#include "store/store.hpp"

namespace ballbar {

/// Prints the rule, its numbers, the runs and what happened; draws the trend that fired it.
/// @param output  .svg or .png to write; empty: none
/// @throws Error(kInput) where there is no such alarm, or it stands on no figure that could be drawn
void show_alarm(const Store& store, std::int64_t id, bool json_wanted, const std::string& output);

}  // namespace ballbar
