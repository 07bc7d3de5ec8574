/// ballbar diagnose

#include <algorithm>
#include <iostream>
#include <memory>
#include <optional>

#include "core/error.hpp"
#include "core/units.hpp"
#include "daemon/diagnosis_out.hpp"
#include "daemon/plan_out.hpp"
#include "daemon/replay.hpp"
#include "daemon/service.hpp"
#include "daemon/tool.hpp"
#include "daemon/tool_diagnose_poses.hpp"
#include "gap/diagnose.hpp"
#include "gap/next_test.hpp"
#include "pipeline/process.hpp"

namespace ballbar {
namespace {

struct Options {
  Where where;
  std::vector<std::string> logs;
  std::vector<std::string> series, hold_out;
  std::string robot, model_out, mastering, poses;
  std::vector<std::string> effects;
  std::optional<double> payload;  ///< [kg] of planned tests
  std::size_t tests = 4;          ///< to be planned
  bool json = false, plan = false;
};

/// Circles of the robot that can be diagnosed; the others are said.
std::vector<MeasuredRun> measured_in_logs(const Options& options, const Config& config, const Models& models,
                                          const RobotSpec& robot) {
  std::vector<MeasuredRun> measured;
  const auto take = [&](Run run) {
    const TestSpec* test = robot.find_test(run.test);
    if (run.robot != robot.name || !test || run.kind != TestKind::kCircle) return;
    RunResult result = process(run, *test, &models.at(robot.name));
    if (run.direction == 0) run.direction = result.direction;
    if (result.status == "ok" && result.angle_source == "joints")
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

std::vector<MeasuredRun> measured_in_store(const Options& options, const RobotSpec& robot) {
  const Store store = options.where.open();
  std::vector<MeasuredRun> measured;
  for (const std::string& series : options.series) {
    RunFilter filter;
    filter.robot = robot.name;
    filter.series = series;
    filter.status = "ok";
    filter.kind = TestKind::kCircle;
    const std::size_t before = measured.size();
    for (const StoredRun& stored : store.runs(filter)) {
      if (stored.source != "bar" || stored.angle_source != "joints") continue;
      Trace trace = store.trace(stored.id);
      MeasuredRun one{{}, std::move(trace.angle), trace.arc_begin, trace.arc_end};
      one.run = run_of(stored, std::move(trace));
      measured.push_back(std::move(one));
    }
    if (measured.size() == before)
      throw Error(Cause::kInput, "series '" + series + "' of robot '" + robot.name +
                                     "' holds no circle with bar and joints; see ballbar list --series");
  }
  return measured;
}

bool is_held_out(const Observation& seen, const Options& options) {
  if (seen.series.ends_with(kHeldOutEnding)) return true;
  for (const std::string& test : options.hold_out)
    if (seen.test == test) return true;
  return false;
}

/// Tests that would tell most of the catalogue, or of --effects, apart beside those that were driven.
int plan_robot(const Options& options, const GapModel& model, const std::vector<Observation>& driven) {
  const std::vector<Suspect> suspects = suspects_of(model, options.effects);
  if (suspects.size() < 2)
    throw Error(Cause::kInput,
                "--effects: give two or more effects to be told apart, e.g. servo_lag:2,servo_lag:3");
  std::vector<ProposedTest> proposed;
  {
    ProgressLine line("reachable circles");
    proposed = proposed_tests(model, options.payload, line.progress());
  }
  if (proposed.empty())
    throw Error(Cause::kInput, "robot '" + model.spec().name +
                                   "' has no circle that it can drive and that holds its tool in a known way "
                                   "(tool_rpy_deg): there is no place to plan tests about");
  ProgressLine line("tests weighed");
  const RobotPlan plan = plan_for_robot(model, driven, suspects, proposed, options.tests, line.progress());
  std::cout << (options.json ? to_json(plan).dump(2) + "\n" : to_text(plan));
  return 0;
}

/// The configured circles as if they had been driven.
std::vector<Observation> as_configured(const GapModel& model) {
  std::vector<Observation> all;
  int set_up = 0;
  for (const TestSpec& test : model.spec().tests) {
    if (test.kind != TestKind::kCircle) continue;
    TestSpec driven = test;
    driven.circle.overshoot = std::max(test.circle.overshoot, 60.0 * kRadPerDeg);
    try {
      for (Observation& seen : as_observed(model, driven, set_up, lap_noise_of({})))
        all.push_back(std::move(seen));
      ++set_up;
    } catch (const Error& error) {
      std::cerr << "ballbar: " << error.what() << "; it is not counted\n";
    }
  }
  return all;
}

/// The next test for each pair that was not told apart.
std::vector<PairPlan> plan_pairs(const Options& options, const GapModel& model,
                                 const std::vector<Observation>& driven, const Diagnosis& diagnosis) {
  std::vector<ProposedTest> proposed;
  {
    ProgressLine line("reachable circles");
    proposed = proposed_tests(model, options.payload, line.progress());
  }
  ProgressLine line("tests weighed");
  return plan_for(model, driven, diagnosis, proposed, line.progress());
}

int run(const Options& options) {
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
    if (!options.model_out.empty() || !options.mastering.empty())
      throw Error(Cause::kInput,
                  "--model-out and --mastering are of circles; with --poses, --json has all figures");
    return diagnose_poses_file(
        {options.poses, options.where.config_path, options.robot, options.hold_out, options.json});
  }
  const Config config = config_of_robot(options.where.config_path, options.robot);
  const RobotSpec& robot = config.robots.front();
  for (const std::string& test : options.hold_out)
    if (!robot.find_test(test))
      throw Error(Cause::kInput, "--hold-out " + test + ": robot '" + robot.name + "' has no such test");
  const Models models = load_models(config);
  const AsBuilt& built = models.at(robot.name);
  Observations observations = observe(options.logs.empty() ? measured_in_store(options, robot)
                                                           : measured_in_logs(options, config, models, robot),
                                      robot, built.model());
  for (const std::string& sentence : observations.left_aside) std::cerr << "ballbar: " << sentence << "\n";
  std::vector<Observation> fitted, held_out;
  for (Observation& seen : observations.all)
    (is_held_out(seen, options) ? held_out : fitted).push_back(std::move(seen));
  if (fitted.empty())
    throw Error(
        Cause::kInput,
        "no circle with bar and joints of robot '" + robot.name +
            "' is there to be fitted; where all were said to be not used for wrong_path, "
            "this is a recording of another robot or tool; see which runs there are with ballbar list");
  const NoiseLevel noise = assign_noise(fitted);
  assign_noise(held_out);
  const GapModel model(built, robot);
  if (options.plan && !options.effects.empty()) return plan_robot(options, model, fitted);
  Diagnosis diagnosis = diagnose(model, fitted, held_out, noise);
  std::vector<PairPlan> plans;
  const bool twins = std::any_of(diagnosis.left_out.begin(), diagnosis.left_out.end(),
                                 [](const LeftOut& one) { return !one.twins.empty(); });
  if (twins) plans = plan_pairs(options, model, fitted, diagnosis);
  suggest(plans, diagnosis);
  if (options.plan && plans.empty()) return plan_robot(options, model, fitted);
  if (!options.model_out.empty()) write_text(options.model_out, model_tables(diagnosis));
  if (!options.mastering.empty())
    write_text(options.mastering,
               mastering_table(diagnosis, robot.joint_convention == JointConvention::kFanuc));
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
  auto options = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand(
      "diagnose", "the gap: where model and recording part, and which physics was left out");
  verb->add_option("LOG", options->logs, "logs, as lcm-logger writes them");
  verb->add_option("--series", options->series, "series of the database instead")->delimiter(',');
  verb->add_option(
      "--poses", options->poses,
      "static poses measured from outside instead, CSV: q1_deg.. and x_mm,y_mm,z_mm or length_mm");
  verb->add_option("--robot", options->robot, "of this robot, where several are configured");
  verb->add_option(
          "--hold-out", options->hold_out,
          "tests that are not fitted but used as proof; series whose names "
          "end in -held-out are held out by themselves; with --poses: series, or blocks, random, each")
      ->delimiter(',');
  verb->add_flag(
      "--plan", options->plan,
      "which circles to drive next: for each pair that was not told apart, or, without LOG, beside the "
      "configured circles for the whole robot; as [[robot.test]] tables");
  verb->add_option("--effects", options->effects,
                   "with --plan: only these effects, EFFECT or EFFECT:JOINT: servo_lag:2,servo_lag:3")
      ->delimiter(',');
  verb->add_option("--plan-tests", options->tests, "with --plan for a whole robot: how many circles")
      ->check(CLI::Range(1, 20))
      ->capture_default_str();
  verb->add_option("--plan-payload-kg", options->payload,
                   "with --plan: of circles with payload; else the heaviest configured one, or 2 kg more")
      ->check(CLI::Range(0.0, 5000.0));
  verb->add_flag("--json", options->json, "as JSON");
  verb->add_option("--model-out", options->model_out, "write [[robot.effect]] tables of what was found");
  verb->add_option("--mastering", options->mastering,
                   "write the corrections of the joints' zeros in degrees");
  options->where.add_to(*verb);
  verb->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace ballbar
