/// ballbar summary: the means of a series, per test and direction.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstdio>
#include <iostream>
#include <map>
#include <memory>
#include <tuple>

#include "core/error.hpp"
#include "core/units.hpp"
#include "daemon/json_out.hpp"
#include "daemon/tool.hpp"
#include "metrology/line.hpp"
#include "numerics/statistics.hpp"

namespace ballbar {
namespace {

struct Options {
  Where where;
  Choice choice;
  bool json = false;
};

using CircleKey = std::tuple<std::string, std::string, std::string, int,
                             std::string>;  // robot, series, test, direction, source
using LineKey = std::tuple<std::string, std::string, std::string, char>;  // robot, series, test, axis
using Bundles = std::map<LineKey, std::array<std::vector<std::vector<LinePoint>>, 2>>;  // forward, backward

/// Null for fewer than two values.
Json spread(const std::vector<double>& values) {
  const std::optional<double> sd = sample_sd(values);
  return sd ? Json(*sd) : Json();
}

Json circles_json(const std::vector<StoredRun>& runs) {
  std::map<CircleKey, std::map<std::string, std::vector<double>>> groups;
  for (const StoredRun& run : runs) {
    if (run.kind != TestKind::kCircle || run.records.empty()) continue;
    auto& group = groups[{run.robot, run.series, run.test, run.direction, run.source}];
    for (const char* name : {"ovality_um", "ovality_cos_um", "ovality_sin_um", "mean_radius_deviation_um",
                             "circular_deviation_um"})
      if (const auto found = run.records.front().values.find(name); found != run.records.front().values.end())
        group[name].push_back(found->second.value);
  }
  Json list = Json::array();
  for (auto& [key, values] : groups) {
    if (values["ovality_um"].empty()) continue;
    list.push_back(
        {{"robot", std::get<0>(key)},
         {"series", std::get<1>(key)},
         {"test", std::get<2>(key)},
         {"direction", std::get<3>(key)},
         {"source", std::get<4>(key)},
         {"runs", values["ovality_um"].size()},
         {"harmonic2_mean_amplitude_um", mean(values["ovality_um"])},
         {"harmonic2_amplitude_sd_um", spread(values["ovality_um"])},
         {"harmonic2_mean_vector_um", {mean(values["ovality_cos_um"]), mean(values["ovality_sin_um"])}},
         {"mean_radius_deviation_mean_um", mean(values["mean_radius_deviation_um"])},
         {"circular_deviation_mean_um", mean(values["circular_deviation_um"])}});
  }
  return list;
}

Json straightness_json(const std::optional<Straightness>& s) {
  if (!s) return {};
  return {{"minimum_zone_um", to_um(s->mz)},
          {"least_squares_um", to_um(s->ls)},
          {"end_points_um", to_um(s->ep)},
          {"least_squares_slope_um_per_m", to_um(s->slope_ls)}};
}

Json bundle_json(const LineKey& key, const LineBundle& bundle, std::size_t runs) {
  Json json{{"robot", std::get<0>(key)},
            {"series", std::get<1>(key)},
            {"test", std::get<2>(key)},
            {"axis", std::string(1, std::get<3>(key))}};
  json["runs"] = runs;
  json["all_runs"] = straightness_json(bundle.all_runs);
  json["forward"] = straightness_json(bundle.forward);
  json["forward_mean_of_runs"] = straightness_json(bundle.forward_mean_of_runs);
  json["backward"] = straightness_json(bundle.backward);
  json["backward_mean_of_runs"] = straightness_json(bundle.backward_mean_of_runs);
  json["reversal_max_um"] = bundle.reversal_max ? Json(to_um(*bundle.reversal_max)) : Json();
  json["reversal_mean_um"] = bundle.reversal_mean ? Json(to_um(*bundle.reversal_mean)) : Json();
  const auto profile = [](const std::vector<LinePoint>& points) {
    Json list = Json::array();
    for (const LinePoint& p : points)
      list.push_back({{"position_mm", to_mm(p.position)},
                      {"deviation_um", to_um(p.deviation)},
                      {"reversal_um", p.reversal ? Json(to_um(*p.reversal)) : Json()}});
    return list;
  };
  json["forward_mean"] = profile(bundle.forward_mean);
  json["backward_mean"] = profile(bundle.backward_mean);
  return json;
}

Json lines_json(const std::vector<StoredRun>& runs) {
  Bundles bundles;
  for (const StoredRun& run : runs)
    for (const auto& [axis, points] : run.lines)
      if (run.direction != 0)
        bundles[{run.robot, run.series, run.test, axis}][run.direction > 0 ? 0 : 1].push_back(points);
  Json list = Json::array();
  for (const auto& [key, ways] : bundles)
    list.push_back(bundle_json(key, analyse_line_bundle(ways[0], ways[1]), ways[0].size() + ways[1].size()));
  return list;
}

const char* way(int direction) { return direction > 0 ? "CCW" : direction < 0 ? "CW" : "?"; }

void print(const Json& summary) {
  std::printf("%-18s %-5s %-4s %5s %14s %8s %26s %16s %s\n", "series", "test", "way", "runs", "harmonic 2 um",
              "sd um", "vector um", "circular dev. um", "source");
  for (const Json& c : summary["circles"]) {
    const Json& vector = c["harmonic2_mean_vector_um"];
    char text[64];
    std::snprintf(text, sizeof text, "(%.2f, %.2f)", vector[0].get<double>(), vector[1].get<double>());
    std::printf("%-18s %-5s %-4s %5d %14.2f %8s %26s %16.2f %s\n", c["series"].get<std::string>().c_str(),
                c["test"].get<std::string>().c_str(), way(c["direction"].get<int>()), c["runs"].get<int>(),
                c["harmonic2_mean_amplitude_um"].get<double>(),
                c["harmonic2_amplitude_sd_um"].is_null()
                    ? "-"
                    : std::to_string(c["harmonic2_amplitude_sd_um"].get<double>()).substr(0, 5).c_str(),
                text, c["circular_deviation_mean_um"].get<double>(), c["source"].get<std::string>().c_str());
  }
  if (summary["lines"].empty()) return;
  std::printf("%-18s %-5s %-4s %5s %16s %16s %16s %16s\n", "series", "test", "axis", "runs", "min. zone um",
              "least squares um", "end points um", "reversal max um");
  for (const Json& l : summary["lines"]) {
    const Json& all = l["all_runs"];
    std::printf("%-18s %-5s %-4s %5d %16.2f %16.2f %16.2f %16s\n", l["series"].get<std::string>().c_str(),
                l["test"].get<std::string>().c_str(), l["axis"].get<std::string>().c_str(),
                l["runs"].get<int>(), all["minimum_zone_um"].get<double>(),
                all["least_squares_um"].get<double>(), all["end_points_um"].get<double>(),
                l["reversal_max_um"].is_null()
                    ? "-"
                    : std::to_string(l["reversal_max_um"].get<double>()).substr(0, 8).c_str());
  }
}

int run(const Options& options) {
  const Store store = options.where.open();
  const std::vector<StoredRun> runs = options.choice.runs(store, "ok");
  if (runs.empty()) throw Error(Cause::kInput, "no run that is ok fits; 'ballbar list' shows all runs");
  const Json summary{{"circles", circles_json(runs)}, {"lines", lines_json(runs)}};
  if (options.json)
    std::cout << text_of(summary);
  else
    print(summary);
  return 0;
}

}  // namespace

void add_summary(CLI::App& app, Action& action) {
  auto options = std::make_shared<Options>();
  CLI::App* verb = app.add_subcommand(
      "summary",
      "means over the repetitions: harmonic 2 per test and direction, straightness of all runs of a line");
  options->where.add_to(*verb);
  options->choice.add_to(*verb);
  verb->add_flag("--json", options->json, "as JSON, with the mean profiles");
  verb->callback([options, &action] { action = [options] { return run(*options); }; });
}

}  // namespace ballbar
