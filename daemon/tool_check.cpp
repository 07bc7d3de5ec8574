/// ballbar rules check, rules test, config check

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <memory>

#include "core/error.hpp"
#include "daemon/service.hpp"
#include "daemon/tool.hpp"
#include "gap/commanded_path.hpp"
#include "metrology/signatures.hpp"
#include "pipeline/catalogue.hpp"
#include "rules/rule_set.hpp"
#include "rules/rule_test.hpp"
#include "rules/sandbox.hpp"

namespace ballbar {
namespace {

struct Options {
  std::string config_path = kDefaultConfig;
  std::string directory;
};

std::vector<std::filesystem::path> rule_folders(const Options& options) {
  if (!options.directory.empty()) return {options.directory};
  return load_config(options.config_path).rule_folders();
}

/// The error with the folder of the file that counts.
std::string located(const std::vector<std::filesystem::path>& folders, const RuleError& error) {
  std::filesystem::path folder = folders.back();
  std::error_code none;
  if (!std::filesystem::exists(folder / error.file, none)) folder = folders.front();
  return folder.string() + "/" + to_string(error);
}

/// A result with every quantity that its kind can have.
Record full_record(const std::string& kind, int repetition) {
  Record record;
  record.robot = "robot";
  record.test = "test";
  record.series = "series";
  record.kind = kind;
  record.axis = kind == "line" ? "X" : "";
  record.status = "ok";
  record.direction = 1;
  record.repetition = repetition;
  for (const Quantity& quantity : catalogue())
    if (quantity.kind == kind || quantity.kind == "run")
      record.values[std::string(quantity.name)] = {1.0, {}};
  for (int order = 1; kind == "circle" && order <= 30; ++order)
    for (const char* part : {"_um", "_cos_um", "_sin_um"})
      record.values["harmonic" + std::to_string(order) + part] = {1.0, {}};
  if (kind == "circle")
    for (const bool radial : {false, true})
      for (const std::string& name : signature_names())
        record.values[signature_quantity(name, radial)] = {1.0, 0.1};
  return record;
}

/// What a rule says when it is asked, without history and with much of it: a misspelt name inside `when`
/// shows only then.
std::optional<RuleError> try_rule(const Rule& rule) {
  const Record record = full_record(rule.kind, 100);
  History long_history;
  for (int i = 1; i < 60; ++i) {
    if (i <= 20) long_history.series_first.push_back(full_record(rule.kind, i));
    long_history.recent.push_back(full_record(rule.kind, i));
  }
  try {
    judge(rule, record, {});
    judge(rule, record, long_history);
  } catch (const ScriptError& error) {
    return RuleError{rule.name, rule.source.file, error.line(), error.what()};
  }
  return {};
}

int check_rules(const Options& options) {
  const std::vector<std::filesystem::path> folders = rule_folders(options);
  const LoadReport report = RuleSet::load_folders(folders);
  for (const RuleError& error : report.errors) std::cout << located(folders, error) << "\n";
  std::size_t errors = report.errors.size();
  for (const Rule& rule : report.rules.rules()) {
    const std::optional<RuleError> error = try_rule(rule);
    if (error) ++errors;
    std::cout << (error ? located(folders, *error) : rule.source.file + ": " + rule.name + " is good")
              << "\n";
  }
  const std::size_t loaded = report.rules.rules().size();
  std::cout << loaded + report.errors.size() - errors << " rules good, " << errors << " errors\n";
  if (loaded == 0 && errors == 0)
    std::cout << folders.back().string() << " holds no rule: nothing will be watched\n";
  return errors == 0 ? 0 : 1;
}

int test_rules(const Options& options) {
  std::vector<std::filesystem::path> tables;
  for (const std::filesystem::path& folder : rule_folders(options)) {
    std::error_code error;
    for (const auto& entry : std::filesystem::directory_iterator(folder, error))
      if (entry.path().filename().string().ends_with("_test.lua")) tables.push_back(entry.path());
    if (error)
      throw Error(Cause::kInput, folder.string() + ": " + error.message() + "; give the folder of the rules");
  }
  std::sort(tables.begin(), tables.end());
  std::size_t failures = 0;
  for (const auto& table : tables) {
    const RuleTestReport report = run_rule_test(table);
    for (const RuleError& failure : report.failures)
      std::cout << table.parent_path().string() << "/" << to_string(failure) << "\n";
    if (report.failures.empty()) std::cout << report.file << ": " << report.rows << " rows passed\n";
    failures += report.failures.size();
  }
  std::cout << tables.size() << " tables, " << failures << " failures\n";
  return failures == 0 ? 0 : 1;
}

/// Whether the nominal robot can drive the test, both ways. @return one line for people where it cannot
std::string why_not_driven(const RobotModel& model, const TestSpec& test) {
  constexpr double kAnyFeed = 0.05;  // [m/s] where none is configured: the path is the same
  constexpr double kRate = 25.0;     // [1/s]: two millimetres of path
  constexpr double kDwell = 0.1;     // [s]
  const double feed = test.feed > 0.0 ? test.feed : kAnyFeed;
  try {
    for (const int direction : {1, -1}) {
      if (test.kind == TestKind::kCircle)
        commanded_circle(model, test, direction, feed, kRate);
      else
        commanded_line(model, test, direction, feed, kDwell, kRate);
    }
  } catch (const Error& error) {
    return error.what();
  }
  return "";
}

/// Everything that the service would read at its start, and whether the robots can drive their tests.
int check_config(const Options& options) {
  const Config config = load_config(options.config_path);
  const Models models = load_models(config);
  bool good = true;
  for (const RobotSpec& robot : config.robots) {
    const RobotModel& model = models.at(robot.name).model();
    std::cout << "robot " << robot.name << ": " << robot.tests.size() << " tests, " << model.joints()
              << " joints from " << robot.base << " to " << robot.tip << "\n";
    for (const TestSpec& test : robot.tests) {
      const std::string why = why_not_driven(model, test);
      std::cout << "  " << (why.empty() ? "test " + test.name + ": the robot can drive it" : why) << "\n";
      good = good && why.empty();
    }
  }
  std::cout << options.config_path
            << (good ? " is good\n" : " can be read, but its tests have no prediction\n");
  return good ? 0 : 1;
}

}  // namespace

void add_check(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  const auto add = [options, &action](CLI::App* parent, const std::string& name, const std::string& about,
                                      int (*verb)(const Options&)) {
    CLI::App* sub = parent->add_subcommand(name, about);
    sub->add_option("--config", options->config_path, "configuration file")->capture_default_str();
    sub->callback([options, verb, &action] { action = [options, verb] { return verb(*options); }; });
    return sub;
  };
  CLI::App* rules = app.add_subcommand("rules", "check and test rule files");
  rules->require_subcommand(1);
  add(rules, "check", "load every rule of the folder and say what is wrong", check_rules)
      ->add_option("DIRECTORY", options->directory, "folder of the rules (default: the configured one)");
  add(rules, "test", "run the tables *_test.lua beside the rules", test_rules)
      ->add_option("DIRECTORY", options->directory, "folder of the rules (default: the configured one)");
  CLI::App* config = app.add_subcommand("config", "check the configuration");
  config->require_subcommand(1);
  CLI::App* check = add(config, "check", "read the configuration and every URDF it names", check_config);
  check->add_option("FILE", options->config_path, "configuration file");
}

}  // namespace ballbar
