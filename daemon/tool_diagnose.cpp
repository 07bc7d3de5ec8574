/// ballbar diagnose

#include <iostream>
#include <memory>

#include "core/error.hpp"
#include "daemon/diagnosis_out.hpp"
#include "daemon/replay.hpp"
#include "daemon/service.hpp"
#include "daemon/tool.hpp"
#include "daemon/tool_diagnose_poses.hpp"
#include "gap/diagnose.hpp"
#include "pipeline/process.hpp"

namespace ballbar {
namespace {

struct Options {
  Where where;
  std::vector<std::string> logs;
  std::vector<std::string> series, hold_out;
  std::string robot, model_out, mastering, poses;
  bool json = false;
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

int run(const Options& options) {
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
    throw Error(Cause::kInput, "no circle with bar and joints of robot '" + robot.name +
                                   "' is there to be fitted; see which runs there are with ballbar list");
  const NoiseLevel noise = assign_noise(fitted);
  assign_noise(held_out);
  const Diagnosis diagnosis = diagnose(GapModel(built, robot), fitted, held_out, noise);
  if (!options.model_out.empty()) write_text(options.model_out, model_tables(diagnosis));
  if (!options.mastering.empty())
    write_text(options.mastering,
               mastering_table(diagnosis, robot.joint_convention == JointConvention::kFanuc));
  if (options.json)
    std::cout << to_json(diagnosis).dump(2) << "\n";
  else
    std::cout << to_text(diagnosis);
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
  verb->add_flag("--json", options->json, "as JSON");
  verb->add_option("--model-out", options->model_out, "write [[robot.effect]] tables of what was found");
  verb->add_option("--mastering", options->mastering,
                   "write the corrections of the joints' zeros in degrees");
  options->where.add_to(*verb);
  verb->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace ballbar
