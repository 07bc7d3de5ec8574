/// ballbar report

#include <algorithm>
#include <memory>

#include "core/error.hpp"
#include "daemon/pages.hpp"
#include "daemon/rule_limits.hpp"
#include "daemon/tool.hpp"

namespace ballbar {
namespace {

struct Options {
  Where where;
  Choice choice;
  std::vector<std::string> runs;
  std::string baseline, output;
};

int run(const Options& options) {
  const Store store = options.where.open();
  std::vector<StoredRun> runs;
  for (const std::string& name : options.runs) runs.push_back(find_run(store, name));
  if (options.runs.empty()) runs = options.choice.runs(store);
  if (runs.empty())
    throw Error(
        Cause::kInput,
        "nothing to report: name runs, or choose some with --series and --test; 'ballbar list' shows all");
  std::stable_sort(runs.begin(), runs.end(),
                   [](const StoredRun& a, const StoredRun& b) { return a.started_us < b.started_us; });
  write_page(options.output, report_page(store, runs, options.baseline, configured_rules(options.where)));
  return 0;
}

}  // namespace

void add_report(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand(
      "report", "one page of runs or a series: figures, pictures, prediction, changes, alarms, conditions");
  verb->add_option("RUN", options->runs,
                   "ids or names: A+1#2, SERIES:A+1#2; none: all that --test, --series ... choose");
  verb->add_option("--baseline", options->baseline,
                   "the series to hold the runs against; default: the first one of the robot and test");
  verb->add_option("-o,--output", options->output, "page to write: .html")->required();
  options->where.add_to(*verb);
  options->choice.add_to(*verb);
  verb->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace ballbar
