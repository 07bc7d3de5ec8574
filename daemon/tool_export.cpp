/// ballbar export

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>

#include "bus/encode.hpp"
#include "bus/log_writer.hpp"
#include "bus/run_messages.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "daemon/json_out.hpp"
#include "daemon/service.hpp"
#include "daemon/tool.hpp"
#include "pipeline/catalogue.hpp"

namespace ballbar {
namespace {

struct ExportOptions {
  Where where;
  Choice choice;
  std::string trace_of;
  std::string log;
  bool json = false;
  bool csv = false;
};

/// A field of a CSV line; quotes where a label needs them.
std::string field(const std::string& text) {
  if (text.find_first_of(",\"\n\r") == std::string::npos) return text;
  std::string quoted = "\"";
  for (const char c : text) quoted += c == '"' ? std::string("\"\"") : std::string(1, c);
  return quoted + "\"";
}

std::string digits(double value) {
  char text[40];
  std::snprintf(text, sizeof text, "%.17g", value);
  return text;
}

/// Each once; some are of circles and of lines.
std::vector<std::string> quantity_names() {
  std::vector<std::string> names;
  for (const Quantity& quantity : catalogue())
    if (std::find(names.begin(), names.end(), quantity.name) == names.end())
      names.emplace_back(quantity.name);
  return names;
}

void print_results(const std::vector<StoredRun>& runs) {
  std::cout << "id,run,robot,test,kind,direction,repetition,series,started_us,ended_us,status,angle_source,"
               "source,plane,predicted_from,axis";
  const std::vector<std::string> names = quantity_names();
  for (const std::string& name : names) std::cout << ',' << name;
  std::cout << '\n';
  for (const StoredRun& run : runs)
    for (const Record& record : run.records) {
      std::cout << run.id << ',' << field(run_name(run.test, run.direction, run.repetition)) << ','
                << field(run.robot) << ',' << field(run.test) << ',' << record.kind << ',' << run.direction
                << ',' << run.repetition << ',' << field(run.series) << ',' << run.started_us << ','
                << run.ended_us << ',' << run.status << ',' << run.angle_source << ',' << run.source << ','
                << field(run.plane) << ',' << run.predicted_from << ',' << record.axis;
      for (const std::string& name : names) {
        const auto found = record.values.find(name);
        std::cout << ',' << (found == record.values.end() ? "" : digits(found->second.value));
      }
      std::cout << '\n';
    }
}

void print_trace(const Trace& trace) {
  if (!trace.readings.empty()) {
    std::cout << "time_s,axis,position_mm,deviation_um\n";
    for (const InterferometerReading& r : trace.readings)
      std::cout << digits(r.time) << ',' << r.axis << ',' << digits(to_mm(r.position)) << ','
                << digits(to_um(r.deviation)) << '\n';
    return;
  }
  std::cout << "time_s,angle_deg,deviation_um,predicted_um,in_measured_arc\n";
  for (std::size_t i = 0; i < trace.bar_time.size(); ++i) {
    std::cout << digits(trace.bar_time[i]) << ',';
    if (i < trace.angle.size() && trace.angle[i] == trace.angle[i])
      std::cout << digits(to_deg(trace.angle[i]));
    std::cout << ',' << digits(to_um(trace.bar_deviation[i])) << ',';
    if (i < trace.predicted.size() && trace.predicted[i] == trace.predicted[i])
      std::cout << digits(to_um(trace.predicted[i]));
    std::cout << ',' << (i >= trace.arc_begin && i < trace.arc_end) << '\n';
  }
}

void write_log(const Store& store, const std::vector<StoredRun>& runs, const std::string& path) {
  LogWriter log(path);
  RunMessages messages;
  std::map<std::string, const StoredRun*> last;  // by robot
  std::int64_t arrival_us = 0;
  std::size_t left_out = 0;
  for (const StoredRun& stored : runs) {
    if (stored.end != RunEnd::kMark && stored.end != RunEnd::kAborted) {
      ++left_out;
      continue;
    }
    const StoredRun*& before = last[stored.robot];
    if (before && before->ended_us > stored.started_us)
      throw Error(Cause::kInput, "run " + std::to_string(stored.id) + " of robot '" + stored.robot +
                                     "' begins before run " + std::to_string(before->id) +
                                     " ends, and one log cannot hold both; choose by --test or --series");
    before = &stored;
    for (const Sample& sample : messages.of(run_of(stored, store.trace(stored.id)))) {
      const auto time_us = std::visit([](const auto& s) { return s.header.time_us; }, sample);
      arrival_us = std::max(arrival_us, time_us);
      log.write(encode(sample), arrival_us);
    }
  }
  const std::size_t written = runs.size() - left_out;
  if (written == 0)
    throw Error(Cause::kInput, "no run that ended with a mark fits; 'ballbar list' shows all runs");
  log.keep();
  std::cout << path << ": " << written << " runs, " << log.events() << " messages";
  if (left_out > 0) std::cout << "; " << left_out << " runs that did not end with a mark are not in it";
  std::cout << "\n";
}

int run(const ExportOptions& options) {
  const Store store = options.where.open();
  if (!options.trace_of.empty()) {
    print_trace(store.trace(find_run(store, options.trace_of).id));
    return 0;
  }
  const std::vector<StoredRun> runs = options.choice.runs(store);
  if (!options.log.empty()) {
    write_log(store, runs, options.log);
    return 0;
  }
  if (options.csv) {
    print_results(runs);
    return 0;
  }
  Json all = Json::array();
  for (const StoredRun& stored : runs) all.push_back(to_json(stored));
  std::cout << text_of(Json{{"runs", all}});
  return 0;
}

}  // namespace

void add_export(CLI::App& app, Action& action) {
  auto options = std::make_shared<ExportOptions>();
  CLI::App* verb = app.add_subcommand(
      "export",
      "results as JSON or CSV, or one recording as CSV, to standard output; or recordings as an LCM log");
  options->where.add_to(*verb);
  options->choice.add_to(*verb);
  CLI::Option* json =
      verb->add_flag("--json", options->json, "{\"runs\": [...]}, each as 'show --json' (default)");
  CLI::Option* csv = verb->add_flag("--csv", options->csv, "one line per circle, and per axis of a line");
  CLI::Option* trace = verb->add_option("--trace", options->trace_of, "the recording of this run as CSV");
  CLI::Option* log = verb->add_option(
      "--lcm", options->log, "the recordings as this LCM log, for replay: all that ended with a mark");
  json->excludes(csv)->excludes(trace)->excludes(log);
  csv->excludes(trace)->excludes(log);
  trace->excludes(log);
  verb->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace ballbar
