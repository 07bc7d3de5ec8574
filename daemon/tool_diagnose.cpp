/// ballbar diagnose

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>

#include "core/error.hpp"
#include "core/units.hpp"
#include "daemon/diagnosis_out.hpp"
#include "daemon/diagnosis_page.hpp"
#include "daemon/model_baseline.hpp"
#include "daemon/pages.hpp"
#include "daemon/plan_out.hpp"
#include "daemon/replay.hpp"
#include "daemon/series_diagnosis.hpp"
#include "daemon/service.hpp"
#include "daemon/since_when.hpp"
#include "daemon/tool.hpp"
#include "daemon/tool_diagnose_poses.hpp"
#include "daemon/urdf_out.hpp"
#include "gap/diagnose.hpp"
#include "gap/next_test.hpp"
#include "pipeline/process.hpp"

namespace ballbar {
namespace {

struct DiagnoseOptions {
  Where where;
  std::vector<std::string> logs;
  std::vector<std::string> series, hold_out;
  std::string robot, model_out, mastering, urdf_out, output, picture = "map", poses;
  std::vector<std::string> only;  ///< tests; empty: all
  std::vector<std::string> effects;
  std::optional<double> payload;  ///< [kg] of planned tests
  std::size_t tests = 4;          ///< to be planned
  bool json = false, plan = false, plan_lines = false, since_when = false, against_baseline = false;
};

/// Circles and lines of the robot that can be diagnosed; the others are said.
void check_tests(const char* option, const std::vector<std::string>& tests, const RobotSpec& robot) {
  for (const std::string& test : tests)
    if (!robot.find_test(test))
      throw Error(Cause::kInput,
                  std::string(option) + " " + test + ": robot '" + robot.name + "' has no such test");
}

bool wanted(const DiagnoseOptions& options, const std::string& test) {
  return options.only.empty() ||
         std::find(options.only.begin(), options.only.end(), test) != options.only.end();
}

std::vector<MeasuredRun> measured_in_logs(const DiagnoseOptions& options, const Config& config,
                                          const Models& models, const RobotSpec& robot) {
  std::vector<MeasuredRun> measured;
  const auto take = [&](Run run) {
    const TestSpec* test = robot.find_test(run.test);
    if (run.robot != robot.name || !test || run.kind != test->kind || !wanted(options, run.test)) return;
    RunResult result = run.kind == TestKind::kCircle ? locate(run, *test, models.at(robot.name).model())
                                                     : process(run, *test, nullptr);
    if (run.direction == 0) run.direction = result.direction;
    if (result.status == "ok" && (run.kind == TestKind::kLine || result.angle_source == "joints"))
      return measured.push_back({std::move(run), std::move(result.angle), result.arc_begin, result.arc_end});
    std::cerr << "ballbar: " << run_name(run.test, run.direction, run.repetition) << " is not used: "
              << (result.status != "ok" ? result.status + ": " + result.message : "no joints were heard")
              << "\n";
  };
  for (const std::string& path : options.logs) {
    const LogFile log = inspect_log(path);
    read_runs(log, config.robots, models, take);
    if (!log.whole())
      std::cerr << "ballbar: " << path << ": damaged behind byte " << log.good_bytes
                << ", what lies before is used\n";
  }
  return measured;
}

std::vector<MeasuredRun> measured_in_store(const DiagnoseOptions& options, const RobotSpec& robot) {
  const Store store = options.where.open();
  std::vector<MeasuredRun> measured;
  for (const std::string& series : options.series) {
    RunFilter filter;
    filter.robot = robot.name;
    filter.series = series;
    filter.status = "ok";
    const std::size_t before = measured.size();
    for (const StoredRun& stored : store.runs(filter))
      if (wanted(options, stored.test) && can_be_diagnosed(stored))
        measured.push_back(measured_run(store, stored));
    if (measured.size() == before)
      throw Error(Cause::kInput,
                  "series '" + series + "' of robot '" + robot.name +
                      "' holds no circle or line with readings and joints; see ballbar list --series");
  }
  return measured;
}

/// The robot with what is configured and what was found, as far as a model predicts it.
AsBuilt as_found(const AsBuilt& built, RobotSpec robot, const Diagnosis& diagnosis) {
  for (EffectSpec& effect : found_effects(diagnosis)) robot.effects.push_back(std::move(effect));
  return AsBuilt(built.model(), robot);
}

void draw(const DiagnoseOptions& options, const RobotSpec& robot, const Diagnosis& diagnosis) {
  std::string title = robot.name;
  for (const std::string& series : options.series) title += "   " + series;
  if (options.output.ends_with(".html"))
    write_page(options.output, diagnosis_page(diagnosis, title));
  else
    render(diagnosis_picture(diagnosis, title, options.picture), options.output);
}

int run_since_when(const DiagnoseOptions& options) {
  if (!options.logs.empty() || !options.series.empty() || !options.poses.empty())
    throw Error(Cause::kInput,
                "--since-when looks at all runs of the database: choose with --robot and --test");
  const Config config = config_of_robot(options.where.config_path, options.robot);
  const RobotSpec& robot = config.robots.front();
  check_tests("--test", options.only, robot);
  if (options.only.size() > 1)
    throw Error(Cause::kInput,
                "--since-when looks at one --test, or at all, not at " + std::to_string(options.only.size()));
  const Models models = load_models(config);
  const SinceWhen found = since_when(options.where.open(), robot, models.at(robot.name),
                                     options.only.empty() ? "" : options.only.front());
  if (options.json)
    std::cout << to_json(found).dump(2) << "\n";
  else
    std::cout << to_text(found);
  return found.changes.empty() ? 0 : 1;
}

/// The configured robot, or, against its baseline, as it was then.
RobotSpec robot_of(const DiagnoseOptions& options, const RobotSpec& configured) {
  if (!options.against_baseline) return configured;
  const std::optional<ModelBaseline> baseline = options.where.open().model_baseline(configured.name);
  if (!baseline)
    throw Error(Cause::kInput, "robot '" + configured.name +
                                   "' has no baseline; make one with ballbar baseline keep --series S");
  std::cerr << "ballbar: against the baseline of series '" << baseline->series << "', "
            << utc_text(baseline->ended_us) << " UTC: what is named has changed since\n";
  return with_baseline(configured, *baseline);
}

/// Circles and lines that the robot can drive.
std::vector<ProposedTest> reachable(const DiagnoseOptions& options, const GapModel& model,
                                    const std::vector<Observation>& driven) {
  PlanScope scope = scope_of(driven);
  scope.payload = options.payload;
  scope.lines = options.plan_lines;
  ProgressLine line("reachable tests");
  return proposed_tests(model, scope, line.progress());
}

/// Tests that would tell most of the catalogue, or of --effects, apart beside those that were driven.
int plan_robot(const DiagnoseOptions& options, const GapModel& model,
               const std::vector<Observation>& driven) {
  const std::vector<Suspect> suspects = suspects_of(model, options.effects);
  if (suspects.size() < 2)
    throw Error(Cause::kInput,
                "--effects: give two or more effects to be told apart, e.g. servo_lag:2,servo_lag:3");
  const std::vector<ProposedTest> proposed = reachable(options, model, driven);
  if (proposed.empty())
    throw Error(Cause::kInput, "robot '" + model.spec().name +
                                   "' has no test that it can drive and that holds its tool in a known way "
                                   "(tool_rpy_deg): there is no place to plan tests about");
  ProgressLine line("tests weighed");
  const RobotPlan plan = plan_for_robot(model, driven, suspects, proposed, options.tests, line.progress());
  std::cout << (options.json ? to_json(plan).dump(2) + "\n" : to_text(plan));
  return 0;
}

/// The configured tests as if they had been driven.
std::vector<Observation> as_configured(const GapModel& model) {
  std::vector<Observation> all;
  const PlannedNoise noise({});
  int set_up = 0;
  for (const TestSpec& test : model.spec().tests) {
    TestSpec driven = test;
    driven.circle.overshoot = std::max(test.circle.overshoot, 60.0 * kRadPerDeg);
    try {
      for (Observation& seen : as_observed(model, driven, set_up, noise.of(driven)))
        all.push_back(std::move(seen));
      set_up += set_ups_of(test);
    } catch (const Error& error) {
      std::cerr << "ballbar: " << error.what() << "; it is not counted\n";
    }
  }
  return all;
}

/// The next test for each pair that was not told apart.
std::vector<PairPlan> plan_pairs(const DiagnoseOptions& options, const GapModel& model,
                                 const std::vector<Observation>& driven, const Diagnosis& diagnosis) {
  const std::vector<ProposedTest> proposed = reachable(options, model, driven);
  ProgressLine line("tests weighed");
  return plan_for(model, driven, diagnosis, proposed, line.progress());
}

int run(const DiagnoseOptions& options) {
  if (options.since_when) return run_since_when(options);
  if (options.plan && options.logs.empty() && options.series.empty() && options.poses.empty()) {
    const Config config = config_of_robot(options.where.config_path, options.robot);
    const Models models = load_models(config);
    const GapModel model(models.at(config.robots.front().name), config.robots.front());
    return plan_robot(options, model, as_configured(model));
  }
  const int sources = int{!options.logs.empty()} + int{!options.series.empty()} + int{!options.poses.empty()};
  if (sources != 1)
    throw Error(Cause::kInput,
                "say what to diagnose: one or more LOG, or --series of the database, or --poses FILE");
  if (!options.poses.empty()) {
    if (!options.model_out.empty() || !options.mastering.empty() || !options.urdf_out.empty() ||
        !options.output.empty())
      throw Error(Cause::kInput,
                  "--model-out, --mastering, --urdf-out and -o are of circles and lines; with --poses, "
                  "--json has all "
                  "figures");
    return diagnose_poses_file(
        {options.poses, options.where.config_path, options.robot, options.hold_out, options.json});
  }
  const Config config = config_of_robot(options.where.config_path, options.robot);
  const RobotSpec robot = robot_of(options, config.robots.front());
  check_tests("--hold-out", options.hold_out, robot);
  check_tests("--test", options.only, robot);
  const Models models = load_models(config);
  const AsBuilt built(models.at(robot.name).model(), robot);
  DiagnosisInput input =
      diagnosis_input(options.logs.empty() ? measured_in_store(options, robot)
                                           : measured_in_logs(options, config, models, robot),
                      robot, built, options.hold_out);
  for (const std::string& sentence : input.left_aside) std::cerr << "ballbar: " << sentence << "\n";
  const GapModel model(built, robot);
  if (options.plan && !options.effects.empty()) return plan_robot(options, model, input.fitted);
  Diagnosis diagnosis = diagnose(model, input.fitted, input.held_out, input.noise);
  std::vector<PairPlan> plans;
  if (has_twins(diagnosis)) plans = plan_pairs(options, model, input.fitted, diagnosis);
  suggest(plans, diagnosis);
  if (options.plan && plans.empty()) return plan_robot(options, model, input.fitted);
  if (!options.model_out.empty()) write_text(options.model_out, model_tables(diagnosis));
  if (!options.mastering.empty()) write_text(options.mastering, mastering_table(diagnosis));
  if (!options.urdf_out.empty())
    write_text(options.urdf_out,
               as_built_urdf(read_text(robot.urdf_path), robot, as_found(built, robot, diagnosis)));
  if (!options.output.empty()) draw(options, robot, diagnosis);
  if (options.json) {
    auto json = to_json(diagnosis);
    if (options.plan) json["next_tests"] = to_json(plans);
    std::cout << json.dump(2) << "\n";
  } else {
    std::cout << to_text(diagnosis) << (options.plan ? to_text(plans) : "");
  }
  return diagnosis.verdict == Verdict::kNothingMissing || diagnosis.verdict == Verdict::kExplained ? 0 : 1;
}

}  // namespace

void add_diagnose(CLI::App& app, Action& action) {
  auto options = std::make_shared<DiagnoseOptions>();
  CLI::App* verb = app.add_subcommand(
      "diagnose", "the gap: where model and recording part, and which physics was left out");
  verb->add_option("LOG", options->logs, "logs, as lcm-logger writes them");
  verb->add_option("--series", options->series, "series of the database instead")->delimiter(',');
  verb->add_option(
      "--poses", options->poses,
      "static poses measured from outside instead, CSV: q1_deg.. and x_mm,y_mm,z_mm or length_mm");
  verb->add_flag("--since-when", options->since_when,
                 "instead: after which run of the database the robot was another, and what that looks like");
  verb->add_option("--test", options->only, "only of these tests; with --since-when of one")->delimiter(',');
  verb->add_flag("--against-baseline", options->against_baseline,
                 "explain what has changed since ballbar baseline keep");
  verb->add_option("--robot", options->robot, "of this robot, where several are configured");
  verb->add_option(
          "--hold-out", options->hold_out,
          "tests that are not fitted but used as proof; series whose names "
          "end in -held-out are held out by themselves; with --poses: series, or blocks, random, each")
      ->delimiter(',');
  verb->add_flag(
      "--plan", options->plan,
      "which circles, and lines where one is configured, to drive next: for each pair that was not told "
      "apart, or, without LOG, beside the configured tests for the whole robot; as [[robot.test]] tables");
  verb->add_flag("--plan-lines", options->plan_lines,
                 "with --plan: lines of straightness optics too, where none is configured");
  verb->add_option("--effects", options->effects,
                   "with --plan: only these effects, EFFECT or EFFECT:JOINT: servo_lag:2,servo_lag:3")
      ->delimiter(',');
  verb->add_option("--plan-tests", options->tests, "with --plan for a whole robot: how many tests")
      ->check(CLI::Range(1, 20))
      ->capture_default_str();
  verb->add_option("--plan-payload-kg", options->payload,
                   "with --plan: of tests with payload; else the heaviest configured one, or 2 kg more")
      ->check(CLI::Range(0.0, 5000.0));
  verb->add_flag("--json", options->json, "as JSON");
  verb->add_option("--model-out", options->model_out, "write [[robot.effect]] tables of what was found");
  verb->add_option("--mastering", options->mastering,
                   "write the corrections of the joints' zeros in degrees");
  verb->add_option("--urdf-out", options->urdf_out,
                   "write the URDF of the robot as built: zeros, lengths, twists and tool as found");
  verb->add_option("-o,--output", options->output,
                   "page with all pictures (.html), or one picture (.svg or .png)");
  verb->add_option(
          "--picture", options->picture,
          "with -o x.svg: map (what is left by arc and condition), lines (the same of lines), shares, "
          "or a test: before and after")
      ->capture_default_str();
  options->where.add_to(*verb);
  verb->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace ballbar
