/// ballbar diagnose

#include <chrono>
#include <cstdio>
#include <iostream>
#include <memory>

#include "bus/assembler.hpp"
#include "bus/decode.hpp"
#include "bus/log_file.hpp"
#include "bus/subscriber.hpp"
#include "core/error.hpp"
#include "daemon/service.hpp"
#include "daemon/tool.hpp"
#include "daemon/tool_diagnose_poses.hpp"
#include "gap/diagnose.hpp"
#include "gap/search.hpp"
#include "pipeline/process.hpp"

namespace ballbar {
namespace {

struct Options {
  Where where;
  std::vector<std::string> logs;
  PosesOptions poses;
};

int run(const Options& options) {
  if (!options.poses.poses_path.empty()) {
    PosesOptions poses = options.poses;
    poses.config_path = options.where.config_path;
    return diagnose_poses_file(poses);
  }
  const Config config = options.where.config();
  const Models models = load_models(config);
  std::vector<MeasuredRun> measured;
  std::vector<Run> finished;
  for (const std::string& path : options.logs) {
    const LogFile log = inspect_log(path);
    Assembler assembler(config.robots, {}, recogniser_of(models));
    Subscriber subscriber(log.url,
                          [&](Channel channel, std::span<const std::uint8_t> bytes, std::int64_t arrival_us) {
                            const Decoded decoded = decode(channel, bytes);
                            if (const Sample* sample = std::get_if<Sample>(&decoded))
                              assembler.take(*sample, arrival_us, finished);
                            assembler.tick(arrival_us, finished);
                          });
    while (subscriber.handle()) {
    }
    assembler.close_all(RunEnd::kSilence, finished);
  }
  const RobotSpec& robot = config.robots.front();
  const AsBuilt& built = models.at(robot.name);
  for (Run& one : finished) {
    const TestSpec* test = robot.find_test(one.test);
    const RunResult result = process(one, *test, &built);
    if (result.status != "ok") {
      std::cerr << one.test << ": " << result.status << "\n";
      continue;
    }
    measured.push_back({one, result.angle, result.arc_begin, result.arc_end});
  }
  const auto t0 = std::chrono::steady_clock::now();
  Observations observations = observe(std::move(measured), robot, built.model());
  for (const auto& s : observations.left_aside) std::cerr << s << "\n";
  const auto t1 = std::chrono::steady_clock::now();
  std::vector<Observation> fitted, held;
  for (Observation& seen : observations.all)
    (seen.series.ends_with("-held-out") ? held : fitted).push_back(std::move(seen));
  const NoiseLevel noise = assign_noise(fitted);
  std::printf("noise %.3f um lap %.3f z %.1f, %zu observations\n", noise.floor * 1e6, noise.lap * 1e6,
              noise.worst_band_z, fitted.size());
  const GapModel model(built, robot);
  const GapFitter fitter(model, fitted);
  const Found found = search_effects(fitter, candidates_for(model, fitted));
  const auto t2 = std::chrono::steady_clock::now();
  std::printf("observe %.0f ms, search %.0f ms\n", std::chrono::duration<double, std::milli>(t1 - t0).count(),
              std::chrono::duration<double, std::milli>(t2 - t1).count());
  return 0;
}

}  // namespace

void add_diagnose(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* verb =
      app.add_subcommand("diagnose", "the gap: which physics the model leaves out, and where it shows");
  verb->add_option("LOG", options->logs, "logs, as lcm-logger writes them");
  verb->add_option("--poses", options->poses.poses_path,
                   "static poses measured from outside (CSV: q1_deg.. and x_mm,y_mm,z_mm or length_mm)");
  verb->add_option("--robot", options->poses.robot, "which of the configured robots");
  verb->add_option("--hold-out", options->poses.hold_out,
                   "poses: series that are not fitted, or blocks, random, each");
  verb->add_flag("--json", options->poses.json, "as JSON");
  options->where.add_to(*verb);
  verb->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace ballbar
