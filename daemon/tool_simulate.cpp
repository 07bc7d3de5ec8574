/// ballbar simulate

#include <unistd.h>

#include <charconv>
#include <cstdint>
#include <cstdio>
#include <iostream>
#include <memory>
#include <optional>

#include "bus/channels.hpp"
#include "bus/log_writer.hpp"
#include "core/error.hpp"
#include "core/units.hpp"
#include "daemon/service.hpp"
#include "daemon/simulation.hpp"
#include "daemon/tool.hpp"
#include "gap/simulate.hpp"

namespace ballbar {
namespace {

struct SimulateArguments {
  std::string config_path = kDefaultConfig;
  std::string robot, direction = "both", ball = "set", output, picture;
  std::vector<std::string> effects;
  SimulateOptions simulate;
  double noise_um = 0.0;
  bool nominal = false;
  bool json = false;
};

class Progress {
 public:
  explicit Progress(std::size_t runs) : runs_(runs), terminal_(isatty(STDERR_FILENO) == 1) {}
  ~Progress() { clear(); }
  Progress(const Progress&) = delete;
  Progress& operator=(const Progress&) = delete;
  void next(const std::string& name) {
    ++done_;
    if (terminal_) std::fprintf(stderr, "\r\033[K%s: %zu of %zu runs", name.c_str(), done_, runs_);
  }
  void clear() const {
    if (terminal_) std::fputs("\r\033[K", stderr);
  }

 private:
  std::size_t runs_;
  std::size_t done_ = 0;
  bool terminal_;
};

std::vector<int> directions(const std::string& text) {
  if (text == "both") return {1, -1};
  return {text == "+1" ? 1 : -1};
}

/// Which of the simulated runs would not be ok.
struct NotOk {
  std::size_t runs = 0;
  std::size_t bad = 0;
  std::string first;

  void add(const std::string& name, const std::string& status, const std::string& message) {
    ++runs;
    if (status != "ok" && ++bad == 1) first = name + ": " + status + ": " + message;
  }
};

int run(SimulateArguments options) {
  options.simulate.directions = directions(options.direction);
  options.simulate.noise = options.noise_um * kMetresPerUm;
  options.simulate.ball = options.ball == "set"          ? BallPlacement::kSet
                          : options.ball == "programmed" ? BallPlacement::kProgrammed
                                                         : BallPlacement::kFitted;
  if (options.simulate.series.size() + 1 > static_cast<std::size_t>(kMaxNameBytes))
    throw Error(Cause::kInput, "--series: a label of " + std::to_string(options.simulate.series.size()) +
                                   " bytes is refused on the bus; at most " +
                                   std::to_string(kMaxNameBytes - 1));
  Config config = config_of_robot(options.config_path, options.robot);
  if (options.nominal) config.robots.front().effects.clear();
  const RobotSpec& robot = config.robots.front();
  const Models models = load_models(config);
  const AsBuilt& known = models.at(robot.name);  // as the daemon would predict it
  RobotSpec true_robot = robot;
  for (const std::string& text : options.effects) true_robot.effects.push_back(parse_effect(text));
  const AsBuilt as_built(known.model(), true_robot);
  if (robot.tests.empty() && options.simulate.tests.empty())
    throw Error(Cause::kInput, options.config_path + ": robot '" + robot.name + "' has no [[robot.test]]");

  if (!options.picture.empty()) SimulationPlot::joints_path(options.picture);
  std::optional<LogWriter> log;
  if (!options.output.empty()) log.emplace(options.output);
  const bool figures = options.json || (options.output.empty() && options.picture.empty());
  Simulation simulation(robot, known);
  SimulationPlot plot(robot, known.model());
  Json runs = Json::array();
  NotOk not_ok;
  const std::size_t tests =
      options.simulate.tests.empty() ? robot.tests.size() : options.simulate.tests.size();
  Progress progress(tests * options.simulate.directions.size() *
                    static_cast<std::size_t>(options.simulate.repetitions));
  simulate(as_built, robot, options.simulate, [&](const SimulatedRun& simulated) {
    const std::string name = run_name(simulated.test, simulated.direction, simulated.repetition);
    progress.next(name);
    if (log)
      for (const Sample& sample : simulated.samples) log->write(encode(sample), sent_us(sample));
    if (figures) {
      const Json& found = runs.emplace_back(simulation.analyse(simulated));
      not_ok.add(name, found["status"], found.value("message", ""));
    } else {
      const RunResult found = simulation.judge(simulated);
      not_ok.add(name, found.status, found.message);
    }
    if (!options.picture.empty()) plot.add(simulated);
  });
  progress.clear();
  if (!options.picture.empty()) plot.render(options.picture, options.simulate.series);
  if (log) log->keep();
  if (options.json)
    std::cout << text_of(Json{{"robot", robot.name},
                              {"effects", effects_json(true_robot.effects)},
                              {"ball", options.ball},
                              {"noise_um", options.noise_um},
                              {"seed", options.simulate.seed},
                              {"runs", runs}});
  else if (log)
    std::cout << options.output << ": " << log->events() << " messages\n";
  else if (options.picture.empty())
    print_simulation(runs);
  if (not_ok.bad == 0) return 0;
  std::fprintf(stderr, "ballbar: %zu of %zu simulated runs are not ok, first %s\n", not_ok.bad, not_ok.runs,
               not_ok.first.c_str());
  return 1;
}

std::string whole_number(const std::string& text, std::uint64_t least, std::uint64_t most) {
  std::uint64_t value = 0;
  const auto [end, error] = std::from_chars(text.data(), text.data() + text.size(), value);
  if (error == std::errc() && end == text.data() + text.size() && value >= least && value <= most) return {};
  return "'" + text + "' is no whole number of " + std::to_string(least) + " to " + std::to_string(most);
}

}  // namespace

void add_simulate(CLI::App& app, Action& action) {
  auto options = std::make_shared<SimulateArguments>();
  CLI::App* verb = app.add_subcommand(
      "simulate", "what the instruments would publish of a robot with known errors that drives its tests");
  verb->add_option("--config", options->config_path, "configuration file")->capture_default_str();
  verb->add_option("--robot", options->robot, "this robot, where several are configured");
  verb->add_option("--test", options->simulate.tests, "only these tests, in this sequence: A,B,Y")
      ->delimiter(',');
  verb->add_option("--direction", options->direction, "both, +1 (counter-clockwise, forward) or -1")
      ->check(CLI::IsMember({"both", "+1", "-1"}))
      ->capture_default_str();
  verb->add_option("--repetitions", options->simulate.repetitions, "of each test and direction")
      ->check([](const std::string& text) { return whole_number(text, 1, 1000); })
      ->capture_default_str();
  verb->add_option("--effect", options->effects,
                   "physics of this robot beside the configured [[robot.effect]]; may be repeated: "
                   "joint_zero_offset,joint=3,offset_deg=0.172")
      ->allow_extra_args(false);
  verb->add_flag("--nominal", options->nominal, "leave the configured [[robot.effect]] out");
  verb->add_option(
          "--centre", options->ball,
          "where the ball stands: set (at the true tool point of the programmed centre), programmed, "
          "or fitted (least squares, at mean height)")
      ->check(CLI::IsMember({"set", "programmed", "fitted"}))
      ->capture_default_str();
  verb->add_option("--noise-um", options->noise_um, "standard deviation of each reading")
      ->check([](const std::string& text) {
        const std::optional<double> value = finite_number(text);
        return value && *value >= 0.0 ? std::string() : "'" + text + "' is no number of micrometres from 0";
      })
      ->capture_default_str();
  verb->add_option("--seed", options->simulate.seed, "of the noise")
      ->check([](const std::string& text) { return whole_number(text, 0, UINT64_MAX); })
      ->capture_default_str();
  verb->add_option("--series", options->simulate.series, "label of the runs")->capture_default_str();
  verb->add_option("--start-us", options->simulate.start_us,
                   "clock of the first mark, microseconds since the epoch: runs of one robot with one begin "
                   "are one run")
      ->check([](const std::string& text) { return whole_number(text, 1, 4'000'000'000'000'000); })
      ->capture_default_str();
  verb->add_option("-o,--output", options->output, "LCM log to write: bar, joints, interferometer, marks");
  verb->add_option(
      "--plot", options->picture,
      "picture to write, .svg or .png: circles as a polar plot, lines over position; the joints' "
      "motion goes beside it, as NAME-joints");
  verb->add_flag("--json", options->json,
                 "each run as 'show --json', with the ball's place and plain harmonics of the bar");
  verb->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace ballbar
