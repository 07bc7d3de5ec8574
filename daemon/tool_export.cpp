/// ballbar export

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>

#include "core/error.hpp"
#include "core/units.hpp"
#include "daemon/json_out.hpp"
#include "daemon/service.hpp"
#include "daemon/tool.hpp"
#include "pipeline/catalogue.hpp"

namespace ballbar {
namespace {

struct Options {
  Where where;
  Choice choice;
  std::string trace_of;
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
               "source,predicted_from,axis";
  const std::vector<std::string> names = quantity_names();
  for (const std::string& name : names) std::cout << ',' << name;
  std::cout << '\n';
  for (const StoredRun& run : runs)
    for (const Record& record : run.records) {
      std::cout << run.id << ',' << field(run_name(run.test, run.direction, run.repetition)) << ','
                << field(run.robot) << ',' << field(run.test) << ',' << record.kind << ',' << run.direction
                << ',' << run.repetition << ',' << field(run.series) << ',' << run.started_us << ','
                << run.ended_us << ',' << run.status << ',' << run.angle_source << ',' << run.source << ','
                << run.predicted_from << ',' << record.axis;
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

int run(const Options& options) {
  const Store store = options.where.open();
  if (!options.trace_of.empty()) {
    print_trace(store.trace(find_run(store, options.trace_of).id));
    return 0;
  }
  const std::vector<StoredRun> runs = options.choice.runs(store);
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
  auto options = std::make_shared<Options>();
  CLI::App* verb =
      app.add_subcommand("export", "results as JSON or CSV, or one recording as CSV, to standard output");
  options->where.add_to(*verb);
  options->choice.add_to(*verb);
  CLI::Option* json =
      verb->add_flag("--json", options->json, "{\"runs\": [...]}, each as 'show --json' (default)");
  CLI::Option* csv = verb->add_flag("--csv", options->csv, "one line per circle, and per axis of a line");
  CLI::Option* trace = verb->add_option("--trace", options->trace_of, "the recording of this run as CSV");
  json->excludes(csv)->excludes(trace);
  csv->excludes(trace);
  verb->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace ballbar
