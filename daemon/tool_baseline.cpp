/// ballbar baseline

#include <cstdint>
#include <iostream>
#include <memory>

#include "core/error.hpp"
#include "core/units.hpp"
#include "daemon/diagnosis_out.hpp"
#include "daemon/model_baseline.hpp"
#include "daemon/series_diagnosis.hpp"
#include "daemon/service.hpp"
#include "daemon/tool.hpp"
#include "gap/diagnose.hpp"

namespace ballbar {
namespace {

struct BaselineOptions {
  Where where;
  std::string robot, series, test, at, note;
};

std::vector<MeasuredRun> measured(const Store& store, const RobotSpec& robot, const std::string& series,
                                  std::int64_t& ended_us) {
  constexpr std::int64_t kAllOfIt = INT64_MAX;
  std::vector<MeasuredRun> runs;
  for (const StoredRun& run : latest_measurement(store, robot.name, series, kAllOfIt, SIZE_MAX)) {
    if (!robot.find_test(run.test)) continue;
    runs.push_back(measured_run(store, run));
    ended_us = std::max(ended_us, run.ended_us);
  }
  if (runs.empty())
    throw Error(Cause::kInput,
                "series '" + series + "' of robot '" + robot.name +
                    "' holds no circle or line with readings and joints; see ballbar list --series");
  return runs;
}

int keep(const BaselineOptions& options) {
  Config config = config_of_robot(options.where.config_path, options.robot);
  if (!options.where.db_path.empty()) config.store_path = options.where.db_path;
  const RobotSpec& robot = config.robots.front();
  const Models models = load_models(config);
  const AsBuilt& built = models.at(robot.name);
  std::int64_t ended_us = 0;
  const DiagnosisInput input = diagnosis_input(
      measured(Store::open_read_only(config.store_path), robot, options.series, ended_us), robot, built, {});
  const Diagnosis diagnosis = diagnose(GapModel(built, robot), input.fitted, input.held_out, input.noise);
  std::cout << to_text(diagnosis);
  if (diagnosis.verdict == Verdict::kUnknownEffect || diagnosis.verdict == Verdict::kPartlyExplained) {
    std::cerr
        << "ballbar: this series is not explained, so it is no baseline: find out first what is there\n";
    return 1;
  }
  Store(config.store_path).set_model_baseline(model_baseline_of(robot, diagnosis, options.series, ended_us));
  std::cout << "\nKept as the baseline of " << robot.name
            << ": ballbar diagnose --against-baseline explains what has changed since.\n";
  return 0;
}

int show(const BaselineOptions& options) {
  const Config config = config_of_robot(options.where.config_path, options.robot);
  const RobotSpec& robot = config.robots.front();
  const std::optional<ModelBaseline> baseline = options.where.open().model_baseline(robot.name);
  if (!baseline)
    throw Error(Cause::kInput,
                "robot '" + robot.name + "' has no baseline; make one with ballbar baseline keep --series S");
  std::cout << "# " << robot.name << ": series " << baseline->series << ", ended "
            << utc_text(baseline->ended_us) << " UTC, noise " << baseline->noise_floor / kMetresPerUm
            << " um\n"
            << effect_tables(with_baseline(robot, *baseline).effects);
  return 0;
}

int set(const BaselineOptions& options) {
  Config config = config_of_robot(options.where.config_path, options.robot);
  if (!options.where.db_path.empty()) config.store_path = options.where.db_path;
  const RobotSpec& robot = config.robots.front();
  if (!options.test.empty() && robot.find_test(options.test) == nullptr)
    throw Error(Cause::kInput, "robot " + robot.name + " has no test '" + options.test + "'");
  const std::int64_t at_us = options.at.empty() ? now_us() : time_of(options.at, now_us());
  Store store(config.store_path);
  store.set_baseline({robot.name, options.test, at_us, options.note});
  std::cout << "baseline of " << robot.name
            << (options.test.empty() ? ", all tests" : ", test " + options.test) << ": the first runs from "
            << utc_text(at_us) << " (UTC) on\n";
  return 0;
}

int list(const BaselineOptions& options) {
  const Store store = options.where.open();
  for (const BaselineMark& mark : store.baselines())
    std::cout << utc_text(mark.at_us) << "  " << mark.robot << "  "
              << (mark.test.empty() ? "all tests" : mark.test) << "  " << mark.note << "\n";
  return 0;
}

}  // namespace

void add_baseline(CLI::App& app, Action& action) {
  auto options = std::make_shared<BaselineOptions>();
  CLI::App* verb = app.add_subcommand(
      "baseline", "what later runs and diagnoses of a robot are held against, after a calibration");
  verb->require_subcommand(1);
  const auto does = [&](const char* name, const char* what, int (*action_of)(const BaselineOptions&)) {
    CLI::App* each = verb->add_subcommand(name, what);
    each->add_option("--robot", options->robot, "of this robot, where several are configured");
    options->where.add_to(*each);
    each->callback(
        [options, action_of, &action] { action = [options, action_of] { return action_of(*options); }; });
    return each;
  };
  CLI::App* setting =
      does("set", "the rules' baseline \"calibration\" begins anew, as after a repair or calibration", set);
  setting->add_option("--test", options->test, "only this test (default: all)");
  setting->add_option("--at", options->at,
                      "from this time on (default: now): 2026-03-11, or \"2026-03-11 09:00:00\" (UTC)");
  setting->add_option("--note", options->note, "why");
  does("list", "the baselines of rules that were set", list);
  does("keep", "diagnose a series and keep the whole fitted model, for diagnose --against-baseline", keep)
      ->add_option("--series", options->series, "the series that was measured at commissioning")
      ->required();
  does("show", "the model that was kept, as [[robot.effect]] tables", show);
}

}  // namespace ballbar
