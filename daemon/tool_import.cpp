/// ballbar import

#include <cmath>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>

#include "core/error.hpp"
#include "daemon/import.hpp"
#include "daemon/service.hpp"
#include "daemon/tool.hpp"

namespace ballbar {
namespace {

struct ImportArguments {
  Where where;
  ImportOptions what;
  std::string columns, separator, decimal = "point";
};

Error taken(const std::string& path, const std::string& by, const Run& run) {
  return {Cause::kInput, path + ": " + by + " of robot '" + run.robot + "' begins at " +
                             utc_text(run.started_us) +
                             " UTC too, and a run is known by robot and begin: give another --started"};
}

/// A stored run as far as it says whether a recording is the same.
Run stored_run(const Store& store, const StoredRun& stored) {
  const Trace trace = store.trace(stored.id);
  Run run;
  run.robot = stored.robot;
  run.test = stored.test;
  run.kind = stored.kind;
  run.direction = stored.direction;
  run.repetition = stored.repetition;
  run.bar_deviation = trace.bar_deviation;
  run.readings = trace.readings;
  return run;
}

/// Two recordings with one identity: the second would be lost without a word.
void check_identities(const std::vector<Import>& imports, const std::string& db) {
  std::map<std::int64_t, std::pair<std::string, const Run*>> seen;  // of one robot
  for (const Import& import : imports)
    for (const Run& run : import.runs) {
      const auto [known, is_new] = seen.try_emplace(run.started_us, import.path, &run);
      if (!is_new && !same_recording(run, *known->second.second))
        throw taken(import.path, "a run in " + known->second.first, run);
    }
  std::error_code error;
  if (!std::filesystem::exists(db, error)) return;
  const Store store = Store::open_read_only(db);
  for (const Import& import : imports)
    for (const Run& run : import.runs) {
      RunFilter filter;
      filter.robot = run.robot;
      filter.since_us = run.started_us;
      filter.until_us = run.started_us + 1;
      for (const StoredRun& stored : store.runs(filter))
        if (!same_recording(run, stored_run(store, stored)))
          throw taken(import.path,
                      "the stored run " + run_name(stored.test, stored.direction, stored.repetition) +
                          ", another recording,",
                      run);
    }
}

int run(ImportArguments options) {
  if (!options.columns.empty()) options.what.csv.columns = csv_columns_from(options.columns);
  if (!options.separator.empty())
    options.what.csv.separator = options.separator == "tab"         ? '\t'
                                 : options.separator == "semicolon" ? ';'
                                                                    : ',';
  options.what.csv.decimal = options.decimal == "comma" ? ',' : '.';
  const Config config = options.where.config();
  Models models = load_models(config);
  // All files are read, and all identities are free, before the database is touched.
  const std::vector<Import> imports = read_imports(options.what, config);
  check_identities(imports, config.store_path);
  Store store(config.store_path);
  const auto print = [](Priority, const std::string& line) { std::cout << line << "\n"; };
  LoadReport rules = load_rules(config);
  for (const RuleError& error : rules.errors) std::cerr << "ballbar: " << to_string(error) << "\n";
  Service service(config, std::move(models), std::move(rules.rules), store, print);
  for (const Import& import : imports) {
    std::cout << import.path << ": " << import.about << "\n";
    for (const Run& found : import.runs) service.on_run(found);
  }
  const ServiceCounters& counters = service.counters();
  std::cout << counters.runs_stored << " runs stored, " << counters.runs_ok << " of them ok, "
            << counters.runs_known << " already known; database " << store.path() << "\n";
  if (service.waiting() > 0)
    throw Error(Cause::kWorld,
                std::to_string(service.waiting()) + " runs could not be stored in " + store.path());
  return 0;
}

std::string not_negative(const std::string& text) {
  const double value = std::atof(text.c_str());
  return std::isfinite(value) && value >= 0.0 ? "" : "'" + text + "' is not a finite number of 0 or more";
}

void add_labels(CLI::App& verb, ImportArguments& options) {
  ImportOptions& what = options.what;
  verb.add_option("--robot", what.robot, "name of the configured robot, where there are several");
  verb.add_option("--test", what.test, "name of the configured test (.b5r: else as the file names it)");
  verb.add_option("--direction", what.direction, "of a CSV; a .b5r says it itself")
      ->check(CLI::IsMember({"ccw", "cw", "forward", "backward"}));
  verb.add_option(
      "--started", what.started,
      "when the recording began, as 2026-03-11T09:00:00Z (.b5r: else its DATE_STARTED; without zone "
      "it is UTC). Robot and begin are what a run is known by");
  verb.add_option("--repetition", what.repetition, "of the first file; each further one counts one more")
      ->check(CLI::Range(0, 1'000'000))
      ->capture_default_str();
  verb.add_option("--series", what.series, "free label");
  verb.add_option("--feed-mm-s", what.feed_mm_s, "programmed speed, where it is not the configured one")
      ->check(not_negative);
  verb.add_option("--payload-kg", what.payload_kg, "on the flange, where it is not the configured one")
      ->check(not_negative);
  verb.add_option("--temperature-c", what.temperature_c, "of the test")->check(CLI::Range(-100.0, 200.0));
  verb.add_flag("--with-overshoot", what.with_overshoot,
                "the readings of a circle hold the overshoots too, not only the measured arc");
}

void add_format(CLI::App& verb, ImportArguments& options) {
  verb.add_option(
      "--unit", options.what.csv.unit,
      "of the deviations: m, mm, um, nm or in; needed for a .b5r, and for a CSV whose column does not "
      "say it");
  verb.add_option(
      "--columns", options.columns,
      "CSV: which column, by number or name, holds what, e.g. time_s=1,deviation_um=2 for a bar, "
      "position_mm=1,deviation_um=2,axis=3 for an interferometer. Else the first line says it so");
  verb.add_option("--axis", options.what.axis, "of a line's deviation, where no column says it")
      ->check(CLI::IsMember({"X", "Y", "Z"}));
  verb.add_option("--separator", options.separator,
                  "CSV: else the first of tab, semicolon, comma in the first line")
      ->check(CLI::IsMember({"comma", "semicolon", "tab"}));
  verb.add_option("--decimal", options.decimal, "CSV: point or comma")
      ->check(CLI::IsMember({"point", "comma"}))
      ->capture_default_str();
  verb.add_option("--skip", options.what.csv.skip, "CSV: so many lines before the first one that counts")
      ->check(CLI::Range(0, 10'000));
}

}  // namespace

void add_import(CLI::App& app, Action& action) {
  auto options = std::make_shared<ImportArguments>();
  CLI::App* verb = app.add_subcommand("import",
                                      "readings of a ballbar (.b5r, CSV) or an interferometer (CSV) into the "
                                      "database, through the same path as "
                                      "live data; all files or none");
  verb->add_option("FILE", options->what.files, "each a .b5r, or a CSV of one run")->required();
  options->where.add_to(*verb);
  add_labels(*verb, *options);
  add_format(*verb, *options);
  verb->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace ballbar
