/// ballbar compare

#include <iostream>
#include <memory>

#include "core/error.hpp"
#include "daemon/compare.hpp"
#include "daemon/pages.hpp"
#include "daemon/tool.hpp"

namespace ballbar {
namespace {

struct CompareOptions {
  Where where;
  std::vector<std::string> series;
  std::string robot, test, output;
  bool json = false;
};

std::vector<StoredRun> runs_of(const Store& store, const CompareOptions& options, const std::string& series) {
  Choice choice;
  choice.robot = options.robot;
  choice.test = options.test;
  RunFilter filter = choice.filter();
  filter.series = series;
  filter.status = "ok";
  std::vector<StoredRun> runs = store.runs(filter);
  if (runs.empty())
    throw Error(Cause::kInput,
                "no run of series '" + series + "' that is ok fits; 'ballbar list' shows all runs");
  return runs;
}

int run(const CompareOptions& options) {
  if (options.series.size() != 2 || options.series[0] == options.series[1])
    throw Error(Cause::kInput, "give two series: --series BEFORE --series AFTER");
  const Store store = options.where.open();
  const std::vector<StoredRun> before = runs_of(store, options, options.series[0]);
  const std::vector<StoredRun> after = runs_of(store, options, options.series[1]);
  const Json comparison = compare_json(before, after);
  if (comparison["circles"].empty() && comparison["lines"].empty())
    throw Error(Cause::kInput,
                "the two series have no test and direction in common; 'ballbar list' shows all runs");
  if (!options.output.empty()) write_page(options.output, compare_page(store, before, after, comparison));
  if (options.json)
    std::cout << text_of(comparison);
  else if (options.output.empty())
    std::cout << compare_text(comparison);
  return 0;
}

}  // namespace

void add_compare(CLI::App& app, Action& action) {
  auto options = std::make_shared<CompareOptions>();
  CLI::App* verb = app.add_subcommand(
      "compare", "two series, per test and direction: harmonics, ISO figures, straightness, and what moved");
  verb->add_option("--series", options->series, "twice: the series before and the one after")
      ->required()
      ->take_all();
  verb->add_option("--robot", options->robot, "only of this robot");
  verb->add_option("--test", options->test, "only of this test");
  verb->add_flag("--json", options->json, "as JSON");
  verb->add_option("-o,--output", options->output, "a page to write, with pictures: .html");
  options->where.add_to(*verb);
  verb->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace ballbar
