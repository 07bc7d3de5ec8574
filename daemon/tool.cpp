#include "daemon/tool.hpp"

#include <algorithm>
#include <chrono>
#include <ctime>
#include <filesystem>
#include <optional>
#include <sstream>
#include <utility>

#include "core/error.hpp"
#include "daemon/service.hpp"
#include "files/numbers.hpp"

namespace ballbar {

void Where::add_to(CLI::App& verb) {
  verb.add_option("--config", config_path, "configuration file")->capture_default_str();
  verb.add_option("--db", db_path, "database file instead of the configured one");
}

Config Where::config() const {
  Config config = load_config(config_path);
  if (!db_path.empty()) config.store_path = db_path;
  return config;
}

Store Where::open() const {
  if (!db_path.empty()) return Store::open_read_only(db_path);
  std::error_code error;
  if (config_path == kDefaultConfig && !std::filesystem::exists(config_path, error))
    throw Error(Cause::kInput,
                std::string("no database named: give --db FILE or --config FILE (there is no ") +
                    kDefaultConfig + ")");
  return Store::open_read_only(load_config(config_path).store_path);
}

Config config_of_robot(const std::string& config_path, const std::string& robot) {
  Config config = load_config(config_path);
  std::string names;
  for (const RobotSpec& each : config.robots) names += (names.empty() ? "" : ", ") + each.name;
  if (config.robots.empty()) throw Error(Cause::kInput, config_path + ": no [[robot]] is configured");
  if (robot.empty() && config.robots.size() > 1)
    throw Error(Cause::kInput, config_path + ": choose one robot with --robot: " + names);
  std::erase_if(config.robots, [&](const RobotSpec& each) { return !robot.empty() && each.name != robot; });
  if (config.robots.empty())
    throw Error(Cause::kInput, config_path + ": no robot '" + robot + "'; there is " + names);
  return config;
}

std::int64_t time_of(const std::string& text, std::int64_t now_us) {
  constexpr std::int64_t kDayUs = 86'400'000'000;
  std::istringstream days(text);
  std::int64_t number = 0;
  std::string rest;
  if (days >> number >> rest && rest == "d" && number >= 0 && number < 100'000)
    return now_us - number * kDayUs;
  constexpr std::size_t kDateOnly = 10;  // characters
  const std::optional<std::int64_t> time_us = time_us_from(text.size() == kDateOnly ? text + " 00:00" : text);
  if (!time_us)
    throw Error(Cause::kInput,
                "'" + text + "' is no time; write 2026-03-11, \"2026-03-11 09:00\" (UTC) or 30d (ago)");
  return *time_us;
}

std::int64_t now_us() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

void Choice::add_to(CLI::App& verb) {
  verb.add_option("--robot", robot, "only of this robot");
  verb.add_option("--test", test, "only of this test");
  verb.add_option("--series", series, "only of this series");
  verb.add_option("--limit", limit, "only the latest N")->check([](const std::string& text) {
    const bool whole =
        !text.empty() && text.size() < 18 && text.find_first_not_of("0123456789") == std::string::npos;
    return whole ? std::string() : "'" + text + "' is no number of runs; give a whole number, 0 for all";
  });
}

RunFilter Choice::filter() const {
  RunFilter filter;
  if (!robot.empty()) filter.robot = robot;
  if (!test.empty()) filter.test = test;
  if (!series.empty()) filter.series = series;
  filter.limit = limit;
  filter.newest_first = limit > 0;
  return filter;
}

std::vector<StoredRun> Choice::runs(const Store& store, const std::string& status) const {
  RunFilter wanted = filter();
  if (!status.empty()) wanted.status = status;
  std::vector<StoredRun> found = store.runs(wanted);
  if (wanted.newest_first) std::reverse(found.begin(), found.end());
  return found;
}

namespace {

/// The latest run of this name, of this series where one is given.
std::optional<StoredRun> latest_named(const Store& store, const std::string& name,
                                      const std::optional<std::string>& series) {
  const std::size_t sign = name.find_last_of("+-", name.rfind('#'));
  if (sign == std::string::npos) return {};
  RunFilter filter;
  filter.series = series;
  filter.test = name.substr(0, sign);
  filter.newest_first = true;
  for (StoredRun& run : store.runs(filter))
    if (run_name(run.test, run.direction, run.repetition) == name) return std::move(run);
  return {};
}

}  // namespace

StoredRun find_run(const Store& store, const std::string& text) {
  RunFilter filter;
  if (!text.empty() && text.find_first_not_of("0123456789") == std::string::npos && text.size() < 18) {
    filter.ids = {std::stoll(text)};
    std::vector<StoredRun> runs = store.runs(filter);
    if (runs.empty())
      throw Error(Cause::kInput,
                  "no run with id " + text + " in " + store.path() + "; 'ballbar list' shows all");
    return std::move(runs.front());
  }
  if (std::optional<StoredRun> run = latest_named(store, text, {})) return std::move(*run);
  // A series may hold colons, and so may a test.
  for (std::size_t colon = text.find(':'); colon != std::string::npos; colon = text.find(':', colon + 1))
    if (std::optional<StoredRun> run = latest_named(store, text.substr(colon + 1), text.substr(0, colon)))
      return std::move(*run);
  throw Error(Cause::kInput,
              "no run '" + text + "' in " + store.path() +
                  "; name one by its id or as A+1#2 or SERIES:A+1#2; 'ballbar list' shows all");
}

void RunChoice::add_to(CLI::App& verb) {
  verb.add_option("RUN", names,
                  "ids or names: A+1#2, SERIES:A+1#2; none: all that --test, --series ... choose");
  choice.add_to(verb);
}

std::vector<StoredRun> RunChoice::runs(const Store& store, const std::string& status,
                                       const std::string& verb) const {
  std::vector<StoredRun> found;
  for (const std::string& name : names) found.push_back(find_run(store, name));
  if (names.empty()) found = choice.runs(store, status);
  if (found.empty())
    throw Error(Cause::kInput,
                "nothing to " + verb +
                    ": name runs, or choose some with --test and --series; 'ballbar list' shows all");
  return found;
}

std::string utc_text(std::int64_t time_us) {
  const std::time_t seconds = time_us / 1'000'000;
  std::tm parts{};
  gmtime_r(&seconds, &parts);
  char text[32];
  std::strftime(text, sizeof text, "%Y-%m-%d %H:%M:%S", &parts);
  return text;
}

}  // namespace ballbar
