/// ballbar summary: a series over its repetitions, per test and direction.

#include <algorithm>
#include <cstdio>
#include <iostream>
#include <memory>

#include "core/error.hpp"
#include "daemon/summary_json.hpp"
#include "daemon/text_table.hpp"
#include "daemon/tool.hpp"
#include "daemon/volumetric_out.hpp"

namespace ballbar {
namespace {

struct SummaryOptions {
  Where where;
  Choice choice;
  std::string baseline;
  bool json = false;
};

const char* way(const Json& entry) {
  const int direction = entry["direction"].get<int>();
  return direction > 0 ? "CCW" : direction < 0 ? "CW" : "?";
}

std::string plain_with_sd(const Json& value, const Json& sd) {
  return figure_text(value, 2) + (sd.is_number() ? " +- " + figure_text(sd, 2) : "");
}

void print_table(const std::string& heading, const std::vector<std::vector<std::string>>& rows) {
  constexpr std::size_t kLabels = 3;
  if (rows.size() > 1) std::cout << heading << "\n" << text_table(rows, kLabels) << "\n";
}

void print_circles(const Json& circles) {
  constexpr int kOrdersShown = 4;  // the JSON has more
  std::vector<std::vector<std::string>> rows{{"series", "test", "way", "runs", "harmonic 2 um", "sd um",
                                              "vector um", "circular dev. um", "path accuracy um",
                                              "centred um", "path repeatability um", "source"}};
  std::vector<std::vector<std::string>> drift{
      {"series", "test", "way", "order", "moved um", "vector um", "T^2", "limit 5 %", "p"}};
  for (const Json& c : circles) {
    const Json path = c["path"].is_null() ? Json::object() : c["path"];
    rows.push_back(
        {c["series"], c["test"], way(c), std::to_string(c["runs"].get<int>()),
         figure_text(c["harmonic2_mean_amplitude_um"], 2), figure_text(c["harmonic2_amplitude_sd_um"], 3),
         vector_text(c["harmonic2_mean_vector_um"], 2), figure_text(c["circular_deviation_mean_um"], 2),
         figure_text(path.value("accuracy_um", Json()), 2),
         figure_text(path.value("accuracy_centred_um", Json()), 2),
         figure_text(path.value("repeatability_um", Json()), 2), c["source"]});
    for (const Json& d : c.value("drift", Json::array())) {
      if (d["order"].get<int>() > kOrdersShown) break;
      char p[32];
      std::snprintf(p, sizeof p, "%.2g", d["p_value"].get<double>());
      drift.push_back({c["series"], c["test"], way(c), std::to_string(d["order"].get<int>()),
                       figure_text(d["moved_um"], 2), vector_text(d["moved_vector_um"], 2),
                       figure_text(d["t2"], 1), figure_text(d["t2_limit_5_percent"], 1), p});
    }
  }
  print_table(
      "Circles, over the repetitions (path accuracy and repeatability: ISO 9283 AT, RT as radial "
      "projections)",
      rows);
  print_table("Drift of the harmonics against the baseline (Hotelling's T^2; order 1 is the ball's set-up)",
              drift);
}

void print_lines(const Json& lines) {
  std::vector<std::vector<std::string>> rows{{"series", "test", "axis", "runs", "min. zone um",
                                              "least squares um", "end points um", "forward um",
                                              "backward um"}};
  std::vector<std::vector<std::string>> both{{"series", "test", "axis", "reversal B um", "mean B um", "R um",
                                              "E um", "M um", "A um", "AP max um", "RP max um"}};
  std::vector<std::vector<std::string>> between{
      {"series", "test", "axis", "constant um", "slope um/m", "shape um", "by chance um", "shares %"}};
  for (const Json& l : lines) {
    const std::string series = l["series"], test = l["test"], axis = l["axis"];
    const auto zone = [&](const char* set) {
      return l[set].is_null() ? std::string("-") : figure_text(l[set]["minimum_zone_um"], 2);
    };
    const Json& all = l["all_runs"];
    if (!all.is_null())
      rows.push_back({series, test, axis, std::to_string(l["runs"].get<int>()),
                      figure_text(all["minimum_zone_um"], 2), figure_text(all["least_squares_um"], 2),
                      figure_text(all["end_points_um"], 2), zone("forward"), zone("backward")});
    if (const Json& b = l["bidirectional"]; !b.is_null())
      both.push_back({series, test, axis, figure_text(b["reversal_um"], 2),
                      figure_text(b["reversal_mean_um"], 2), figure_text(b["repeatability_um"], 2),
                      figure_text(b["systematic_deviation_um"], 2),
                      figure_text(b["mean_bidirectional_deviation_um"], 2), figure_text(b["accuracy_um"], 2),
                      figure_text(l["poses"]["accuracy_max_um"], 2),
                      figure_text(l["poses"]["repeatability_max_um"], 2)});
    if (const Json& d = l["between_the_ways"]; !d.is_null())
      between.push_back(
          {series, test, axis, plain_with_sd(d["constant_um"], d["constant_um_sd"]),
           plain_with_sd(d["slope_um_per_m"], d["slope_um_per_m_sd"]), figure_text(d["shape_um"], 2),
           d["shape_by_chance_um"].is_null() ? "one run" : figure_text(d["shape_by_chance_um"], 2),
           figure_text(100 * d["constant_share"].get<double>(), 1) + " / " +
               figure_text(100 * d["slope_share"].get<double>(), 1) + " / " +
               figure_text(100 * d["shape_share"].get<double>(), 1)});
  }
  print_table("Lines, straightness of all runs together, and of each way's minimum zone (ISO 230-1)", rows);
  print_table(
      "Lines both ways: ISO 230-2 of the straightness deviation, not of a position; ISO 9283 AP, RP of the "
      "stops, projected on the axis",
      both);
  print_table("What separates the two ways: forward - backward", between);
}

int run(const SummaryOptions& options) {
  const Store store = options.where.open();
  const std::vector<StoredRun> runs = options.choice.runs(store, "ok");
  if (runs.empty()) throw Error(Cause::kInput, "no run that is ok fits; 'ballbar list' shows all runs");
  if (!options.baseline.empty() && std::none_of(runs.begin(), runs.end(), [&](const StoredRun& run) {
        return run.kind == TestKind::kCircle && run.series == options.baseline;
      }))
    throw Error(Cause::kInput,
                "no circle of the baseline '" + options.baseline + "' fits; 'ballbar list' shows all runs");
  const Json summary{{"circles", circles_summary(store, runs, options.baseline)},
                     {"lines", lines_summary(runs)},
                     {"volumetric", volumetric_summary(store, runs)}};
  if (options.json) {
    std::cout << text_of(summary);
    return 0;
  }
  print_circles(summary["circles"]);
  print_lines(summary["lines"]);
  std::cout << volumetric_text(summary["volumetric"]);
  return 0;
}

}  // namespace

void add_summary(CLI::App& app, Action& action) {
  auto options = std::make_shared<SummaryOptions>();
  CLI::App* verb =
      app.add_subcommand("summary",
                         "over the repetitions: harmonics, path accuracy and repeatability per "
                         "test and direction; squareness and scaling of three planes; straightness, "
                         "reversal and poses of all runs of a line");
  options->where.add_to(*verb);
  options->choice.add_to(*verb);
  verb->add_option("--baseline", options->baseline,
                   "hold the harmonics of the other series against this one (Hotelling's T^2)");
  verb->add_flag("--json", options->json, "as JSON, with covariances, stops and mean profiles");
  verb->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace ballbar
