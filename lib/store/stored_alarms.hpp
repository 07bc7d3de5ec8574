#pragma once
/// Alarms as rows, for save(), which stores them with the run that moved them.

#include <vector>

#include "core/alarm.hpp"
#include "store/sqlite.hpp"

namespace ballbar {

/// Replaces those of the same key. @throws std::invalid_argument for a number that is not finite
void put_states(Database& db, const std::vector<AlarmStatus>& states);

/// Appends, in their order.
void insert_events(Database& db, const std::vector<AlarmEvent>& events);

}  // namespace ballbar
