/// ballbar replay

#include <unistd.h>

#include <cstdio>
#include <iostream>
#include <memory>

#include "bus/subscriber.hpp"
#include "core/error.hpp"
#include "daemon/replay.hpp"
#include "daemon/tool.hpp"

namespace ballbar {
namespace {

struct ReplayOptions {
  Where where;
  std::vector<std::string> logs;
  std::string publish_url;
  bool quiet = false;
};

std::string refusals_text(const AssemblerCounters& counters) {
  std::string text;
  for (std::size_t i = 0; i < kRefusals; ++i)
    if (counters.refused[i] > 0)
      text += (text.empty() ? "" : ", ") + std::string(kRefusalNames[i]) + " " +
              std::to_string(counters.refused[i]);
  return text;
}

RuleSet rules_of(const Config& config) {
  LoadReport report = load_rules(config);
  for (const RuleError& error : report.errors) std::cerr << "ballbar: " << to_string(error) << "\n";
  return std::move(report.rules);
}

int run(const ReplayOptions& options) {
  const Config config = options.where.config();
  Models models = load_models(config);
  std::vector<LogFile> logs;  // bad input is said before a database is made
  for (const std::string& log : options.logs) logs.push_back(inspect_log(log));
  Store store(config.store_path);
  const bool terminal = isatty(STDERR_FILENO) == 1;
  const auto clear = [terminal] {
    if (terminal) std::fputs("\r\033[K", stderr);
  };
  const auto print = [&](Priority priority, const std::string& line) {
    clear();
    if (!options.quiet || priority < Priority::kInfo) std::cout << line << "\n";
  };
  Service service(config, std::move(models), rules_of(config), store, print);
  if (!options.publish_url.empty()) service.publish_to(std::make_unique<Publisher>(options.publish_url));
  for (const LogFile& log : logs) {
    const auto progress = [&](double recorded_s) {
      if (terminal)
        std::fprintf(stderr, "\r\033[K%s: %.0f of %.0f s", log.path.c_str(), recorded_s, log.recorded_s);
    };
    const ReplayOutcome outcome = replay(log, service, progress);
    clear();
    std::cout << log.path << ": " << outcome.messages.messages << " messages, "
              << outcome.messages.lost_messages << " lost, " << outcome.messages.refused_total()
              << " refused";
    if (outcome.messages.refused_total() > 0) std::cout << " (" << refusals_text(outcome.messages) << ")";
    std::cout << "\n";
  }
  const ServiceCounters& counters = service.counters();
  std::cout << counters.runs_stored << " runs stored, " << counters.runs_ok << " of them ok, "
            << counters.runs_known << " already known; database " << store.path() << "\n";
  if (service.waiting() > 0)
    throw Error(Cause::kWorld,
                std::to_string(service.waiting()) + " runs could not be stored in " + store.path());
  for (const LogFile& log : logs)
    if (!log.whole())
      throw Error(Cause::kInput, log.path + ": damaged at byte " + std::to_string(log.good_bytes) + " of " +
                                     std::to_string(log.bytes) + ": the " + std::to_string(log.events) +
                                     " events before it were replayed, what lies behind was not read");
  return 0;
}

}  // namespace

void add_replay(CLI::App& app, Action& action) {
  auto options = std::make_shared<ReplayOptions>();
  CLI::App* verb = app.add_subcommand(
      "replay", "an LCM log through the same path as live data, as fast as it can be read");
  verb->add_option("LOG", options->logs, "logs, as lcm-logger writes them")->required();
  options->where.add_to(*verb);
  verb->add_option("--publish", options->publish_url, "also send the results to this LCM URL");
  verb->add_flag("--quiet", options->quiet, "only warnings and the totals");
  verb->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace ballbar
