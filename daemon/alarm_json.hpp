#pragma once
/// Alarms as JSON: for `ballbar alarms --json` and for the [notify] command. docs/alarms.md explains every
/// field.

#include "core/alarm.hpp"
#include "daemon/json_out.hpp"
#include "store/store.hpp"

namespace ballbar {

Json to_json(const AlarmStatus& alarm);

/// What happened, with the alarm as it was then.
Json to_json(const StoredEvent& event);

/// What the [notify] command reads: the event, and a subject and a message for people.
Json notification(const StoredEvent& event);

/// "2026-03-11T09:00:00Z"
std::string utc_json(std::int64_t time_us);

}  // namespace ballbar
