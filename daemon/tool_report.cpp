/// ballbar report

#include <algorithm>
#include <memory>

#include "daemon/pages.hpp"
#include "daemon/rule_limits.hpp"
#include "daemon/tool.hpp"

namespace ballbar {
namespace {

struct ReportOptions {
  Where where;
  RunChoice chosen;
  std::string baseline, output;
};

int run(const ReportOptions& options) {
  const Store store = options.where.open();
  std::vector<StoredRun> runs = options.chosen.runs(store, "", "report");
  std::stable_sort(runs.begin(), runs.end(),
                   [](const StoredRun& a, const StoredRun& b) { return a.started_us < b.started_us; });
  write_page(options.output, report_page(store, runs, options.baseline, configured_rules(options.where)));
  return 0;
}

}  // namespace

void add_report(CLI::App& app, Action& action) {
  auto options = std::make_shared<ReportOptions>();
  CLI::App* verb = app.add_subcommand(
      "report", "one page of runs or a series: figures, pictures, prediction, changes, alarms, conditions");
  verb->add_option("--baseline", options->baseline,
                   "the series to hold the runs against; default: the first one of the robot and test");
  verb->add_option("-o,--output", options->output, "page to write: .html")->required();
  options->where.add_to(*verb);
  options->chosen.add_to(*verb);
  verb->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace ballbar
