/// ballbar alarms; alarms show, ack, shelve, unshelve

#include <algorithm>
#include <chrono>
#include <cmath>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <filesystem>
#include <iostream>
#include <memory>

#include "core/error.hpp"
#include "daemon/alarm_book.hpp"
#include "daemon/alarm_json.hpp"
#include "daemon/control.hpp"
#include "daemon/pictures.hpp"
#include "daemon/service.hpp"
#include "daemon/tool.hpp"
#include "numerics/statistics.hpp"
#include "report/plot.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kTrendRuns = 200;  // of the picture, the latest up to the last bad one
constexpr std::int64_t kShownEvents = 20;

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

AlarmStatus alarm_of(const Store& store, std::int64_t id) {
  for (AlarmStatus& alarm : store.alarm_states())
    if (alarm.id == id && id > 0) return std::move(alarm);
  throw Error(Cause::kInput, "no alarm " + std::to_string(id) + " in " + store.path() +
                                 "; 'ballbar alarms --all' shows all");
}

std::vector<StoredEvent> history_of(const Store& store, std::int64_t id) {
  EventFilter filter;
  filter.alarm_id = id;
  filter.states_only = false;
  filter.after_id = 0;  // in the order in which they happened
  std::vector<StoredEvent> events = store.events(filter);
  if (events.size() > kShownEvents) events.erase(events.begin(), events.end() - kShownEvents);
  return events;
}

/// The runs that the alarm's bad ones are among, oldest first.
std::vector<StoredRun> runs_of(const Store& store, const AlarmStatus& alarm) {
  if (alarm.runs.empty()) return {};
  RunFilter filter;
  filter.robot = alarm.key.robot;
  filter.test = alarm.key.test;
  filter.direction = alarm.key.direction;
  filter.status = "ok";
  filter.until_us = alarm.runs.back() + 1;
  filter.limit = kTrendRuns;
  filter.newest_first = true;
  filter.harmonic_orders = kAllHarmonicOrders;
  std::vector<StoredRun> runs = store.runs(filter);
  std::reverse(runs.begin(), runs.end());
  if (runs.empty()) return runs;
  const std::string source = runs.back().source;
  std::erase_if(runs, [&](const StoredRun& run) { return run.source != source; });
  return runs;
}

std::vector<double> values_of(const std::vector<StoredRun>& runs, const AlarmStatus& alarm,
                              const std::string& quantity, bool bad) {
  std::vector<double> values;
  for (const StoredRun& run : runs) {
    const bool is_bad = std::find(alarm.runs.begin(), alarm.runs.end(), run.started_us) != alarm.runs.end();
    for (const Record& record : run.records)
      if (const auto found = record.values.find(quantity);
          is_bad == bad && record.axis == alarm.key.axis && found != record.values.end())
        values.push_back(found->second.value);
  }
  return values;
}

/// @param values  at least one
double median(std::vector<double> values) {
  const auto middle = values.begin() + static_cast<std::ptrdiff_t>(values.size() / 2);
  std::nth_element(values.begin(), middle, values.end());
  return *middle;
}

/// Of the figures that the alarm stands on the one that the bad runs have moved most, against the spread of
/// the others: a vector may turn at the same length. "" where it stands on none.
std::string quantity_of(const AlarmStatus& alarm, const std::vector<StoredRun>& runs) {
  std::string best;
  double most = -1.0;
  for (const AlarmNumber& number : alarm.numbers) {
    const std::vector<double> bad = values_of(runs, alarm, number.name, true);
    if (number.of_rule || bad.empty()) continue;
    const std::vector<double> others = values_of(runs, alarm, number.name, false);
    double moved = 0.0;
    if (others.size() > 2) {
      const double usual = median(others);
      std::vector<double> away;
      away.reserve(others.size());
      for (const double value : others) away.push_back(std::abs(value - usual));
      moved = std::abs(mean(bad) - usual) / std::max(median(away), 1e-9);
    }
    if (moved <= most) continue;
    most = moved;
    best = number.name;
  }
  return best;
}

void draw(const Store& store, const AlarmStatus& alarm, const std::string& output) {
  const std::vector<StoredRun> runs = runs_of(store, alarm);
  const std::string quantity = quantity_of(alarm, runs);
  if (quantity.empty())
    throw Error(Cause::kInput, "alarm " + std::to_string(alarm.id) + " (" + alarm_name(alarm.key) +
                                   ") stands on no figure of a run, so there is no trend to draw");
  PictureOptions picture;
  picture.quantity = quantity;
  picture.axis = alarm.key.axis;
  picture.marked = alarm.runs;
  picture.marked_label = "runs that raised the alarm";
  const auto from_run = std::count_if(alarm.numbers.begin(), alarm.numbers.end(),
                                      [](const AlarmNumber& number) { return !number.of_rule; });
  for (const AlarmNumber& number :
       alarm.numbers)  // a limit of what the rule computes is none of its quantity
    if (from_run == 1 && number.of_rule && number.name == "limit_um" && quantity.ends_with("_um"))
      picture.limits_um.push_back(number.value);
  picture.notes = {"alarm " + std::to_string(alarm.id) + ": " + alarm_name(alarm.key) + ", " +
                       to_string(alarm.state) + " (" + alarm.severity + ") since " +
                       utc_text(alarm.since_us) + " UTC",
                   alarm.text};
  render(picture_of(PictureKind::kTrend, store, runs, picture), output);
}

void print_runs(const Store& store, const AlarmStatus& alarm) {
  const std::vector<StoredRun> runs = runs_of(store, alarm);
  if (alarm.runs.empty()) return;
  std::printf("  runs that raised it, one after another:\n");
  for (const std::int64_t started_us : alarm.runs) {
    const auto run = std::find_if(runs.begin(), runs.end(),
                                  [&](const StoredRun& r) { return r.started_us == started_us; });
    if (run == runs.end()) {
      std::printf("    begun %s UTC (no longer stored)\n", utc_text(started_us).c_str());
      continue;
    }
    std::printf("    %5lld  %s  %s %s", static_cast<long long>(run->id), utc_text(started_us).c_str(),
                run_name(run->test, run->direction, run->repetition).c_str(), run->series.c_str());
    for (const Record& record : run->records) {
      if (record.axis != alarm.key.axis) continue;
      for (const AlarmNumber& number : alarm.numbers)
        if (const auto found = record.values.find(number.name); found != record.values.end())
          std::printf("  %s %.1f", number.name.c_str(), found->second.value);
    }
    std::printf("\n");
  }
}

void print_history(const std::vector<StoredEvent>& events) {
  std::printf("  what happened:\n");
  for (const StoredEvent& stored : events) {
    const AlarmEvent& event = stored.event;
    std::string what = to_string(event.change);
    if (event.change == AlarmChange::kState)
      what = std::string(to_string(event.from)) + " -> " + to_string(event.status.state);
    if (event.change == AlarmChange::kShelved)
      what += " until " + utc_text(event.status.shelved.until_us) + " UTC";
    if (!event.by.empty()) what += " by " + event.by;
    const std::string& words = event.change == AlarmChange::kState ? event.status.text : event.comment;
    std::printf("    %s  %s%s%s\n", utc_text(event.at_us).c_str(), what.c_str(), words.empty() ? "" : ": ",
                words.c_str());
  }
}

int show(const AlarmsOptions& options) {
  const Store store = options.where.open();
  const AlarmStatus alarm = alarm_of(store, options.alarm);
  const std::vector<StoredEvent> events = history_of(store, alarm.id);
  if (options.json) {
    Json json = to_json(alarm);
    json["history"] = Json::array();
    for (const StoredEvent& event : events) json["history"].push_back(to_json(event));
    std::cout << text_of(json);
  } else {
    std::printf("alarm %lld: %s\n", static_cast<long long>(alarm.id), alarm_name(alarm.key).c_str());
    std::printf("  %s (%s) since %s UTC%s\n", to_string(alarm.state), alarm.severity.c_str(),
                utc_text(alarm.since_us).c_str(),
                alarm.flapping ? ", flapping: it fires on until it is quiet" : "");
    std::printf("  %s\n", alarm.text.c_str());
    if (!alarm.acknowledged.by.empty())
      std::printf("  acknowledged by %s, %s UTC: %s\n", alarm.acknowledged.by.c_str(),
                  utc_text(alarm.acknowledged.at_us).c_str(), alarm.acknowledged.comment.c_str());
    if (!alarm.shelved.by.empty())
      std::printf("  shelved by %s until %s UTC: %s\n", alarm.shelved.by.c_str(),
                  utc_text(alarm.shelved.until_us).c_str(), alarm.shelved.comment.c_str());
    std::printf("  %d bad runs in a row, %d clean ones since\n", alarm.bad_runs, alarm.clean_runs);
    for (const AlarmNumber& number : alarm.numbers) {
      std::printf("  %-34s %12.6g", number.name.c_str(), number.value);
      if (number.sd) std::printf(" +- %.3g", *number.sd);
      std::printf("%s\n", number.of_rule ? "  set in the rule" : "");
    }
    print_runs(store, alarm);
    print_history(events);
  }
  if (!options.output.empty()) draw(store, alarm, options.output);
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

/// "2026-03-11 18:00" or "2026-03-11", in UTC.
std::int64_t time_us(const std::string& text) {
  for (const char* form : {"%Y-%m-%d %H:%M:%S", "%Y-%m-%d %H:%M", "%Y-%m-%d", "%Y-%m-%dT%H:%M:%SZ"}) {
    std::tm parts{};
    const char* end = strptime(text.c_str(), form, &parts);
    if (end != nullptr && *end == '\0') return static_cast<std::int64_t>(timegm(&parts)) * 1'000'000;
  }
  throw Error(Cause::kInput, "--until takes a time in UTC: \"2026-03-11 18:00\"; not '" + text + "'");
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
        options.until.empty() ? now_us() + span_us(options.time_span) : time_us(options.until);
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
