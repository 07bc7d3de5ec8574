#include "daemon/alarm_show.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <vector>

#include "core/error.hpp"
#include "daemon/alarm_book.hpp"
#include "daemon/alarm_json.hpp"
#include "daemon/pictures.hpp"
#include "daemon/service.hpp"
#include "daemon/tool.hpp"
#include "numerics/statistics.hpp"
#include "numerics/trend.hpp"
#include "report/plot.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kTrendRuns = 200;  // of the picture, the latest up to the last bad one
constexpr std::int64_t kShownEvents = 20;

AlarmStatus alarm_of(const Store& store, std::int64_t id) {
  for (AlarmStatus& alarm : store.alarm_states())
    if (alarm.id == id && id > 0) return std::move(alarm);
  throw Error(Cause::kInput, "no alarm " + std::to_string(id) + " in " + store.path() +
                                 "; 'ballbar alarms --all' shows all");
}

std::vector<StoredEvent> events_of_alarm(const Store& store, std::int64_t id) {
  EventFilter filter;
  filter.alarm_id = id;
  filter.states_only = false;
  filter.after_id = INT64_MIN;  // in the order in which they happened
  std::vector<StoredEvent> events = store.events(filter);
  if (events.size() > kShownEvents) events.erase(events.begin(), events.end() - kShownEvents);
  return events;
}

/// The runs that the alarm's bad ones are among, oldest first.
std::vector<StoredRun> runs_of_alarm(const Store& store, const AlarmStatus& alarm) {
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
      moved = std::abs(mean(bad) - median(others)) / std::max(median_spread(others), 1e-9);
    }
    if (moved <= most) continue;
    most = moved;
    best = number.name;
  }
  return best;
}

void draw_alarm(const Store& store, const AlarmStatus& alarm, const std::string& output) {
  const std::vector<StoredRun> runs = runs_of_alarm(store, alarm);
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
  const std::vector<StoredRun> runs = runs_of_alarm(store, alarm);
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

}  // namespace

void show_alarm(const Store& store, std::int64_t id, bool json_wanted, const std::string& output) {
  const AlarmStatus alarm = alarm_of(store, id);
  const std::vector<StoredEvent> events = events_of_alarm(store, alarm.id);
  if (json_wanted) {
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
  if (!output.empty()) draw_alarm(store, alarm, output);
}

}  // namespace ballbar
