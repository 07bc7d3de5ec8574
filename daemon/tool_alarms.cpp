/// ballbar alarms; alarms show, ack, shelve, unshelve

#include <cstdio>
#include <cstdlib>
#include <filesystem>
#include <iostream>
#include <memory>

#include "core/error.hpp"
#include "daemon/alarm_book.hpp"
#include "daemon/alarm_json.hpp"
#include "daemon/alarm_show.hpp"
#include "daemon/control.hpp"
#include "daemon/tool.hpp"

namespace ballbar {
namespace {

struct AlarmsOptions {
  Where where;
  bool all = false, json = false;
  std::int64_t alarm = 0;
  std::string robot, output, socket, comment, name, until, time_span;
};

/// "acknowledged by anna", "shelved until 2026-03-11 09:00:00"
std::string marks_of(const AlarmStatus& alarm) {
  std::string marks;
  const auto add = [&](const std::string& mark) { marks += (marks.empty() ? "" : ", ") + mark; };
  if (!alarm.acknowledged.by.empty()) add("acknowledged by " + alarm.acknowledged.by);
  if (!alarm.shelved.by.empty()) add("shelved until " + utc_text(alarm.shelved.until_us));
  if (alarm.flapping) add("flapping");
  return marks;
}

int list(const AlarmsOptions& options) {
  const Store store = options.where.open();
  Json all = Json::array();
  if (!options.json)
    std::printf("%4s %-9s %-19s  %-9s %-22s %-12s %-6s %s\n", "id", "state", "since (UTC)", "severity",
                "rule", "robot", "test", "text");
  for (const AlarmStatus& alarm : store.alarm_states()) {
    if (alarm.state == AlarmState::kInactive && alarm.shelved.by.empty() && !options.all) continue;
    if (!options.robot.empty() && alarm.key.robot != options.robot) continue;
    all.push_back(to_json(alarm));
    if (options.json) continue;
    AlarmKey place = alarm.key;
    place.rule.clear();
    place.robot.clear();
    const std::string test = alarm_name(place);
    const std::string marks = marks_of(alarm);
    std::printf("%4lld %-9s %-19s  %-9s %-22s %-12s %-6s %s%s\n", static_cast<long long>(alarm.id),
                to_string(alarm.state), utc_text(alarm.since_us).c_str(), alarm.severity.c_str(),
                alarm.key.rule.c_str(), alarm.key.robot.c_str(),
                test.empty() ? "" : test.substr(test.front() == ' ' ? 1 : 0).c_str(), alarm.text.c_str(),
                marks.empty() ? "" : (" [" + marks + "]").c_str());
  }
  if (options.json) std::cout << text_of(Json{{"alarms", all}});
  return 0;
}

int show(const AlarmsOptions& options) {
  show_alarm(options.where.open(), options.alarm, options.json, options.output);
  return 0;
}

/// "90m", "8h", "2d" in microseconds.
std::int64_t span_us(const std::string& text) {
  const std::string error = "--for takes minutes, hours or days: 90m, 8h, 2d; not '" + text + "'";
  char* end = nullptr;
  const double number = std::strtod(text.c_str(), &end);
  const std::string unit = end;
  const double seconds = unit == "m" ? 60.0 : unit == "h" ? 3600.0 : unit == "d" ? 86'400.0 : 0.0;
  if (!(number > 0.0) || !(number < 1e6) || seconds == 0.0) throw Error(Cause::kInput, error);
  return static_cast<std::int64_t>(number * seconds * 1e6);
}

std::string socket_of(const AlarmsOptions& options) {
  if (!options.socket.empty()) return options.socket;
  std::error_code error;
  const std::string& path = options.where.config_path;
  if (path == kDefaultConfig && !std::filesystem::exists(path, error)) return Config{}.control_socket;
  return load_config(path).control_socket;
}

int tell(const AlarmsOptions& options, const std::string& verb) {
  Json request{{"verb", verb}, {"alarm", options.alarm}, {"comment", options.comment}};
  std::string name = options.name;
  if (const char* sudo = std::getenv("SUDO_USER"); name.empty() && sudo != nullptr) name = sudo;
  if (!name.empty()) request["name"] = name;
  if (verb == "shelve") {
    if (options.until.empty() == options.time_span.empty())
      throw Error(Cause::kInput, "say until when: --for 8h, or --until \"2026-03-11 18:00\" (UTC)");
    request["until_us"] =
        options.until.empty() ? now_us() + span_us(options.time_span) : time_of(options.until, now_us());
  }
  ask(socket_of(options), request.dump(-1, ' ', false, Json::error_handler_t::replace) + "\n");
  return 0;
}

CLI::App* add_telling(CLI::App& alarms, Action& action, const char* name, const char* verb,
                      const char* help) {
  auto options = std::make_shared<AlarmsOptions>();
  CLI::App* app = alarms.add_subcommand(name, help);
  app->add_option("ID", options->alarm, "the alarm, as 'ballbar alarms' shows it")->required();
  app->add_option("--comment", options->comment, "what is to be remembered, e.g. what you have found");
  app->add_option("--name", options->name, "your name, where several people share a login");
  app->add_option("--config", options->where.config_path, "configuration file")->capture_default_str();
  app->add_option("--socket", options->socket, "socket of the service instead of the configured one");
  if (std::string(verb) == "shelve") {
    app->add_option("--for", options->time_span, "how long: 90m, 8h, 2d");
    app->add_option("--until", options->until, "until when, in UTC: \"2026-03-11 18:00\"");
  }
  app->callback([options, verb, &action] { action = [options, verb] { return tell(*options, verb); }; });
  return app;
}

}  // namespace

void add_alarms(CLI::App& app, Action& action) {
  auto options = std::make_shared<AlarmsOptions>();
  CLI::App* verb =
      app.add_subcommand("alarms", "alarms that are pending, firing or resolved; acknowledge, shelve");
  options->where.add_to(*verb);
  verb->add_flag("--all", options->all, "also those that are inactive");
  verb->add_option("--robot", options->robot, "only of this robot");
  verb->add_flag("--json", options->json, "as JSON");
  verb->require_subcommand(0, 1);

  auto show_options = std::make_shared<AlarmsOptions>();
  CLI::App* show_verb = verb->add_subcommand("show", "why one fires: rule, numbers, limit, runs; a picture");
  show_verb->add_option("ID", show_options->alarm, "as 'ballbar alarms' shows it")->required();
  show_options->where.add_to(*show_verb);
  show_verb->add_flag("--json", show_options->json, "as JSON");
  show_verb->add_option("-o,--output", show_options->output, "picture of the trend to write: .svg or .png");
  show_verb->callback([show_options, &action] { action = [show_options] { return show(*show_options); }; });

  add_telling(*verb, action, "ack", "acknowledge", "say that you have seen it");
  add_telling(*verb, action, "shelve", "shelve", "do not be told of it for a while");
  add_telling(*verb, action, "unshelve", "unshelve", "be told of it again");
  verb->callback([options, verb, &action] {
    if (verb->get_subcommands().empty()) action = [options] { return list(*options); };
  });
}

}  // namespace ballbar
