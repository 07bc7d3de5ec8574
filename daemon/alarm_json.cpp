#include "daemon/alarm_json.hpp"

#include <cstdio>

#include "daemon/alarm_book.hpp"
#include "daemon/tool.hpp"

namespace ballbar {
namespace {

constexpr int kNotificationVersion = 1;

std::string lines_of(const AlarmStatus& alarm) {
  std::string text;
  for (const AlarmNumber& number : alarm.numbers) {
    char line[160];
    std::snprintf(line, sizeof line, "  %-36s %12.6g", number.name.c_str(), number.value);
    text += line;
    if (number.sd) {
      std::snprintf(line, sizeof line, " +- %.3g", *number.sd);
      text += line;
    }
    text += number.of_rule ? "  (set in the rule)\n" : "\n";
  }
  return text;
}

}  // namespace

std::string utc_json(std::int64_t time_us) {
  std::string text = utc_text(time_us);
  text[10] = 'T';
  return text + "Z";
}

Json to_json(const AlarmStatus& alarm) {
  Json json;
  json["id"] = alarm.id;
  json["rule"] = alarm.key.rule;
  json["robot"] = alarm.key.robot;
  json["test"] = alarm.key.test;
  json["direction"] = alarm.key.direction;
  json["axis"] = alarm.key.axis;
  json["state"] = to_string(alarm.state);
  json["severity"] = alarm.severity;
  json["since_us"] = alarm.since_us;
  json["since_utc"] = utc_json(alarm.since_us);
  json["text"] = alarm.text;
  json["bad_runs"] = alarm.bad_runs;
  json["clean_runs"] = alarm.clean_runs;
  json["flapping"] = alarm.flapping;
  json["numbers"] = Json::array();
  for (const AlarmNumber& number : alarm.numbers)
    json["numbers"].push_back({{"name", number.name},
                               {"value", number.value},
                               {"sd", number.sd ? Json(*number.sd) : Json()},
                               {"of", number.of_rule ? "rule" : "run"}});
  json["run_started_us"] = alarm.runs;
  json["acknowledged"] = Json();
  if (!alarm.acknowledged.by.empty())
    json["acknowledged"] = {{"by", alarm.acknowledged.by},
                            {"comment", alarm.acknowledged.comment},
                            {"at_us", alarm.acknowledged.at_us}};
  json["shelved"] = Json();
  if (!alarm.shelved.by.empty())
    json["shelved"] = {
        {"by", alarm.shelved.by}, {"comment", alarm.shelved.comment}, {"until_us", alarm.shelved.until_us}};
  return json;
}

Json to_json(const StoredEvent& stored) {
  const AlarmEvent& event = stored.event;
  Json json;
  json["event"] = stored.id;
  json["change"] = to_string(event.change);
  json["from"] = to_string(event.from);
  json["to"] = to_string(event.status.state);
  json["at_us"] = event.at_us;
  json["at_utc"] = utc_json(event.at_us);
  json["by"] = event.by;
  json["comment"] = event.comment;
  json["text"] = event.status.text;
  return json;
}

Json notification(const StoredEvent& stored) {
  const AlarmStatus& alarm = stored.event.status;
  Json json = {{"version", kNotificationVersion}};
  json.update(to_json(stored));
  json["alarm"] = to_json(alarm);
  json["alarm"].erase("acknowledged");  // of an event that has just happened, nobody can have seen anything
  json["alarm"].erase("shelved");
  const bool over = alarm.state != AlarmState::kFiring;
  const std::string name = alarm_name(alarm.key);
  json["subject"] = std::string("ballbard: ") + to_string(alarm.state) + " (" + alarm.severity + ") " + name;
  json["message"] = (over ? "It was: " : "") + alarm.text + "\n\nAlarm " + std::to_string(alarm.id) + ": " +
                    name + ", " + to_string(alarm.state) + " since " + utc_text(alarm.since_us) + " UTC\n" +
                    lines_of(alarm) + "\nballbar alarms show " + std::to_string(alarm.id) +
                    "\nballbar alarms ack " + std::to_string(alarm.id) + " --comment \"...\"\n";
  return json;
}

}  // namespace ballbar
