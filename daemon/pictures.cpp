#include "daemon/pictures.hpp"

#include <algorithm>
#include <array>
#include <cstdio>
#include <limits>
#include <map>
#include <utility>

#include "core/error.hpp"
#include "core/units.hpp"
#include "daemon/picture_parts.hpp"
#include "daemon/service.hpp"
#include "metrology/line.hpp"
#include "metrology/repeats.hpp"
#include "numerics/statistics.hpp"
#include "report/harmonics_plot.hpp"
#include "report/ovality_plot.hpp"

namespace ballbar {
namespace {

/// More pictures of the model in one plot hide what was measured.
constexpr std::size_t kMostPredicted = 4;
constexpr std::size_t kMostNoted = 4;  // runs that have a note each
constexpr int kLastOrder = 10;

double value_of(const StoredRun& run, const char* name) {
  const auto& values = run.records.front().values;
  const auto found = values.find(name);
  return found == values.end() ? std::numeric_limits<double>::quiet_NaN() : found->second.value;
}

std::vector<StoredRun> of_kind(const std::vector<StoredRun>& runs, TestKind kind) {
  std::vector<StoredRun> found;
  std::copy_if(runs.begin(), runs.end(), std::back_inserter(found),
               [&](const StoredRun& run) { return run.kind == kind && !run.records.empty(); });
  if (found.empty())
    throw Error(Cause::kInput, kind == TestKind::kCircle
                                   ? "no circle among these runs; 'ballbar list' shows all runs"
                                   : "no line among these runs; 'ballbar list' shows all runs");
  return found;
}

/// Runs alike: group and direction, by first appearance.
struct Bundle {
  std::string group;
  int direction = 0;
  std::vector<const StoredRun*> runs;
};

std::vector<Bundle> bundles_of(const std::vector<StoredRun>& runs) {
  const Apart apart(runs);
  std::vector<Bundle> bundles;
  for (const StoredRun& run : runs) {
    const std::string group = apart.group(run);
    auto found = std::find_if(bundles.begin(), bundles.end(), [&](const Bundle& b) {
      return b.group == group && b.direction == run.direction;
    });
    if (found == bundles.end()) found = bundles.insert(bundles.end(), {group, run.direction, {}});
    found->runs.push_back(&run);
  }
  return bundles;
}

std::string counted(const std::string& label, std::size_t runs) {
  return label + " (" + std::to_string(runs) + (runs == 1 ? " run)" : " runs)");
}

/// @param in_full  with what is a single run's
std::string circle_note(const std::string& label, const std::vector<const StoredRun*>& runs, bool in_full) {
  const auto mean_of = [&](const char* name) {
    double sum = 0.0;
    for (const StoredRun* run : runs) sum += value_of(*run, name);
    return sum / static_cast<double>(runs.size());
  };
  char text[240];
  std::snprintf(text, sizeof text, "%s: circular deviation %.1f µm, ovality %.1f µm", label.c_str(),
                mean_of("circular_deviation_um"), mean_of("ovality_um"));
  std::string note = text;
  if (in_full) {
    std::snprintf(text, sizeof text, " along %.0f°, eccentricity %.1f µm",
                  value_of(*runs.front(), "ovality_axis_deg"), value_of(*runs.front(), "eccentricity_um"));
    note += text;
  }
  return note;
}

std::vector<std::string> circle_notes(const std::vector<StoredRun>& runs) {
  std::vector<std::string> notes;
  if (runs.size() <= kMostNoted) {
    for (const StoredRun& run : runs)
      notes.push_back(circle_note(run_name(run.test, run.direction, run.repetition), {&run}, true));
    return notes;
  }
  for (const Bundle& bundle : bundles_of(runs))
    notes.push_back(
        circle_note(with_way(bundle.group, TestKind::kCircle, bundle.direction), bundle.runs, false));
  notes.emplace_back("figures are means of the runs");
  return notes;
}

PlotScript polar(const Store& store, const std::vector<StoredRun>& all, const PictureOptions& options) {
  const std::vector<StoredRun> runs = of_kind(all, TestKind::kCircle);
  const bool with_predicted = !options.measured_only && runs.size() <= kMostPredicted;
  const Apart apart(runs);
  const Heading head = heading_of(runs);
  PolarPlot plot{head.title, head.subtitle, {}, circle_notes(runs)};
  for (const StoredRun& run : runs) {
    const Trace trace = store.trace(run.id);
    const std::size_t end = std::min({trace.arc_end, trace.angle.size(), trace.bar_deviation.size()});
    PolarTrace shown;
    shown.group = apart.group(run);
    shown.label = (runs.front().series == runs.back().series ? "" : run.series + ":") +
                  run_name(run.test, run.direction, run.repetition);
    shown.direction = run.direction;
    for (std::size_t i = trace.arc_begin; i < end; ++i) {
      shown.angle_rad.push_back(trace.angle[i]);
      shown.deviation_um.push_back(to_um(trace.bar_deviation[i]));
    }
    plot.traces.push_back(shown);
    if (!with_predicted || trace.predicted.empty()) continue;
    shown.predicted = true;
    for (std::size_t i = 0; i < shown.angle_rad.size(); ++i)
      shown.deviation_um[i] = to_um(trace.predicted[trace.arc_begin + i]);
    plot.traces.push_back(shown);
  }
  return polar_script(plot);
}

/// Straightness over all runs of each group, both ways together.
std::vector<std::string> line_notes(const std::vector<StoredRun>& runs, char axis) {
  std::map<std::string, std::array<std::vector<std::vector<LinePoint>>, 2>> groups;
  const Apart apart(runs);
  for (const StoredRun& run : runs)
    for (const auto& [line_axis, points] : run.lines)
      if (line_axis == axis) groups[apart.group(run)][run.direction < 0 ? 1 : 0].push_back(points);
  std::vector<std::string> notes;
  for (const auto& [group, ways] : groups) {
    const LineBundle bundle = analyse_line_bundle(ways[0], ways[1]);
    if (!bundle.all_runs) continue;
    char text[200];
    std::snprintf(text, sizeof text, "%sstraightness of all %zu runs, minimum zone: %.1f µm",
                  group.empty() ? "" : (group + ": ").c_str(), ways[0].size() + ways[1].size(),
                  to_um(bundle.all_runs->mz));
    std::string note = text;
    if (bundle.reversal_max) {
      std::snprintf(text, sizeof text, ",   reversal %.1f µm", to_um(*bundle.reversal_max));
      note += text;
    }
    notes.push_back(note);
  }
  return notes;
}

PlotScript line(const std::vector<StoredRun>& all, const PictureOptions& options) {
  const std::vector<StoredRun> runs = of_kind(all, TestKind::kLine);
  const bool with_predicted = !options.measured_only && runs.size() <= kMostPredicted;
  const Apart apart(runs);
  const Heading head = heading_of(runs);
  LinePlot plot{head.title, head.subtitle, {}, {}, {}};
  for (const StoredRun& run : runs)
    for (const auto& [axis, points] : run.lines) {
      if (!options.axis.empty() && options.axis[0] != axis) continue;
      if (plot.axis.empty()) plot.axis = std::string(1, axis);
      if (plot.axis[0] != axis)
        throw Error(Cause::kInput, "the runs deviate along different axes; choose one with --axis");
      LineTrace shown;
      shown.group = apart.group(run);
      shown.label = (runs.front().series == runs.back().series ? "" : run.series + ":") +
                    run_name(run.test, run.direction, run.repetition);
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
  if (!plot.axis.empty()) plot.notes = line_notes(runs, plot.axis[0]);
  return line_script(plot);
}

PlotScript harmonics(const std::vector<StoredRun>& all, const PictureOptions& options) {
  const std::vector<StoredRun> runs = of_kind(all, TestKind::kCircle);
  const Heading head = heading_of(runs);
  HarmonicsPlot plot{head.title, head.subtitle, {}, {}};
  bool spread = false;
  for (const Bundle& bundle : bundles_of(runs)) {
    HarmonicBars bars{
        counted(with_way(bundle.group, TestKind::kCircle, bundle.direction), bundle.runs.size()),
        bundle.group,
        bundle.direction,
        {}};
    for (int order = options.first_order; order <= kLastOrder; ++order) {
      std::vector<double> amplitudes;
      for (const StoredRun* run : bundle.runs)
        for (const Harmonic& h : run->harmonics)
          if (h.order == order) amplitudes.push_back(to_um(std::hypot(h.cos, h.sin)));
      if (!amplitudes.empty()) bars.bars.push_back({order, mean(amplitudes), sample_sd(amplitudes)});
    }
    spread = spread || bundle.runs.size() > 1;
    plot.sets.push_back(std::move(bars));
  }
  if (spread)
    plot.notes.emplace_back(
        "mean amplitude of the runs; lines on the bars: ± standard deviation of a single run");
  return harmonics_script(plot);
}

PlotScript ovality(const std::vector<StoredRun>& all) {
  const std::vector<StoredRun> runs = of_kind(all, TestKind::kCircle);
  const Heading head = heading_of(runs);
  OvalityPlot plot{head.title, head.subtitle, {}, {}};
  for (const Bundle& bundle : bundles_of(runs)) {
    OvalityVectors set{
        counted(with_way(bundle.group, TestKind::kCircle, bundle.direction), bundle.runs.size()),
        bundle.group,
        bundle.direction,
        {}};
    for (const StoredRun* run : bundle.runs)
      set.vectors_um.emplace_back(value_of(*run, "ovality_cos_um"), value_of(*run, "ovality_sin_um"));
    plot.sets.push_back(std::move(set));
  }
  return ovality_script(plot);
}

}  // namespace

const char* way_of(TestKind kind, int direction) {
  if (direction == 0) return "direction not known";
  if (kind == TestKind::kCircle) return direction > 0 ? "counter-clockwise" : "clockwise";
  return direction > 0 ? "forward" : "backward";
}

Apart::Apart(const std::vector<StoredRun>& runs) {
  for (const StoredRun& run : runs) {
    robots_ = robots_ || run.robot != runs.front().robot;
    series_ = series_ || run.series != runs.front().series;
    tests_ = tests_ || run.test != runs.front().test;
    sources_ = sources_ || run.source != runs.front().source;
  }
}

std::string Apart::group(const StoredRun& run, bool with_series) const {
  std::string group = robots_ ? run.robot : "";
  if (series_ && with_series) group += (group.empty() ? "" : " ") + run.series;
  if (tests_) group += (group.empty() ? "" : " ") + run.test;
  if (sources_ && !run.source.empty()) group += (group.empty() ? "from " : " from ") + run.source;
  return group;
}

PlotScript picture_of(PictureKind kind, const Store& store, const std::vector<StoredRun>& runs,
                      const PictureOptions& options) {
  switch (kind) {
    case PictureKind::kPolar:
      return polar(store, runs, options);
    case PictureKind::kLine:
      return line(runs, options);
    case PictureKind::kHarmonics:
      return harmonics(runs, options);
    case PictureKind::kTrend:
      return trend_picture(store, runs, options);
    case PictureKind::kOvality:
      return ovality(runs);
  }
  throw std::invalid_argument("picture_of: no such kind");
}

}  // namespace ballbar
