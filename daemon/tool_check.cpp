/// ballbar rules check, rules test, config check

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iostream>
#include <memory>
#include <sstream>

#include "core/error.hpp"
#include "daemon/service.hpp"
#include "daemon/tool.hpp"
#include "daemon/tool_rules.hpp"
#include "gap/commanded_path.hpp"
#include "metrology/signatures.hpp"
#include "pipeline/catalogue.hpp"
#include "rules/names.hpp"
#include "rules/past_records.hpp"
#include "rules/rule_set.hpp"
#include "rules/rule_test.hpp"
#include "rules/sandbox.hpp"
#include "rules/subjects.hpp"
#include "rules/text.hpp"

namespace ballbar {
namespace {

struct CheckOptions {
  std::string config_path = kDefaultConfig;
  std::string directory;
};

std::vector<std::filesystem::path> rule_folders(const CheckOptions& options) {
  if (!options.directory.empty()) return {options.directory};
  return load_config(options.config_path).rule_folders();
}

/// Where the file that counts lies.
std::string folder_of(const std::vector<std::filesystem::path>& folders, const RuleError& error) {
  std::error_code none;
  return (std::filesystem::exists(folders.back() / error.file, none) ? folders.back() : folders.front())
      .string();
}

/// A result with every quantity that its kind can have, a little different each time.
Record full_record(const std::string& kind, int repetition) {
  Record record;
  if (kind == "gap") {
    GapRecord gap;
    gap.verdict = "explained";
    gap.rms_before = 1e-6;
    gap.left_out.push_back({"joint_zero_offset", "", 1, 1, 0.5, 100.0});
    record = gap_record(gap);
  }
  record.robot = "robot";
  record.test = "test";
  record.series = "series";
  record.kind = kind;
  record.axis = kind == "line" ? "X" : "";
  record.status = "ok";
  record.direction = kind == "test" ? 0 : 1;
  record.repetition = repetition;
  record.started_us = repetition * 60'000'000LL;
  std::vector<std::string> names = own_quantities(kind);
  for (const Quantity& quantity : catalogue()) names.emplace_back(quantity.name);
  for (int order = 1; order <= 30; ++order)
    for (const std::string prefix : {"harmonic", "gap_harmonic"})
      for (const char* part : {"_um", "_cos_um", "_sin_um"})
        names.push_back(prefix + std::to_string(order) + part);
  for (const bool radial : {false, true})
    for (const std::string& name : signature_names()) names.push_back(signature_quantity(name, radial));
  const double step =
      0.01 * static_cast<double>((static_cast<std::size_t>(repetition) * 7 + names.size()) % 5);
  double value = 1.0;
  for (const std::string& name : names)
    if (is_quantity_of(name, kind)) record.values[name] = {value += step, 0.1};
  return record;
}

/// What a rule says when it is asked, without history and with much of it: a misspelt name inside `when`
/// shows only then.
std::optional<RuleError> try_rule(const Rule& rule) {
  constexpr int kEarlier = 150;  // more than any baseline
  const Record record = full_record(rule.kind, kEarlier + 1);
  std::vector<Record> earlier;
  for (int i = 1; i <= kEarlier; ++i) earlier.push_back(full_record(rule.kind, i));
  try {
    judge(rule, record, {});
    PastRecords past(record, earlier, {});
    judge(rule, record, past);
  } catch (const ScriptError& error) {
    return RuleError{rule.name, rule.source.file, error.line(), error.what()};
  }
  return {};
}

/// "DIRECTORY/x.lua:12: message" and below it line 12.
void print_error(const std::string& directory, const RuleError& error) {
  std::cout << directory << "/" << to_string(error) << "\n";
  std::ifstream file(directory + "/" + error.file);
  std::ostringstream source;
  source << file.rdbuf();
  const std::string text = text_of_line(source.str(), error.line);
  if (!text.empty()) std::cout << "    " << text << "\n";
}

int check_rules(const CheckOptions& options) {
  const std::vector<std::filesystem::path> folders = rule_folders(options);
  const LoadReport report = RuleSet::load_folders(folders);
  for (const RuleError& error : report.errors) print_error(folder_of(folders, error), error);
  std::size_t errors = report.errors.size();
  for (const Rule& rule : report.rules.rules()) {
    const std::optional<RuleError> error = try_rule(rule);
    if (!error) {
      std::cout << rule.source.file << ": " << rule.name << " is good\n";
      continue;
    }
    ++errors;
    print_error(folder_of(folders, *error), *error);
  }
  const std::size_t loaded = report.rules.rules().size();
  std::cout << loaded + report.errors.size() - errors << " rules good, " << errors << " errors\n";
  if (loaded == 0 && errors == 0)
    std::cout << folders.back().string() << " holds no rule: nothing will be watched\n";
  return errors == 0 ? 0 : 1;
}

int test_rules(const CheckOptions& options) {
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
    for (const RuleError& failure : report.failures) print_error(table.parent_path().string(), failure);
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
int check_config(const CheckOptions& options) {
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
  auto options = std::make_shared<CheckOptions>();
  const auto add = [options, &action](CLI::App* parent, const std::string& name, const std::string& about,
                                      int (*verb)(const CheckOptions&)) {
    CLI::App* sub = parent->add_subcommand(name, about);
    sub->add_option("--config", options->config_path, "configuration file")->capture_default_str();
    sub->callback([options, verb, &action] { action = [options, verb] { return verb(*options); }; });
    return sub;
  };
  CLI::App* rules = app.add_subcommand("rules", "check and test rule files, and try them on what is stored");
  rules->require_subcommand(1);
  add_rule_history(*rules, action);
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
