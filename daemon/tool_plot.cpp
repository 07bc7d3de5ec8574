/// ballbar plot

#include <cstdio>
#include <iostream>
#include <limits>
#include <memory>
#include <set>

#include "core/error.hpp"
#include "core/units.hpp"
#include "daemon/service.hpp"
#include "daemon/tool.hpp"
#include "report/plot.hpp"

namespace ballbar {
namespace {

struct Options {
  Where where;
  Choice choice;
  std::vector<std::string> runs;
  std::string output;
  std::string axis;
  bool measured_only = false;
};

/// More pictures of the model in one plot hide what was measured.
constexpr std::size_t kMostPredicted = 4;

/// "A, B": each word once, in sequence.
void add_word(std::string& list, std::set<std::string>& seen, const std::string& word) {
  if (word.empty() || !seen.insert(word).second) return;
  list += (list.empty() ? "" : ", ") + word;
}

struct Heading {
  std::string title, subtitle;
};

Heading heading(const std::vector<StoredRun>& runs) {
  std::string robots, tests, series;
  std::set<std::string> robot_seen, test_seen, series_seen;
  for (const StoredRun& run : runs) {
    add_word(robots, robot_seen, run.robot);
    add_word(tests, test_seen, run.test);
    add_word(series, series_seen, run.series);
  }
  const std::string begin = utc_text(runs.front().started_us);
  return {robots + "   test " + tests, series + (series.empty() ? "" : "   ") + begin + " UTC"};
}

std::string note(const StoredRun& run) {
  const auto& values = run.records.front().values;
  const auto get = [&](const char* name) {
    const auto found = values.find(name);
    return found == values.end() ? 0.0 : found->second.value;
  };
  char text[160];
  std::snprintf(text, sizeof text,
                "%s: circular deviation %.1f um, ovality %.1f um along %.0f deg, eccentricity %.1f um",
                run_name(run.test, run.direction, run.repetition).c_str(), get("circular_deviation_um"),
                get("ovality_um"), get("ovality_axis_deg"), get("eccentricity_um"));
  return text;
}

PlotScript polar(const Store& store, const std::vector<StoredRun>& runs, bool with_predicted) {
  PolarPlot plot;
  const Heading head = heading(runs);
  plot.title = head.title;
  plot.subtitle = head.subtitle;
  for (const StoredRun& run : runs) {
    const Trace trace = store.trace(run.id);
    PolarTrace shown;
    shown.label = (runs.front().series == runs.back().series ? "" : run.series + ":") +
                  run_name(run.test, run.direction, run.repetition);
    shown.direction = run.direction;
    for (std::size_t i = trace.arc_begin; i < trace.arc_end && i < trace.angle.size(); ++i) {
      shown.angle_rad.push_back(trace.angle[i]);
      shown.deviation_um.push_back(to_um(trace.bar_deviation[i]));
    }
    plot.traces.push_back(shown);
    if (with_predicted && !trace.predicted.empty()) {
      shown.predicted = true;
      for (std::size_t i = 0; i < shown.angle_rad.size(); ++i)
        shown.deviation_um[i] = to_um(trace.predicted[trace.arc_begin + i]);
      plot.traces.push_back(shown);
    }
    plot.notes.push_back(note(run));
  }
  return polar_script(plot);
}

PlotScript line(const std::vector<StoredRun>& runs, const std::string& wanted_axis, bool with_predicted) {
  LinePlot plot;
  const Heading head = heading(runs);
  plot.title = head.title;
  plot.subtitle = head.subtitle;
  for (const StoredRun& run : runs)
    for (const auto& [axis, points] : run.lines) {
      if (!wanted_axis.empty() && wanted_axis[0] != axis) continue;
      if (plot.axis.empty()) plot.axis = std::string(1, axis);
      if (plot.axis[0] != axis)
        throw Error(Cause::kInput, "the runs deviate along different axes; choose one with --axis");
      LineTrace shown;
      shown.label = run_name(run.test, run.direction, run.repetition);
      shown.direction = run.direction;
      for (const LinePoint& point : points) {
        shown.position_mm.push_back(to_mm(point.position));
        shown.deviation_um.push_back(to_um(point.deviation));
      }
      plot.traces.push_back(shown);
      if (!with_predicted || points.empty() || !points.front().predicted) continue;
      shown.predicted = true;
      for (std::size_t i = 0; i < points.size(); ++i)
        shown.deviation_um[i] =
            points[i].predicted ? to_um(*points[i].predicted) : std::numeric_limits<double>::quiet_NaN();
      plot.traces.push_back(shown);
    }
  return line_script(plot);
}

int run(const Options& options) {
  const Store store = options.where.open();
  std::vector<StoredRun> runs;
  for (const std::string& name : options.runs) runs.push_back(find_run(store, name));
  if (options.runs.empty()) runs = options.choice.runs(store, "ok");
  if (runs.empty())
    throw Error(
        Cause::kInput,
        "nothing to plot: name runs, or choose some with --test and --series; 'ballbar list' shows all");
  for (const StoredRun& stored : runs)
    if (stored.kind != runs.front().kind)
      throw Error(Cause::kInput, "circles and lines do not go into one plot; choose one kind with --test");
  const bool with_predicted = !options.measured_only && runs.size() <= kMostPredicted;
  render(runs.front().kind == TestKind::kCircle ? polar(store, runs, with_predicted)
                                                : line(runs, options.axis, with_predicted),
         options.output);
  return 0;
}

}  // namespace

void add_plot(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand("plot", "circles as a polar plot, lines as deviation over position");
  verb->add_option("RUN", options->runs,
                   "ids or names: A+1#2, SERIES:A+1#2; none: all that --test, --series ... choose");
  verb->add_option("--axis", options->axis, "lines: only this direction of deviation")
      ->check(CLI::IsMember({"X", "Y", "Z"}));
  verb->add_flag("--measured-only", options->measured_only,
                 "without what the model predicts, which is drawn for up to four runs");
  verb->add_option("-o,--output", options->output, "picture to write: .svg or .png")->required();
  options->where.add_to(*verb);
  options->choice.add_to(*verb);
  verb->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace ballbar
