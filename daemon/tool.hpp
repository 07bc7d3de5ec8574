#pragma once
/// The verbs of `ballbar`. Each file tool_*.cpp adds its verbs to the command line.

#include <CLI/CLI.hpp>
#include <functional>
#include <string>
#include <vector>

#include "daemon/config.hpp"
#include "store/store.hpp"

namespace ballbar {

/// What the chosen verb does; set while the command line is read. @return exit code
using Action = std::function<int()>;

/// --config and --db, wherever they make sense.
struct Where {
  std::string config_path = kDefaultConfig;
  std::string db_path;
  void add_to(CLI::App& verb);

  /// The configuration; [store] path is replaced by --db.
  Config config() const;
  /// The database for reading, from --db or else the configuration.
  Store open() const;
};

/// The configuration with the chosen robot alone, so that nothing else is read.
/// @param robot  may be empty where one is configured
/// @throws Error(kInput) where there is none of that name, or it is not clear which, naming those that are
Config config_of_robot(const std::string& config_path, const std::string& robot);

/// "2026-03-11", "2026-03-11 09:00" or as time_us_from(), UTC without a zone; or "30d": so long before
/// `now_us`.
/// @throws Error(kInput)
std::int64_t time_of(const std::string& text, std::int64_t now_us);
std::int64_t now_us();

/// --robot, --test, --series, --limit.
struct Choice {
  std::string robot, test, series;
  std::int64_t limit = 0;
  void add_to(CLI::App& verb);
  RunFilter filter() const;
  /// The chosen runs, oldest first. @param status  only these; empty: all
  std::vector<StoredRun> runs(const Store& store, const std::string& status = "") const;
};

/// The run that a person means: its id, or its name ("A+1#2", "SERIES:A+1#2"; the latest one where several
/// have it).
/// @throws Error(kInput) where there is none, with the nearest thing to do
StoredRun find_run(const Store& store, const std::string& text);

/// RUN ..., or else those that --robot, --test, --series, --limit choose.
struct RunChoice {
  std::vector<std::string> names;
  Choice choice;
  void add_to(CLI::App& verb);
  /// Named ones in their sequence, chosen ones oldest first.
  /// @param status  of the chosen ones only these; empty: all
  /// @param verb    for the error: "plot"
  /// @throws Error(kInput) where there is none
  std::vector<StoredRun> runs(const Store& store, const std::string& status, const std::string& verb) const;
};

/// "2026-03-11 09:00:00" in UTC.
std::string utc_text(std::int64_t time_us);

void add_replay(CLI::App& app, Action& action);
void add_import(CLI::App& app, Action& action);
void add_show(CLI::App& app, Action& action);    ///< list, show
void add_alarms(CLI::App& app, Action& action);  ///< alarms, alarms show, ack, shelve, unshelve
void add_export(CLI::App& app, Action& action);
void add_summary(CLI::App& app, Action& action);
void add_plot(CLI::App& app, Action& action);
void add_report(CLI::App& app, Action& action);
void add_compare(CLI::App& app, Action& action);
void add_simulate(CLI::App& app, Action& action);
void add_diagnose(CLI::App& app, Action& action);
void add_baseline(CLI::App& app, Action& action);
void add_db(CLI::App& app, Action& action);
void add_check(CLI::App& app, Action& action);  ///< rules check, rules test, config check

}  // namespace ballbar
