#include "daemon/summary_json.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <tuple>

#include "core/units.hpp"
#include "metrology/line.hpp"
#include "metrology/line_repeats.hpp"
#include "metrology/repeats.hpp"
#include "numerics/statistics.hpp"

namespace ballbar {
namespace {

constexpr std::size_t kOrdersSummed = 10;  // of the harmonics that are shown

/// Robot, series, test, direction, source: a bar and joints are different measurements of one test.
using SummedKey = std::tuple<std::string, std::string, std::string, int, std::string>;
using LineKey = std::tuple<std::string, std::string, std::string, char>;  // robot, series, test, axis

struct SummedCircles {
  std::map<std::string, std::vector<double>> values;
  std::vector<std::vector<Harmonic>> harmonics;
  std::vector<std::int64_t> ids;
};

struct Lines {
  std::array<LineRuns, 2> ways;  // forward, backward
  std::array<std::vector<std::int64_t>, 2> ids;
};

Json um_or_null(const std::optional<double>& metres) { return metres ? Json(to_um(*metres)) : Json(); }

/// Null for fewer than two values.
Json spread(const std::vector<double>& values) {
  const std::optional<double> sd = sample_sd(values);
  return sd ? Json(*sd) : Json();
}

Json matrix_um2(const std::optional<Eigen::Matrix2d>& m) {
  if (!m) return {};
  const auto um2 = [&](int row, int column) { return to_um(to_um((*m)(row, column))); };
  return {{um2(0, 0), um2(0, 1)}, {um2(1, 0), um2(1, 1)}};
}

Json harmonics_json(const std::vector<RepeatedHarmonic>& harmonics) {
  Json list = Json::array();
  for (const RepeatedHarmonic& h : harmonics) {
    if (list.size() == kOrdersSummed) break;
    list.push_back({{"order", h.order},
                    {"mean_vector_um", {to_um(h.sample.mean.x()), to_um(h.sample.mean.y())}},
                    {"amplitude_of_mean_um", to_um(h.sample.mean.norm())},
                    {"covariance_um2", matrix_um2(h.sample.covariance)},
                    {"covariance_of_mean_um2", matrix_um2(h.sample.covariance_of_mean())}});
  }
  return list;
}

Json drift_json(const std::vector<RepeatedHarmonic>& series, const std::vector<RepeatedHarmonic>& baseline) {
  constexpr double kLevel = 0.05;
  Json list = Json::array();
  for (std::size_t i = 0; i < std::min({series.size(), baseline.size(), kOrdersSummed}); ++i) {
    const std::optional<T2Test> test = drift_of(series[i], baseline[i]);
    if (!test) continue;
    const Eigen::Vector2d moved = series[i].sample.mean - baseline[i].sample.mean;
    list.push_back({{"order", series[i].order},
                    {"moved_vector_um", {to_um(moved.x()), to_um(moved.y())}},
                    {"moved_um", to_um(moved.norm())},
                    {"t2", test->t2},
                    {"t2_limit_5_percent", t2_limit(kLevel, test->dof)},
                    {"dof", test->dof},
                    {"p_value", test->p_value}});
  }
  return list;
}

/// Of the measured arcs.
std::optional<RadialPath> path_of(const Store& store, const std::vector<std::int64_t>& ids) {
  std::vector<RadialTrace> runs;
  for (const std::int64_t id : ids) {
    const Trace trace = store.trace(id);
    const std::size_t end = std::min({trace.arc_end, trace.angle.size(), trace.bar_deviation.size()});
    RadialTrace& run = runs.emplace_back();
    for (std::size_t i = trace.arc_begin; i < end; ++i) {
      run.angle.push_back(trace.angle[i]);
      run.deviation.push_back(trace.bar_deviation[i]);
    }
  }
  return radial_path(runs);
}

Json path_json(const std::optional<RadialPath>& path) {
  if (!path) return {};
  return {{"what", "radial projection of ISO 9283 AT and RT: what a bar sees"},
          {"accuracy_um", to_um(path->accuracy)},
          {"accuracy_deg", to_deg(path->accuracy_angle)},
          {"accuracy_centred_um", to_um(path->accuracy_centred)},
          {"repeatability_um", um_or_null(path->repeatability)},
          {"repeatability_deg", path->repeatability ? Json(to_deg(path->repeatability_angle)) : Json()}};
}

Json straightness_json(const std::optional<Straightness>& s) {
  if (!s) return {};
  return {{"minimum_zone_um", to_um(s->mz)},
          {"least_squares_um", to_um(s->ls)},
          {"end_points_um", to_um(s->ep)},
          {"least_squares_slope_um_per_m", to_um(s->slope_ls)}};
}

Json bidirectional_json(const std::optional<BidirectionalFigures>& f) {
  if (!f) return {};
  return {{"what", "figures of ISO 230-2 of the straightness deviation, not of a position"},
          {"points", f->points.size()},
          {"reversal_um", to_um(f->reversal)},
          {"reversal_mean_um", to_um(f->reversal_mean)},
          {"forward_repeatability_um", to_um(f->forward_repeatability)},
          {"backward_repeatability_um", to_um(f->backward_repeatability)},
          {"repeatability_um", to_um(f->repeatability)},
          {"forward_systematic_deviation_um", to_um(f->forward_systematic_deviation)},
          {"backward_systematic_deviation_um", to_um(f->backward_systematic_deviation)},
          {"systematic_deviation_um", to_um(f->systematic_deviation)},
          {"mean_bidirectional_deviation_um", to_um(f->mean_bidirectional_deviation)},
          {"forward_accuracy_um", to_um(f->forward_accuracy)},
          {"backward_accuracy_um", to_um(f->backward_accuracy)},
          {"accuracy_um", to_um(f->accuracy)}};
}

Json difference_json(const std::optional<BundleDifference>& d) {
  if (!d) return {};
  return {{"constant_um", to_um(d->constant.value)},
          {"constant_um_sd", um_or_null(d->constant.sd)},
          {"slope_um_per_m", to_um(d->slope.value)},
          {"slope_um_per_m_sd", um_or_null(d->slope.sd)},
          {"shape_um", to_um(d->shape)},
          {"shape_by_chance_um", um_or_null(d->shape_by_chance)},
          {"constant_share", d->constant_share},
          {"slope_share", d->slope_share},
          {"shape_share", d->shape_share}};
}

/// @param what  on what the poses are projected
Json stops_json(const std::vector<StopPose>& poses, const std::string& what) {
  if (poses.empty()) return {};
  Json json{{"what", "pose accuracy and repeatability of ISO 9283, " + what}};
  double accuracy = 0.0;
  std::optional<double> repeatability;
  Json list = Json::array();
  for (const StopPose& p : poses) {
    accuracy = std::max(accuracy, p.accuracy);
    if (p.repeatability) repeatability = std::max(repeatability.value_or(0.0), *p.repeatability);
    list.push_back({{"position_mm", to_mm(p.position)},
                    {"direction", p.direction},
                    {"runs", p.runs},
                    {"accuracy_um", to_um(p.accuracy)},
                    {"repeatability_um", um_or_null(p.repeatability)}});
  }
  json["accuracy_max_um"] = to_um(accuracy);
  json["repeatability_max_um"] = um_or_null(repeatability);
  json["stops"] = list;
  return json;
}

Json profile_json(const std::vector<LinePoint>& points) {
  Json list = Json::array();
  for (const LinePoint& p : points)
    list.push_back({{"position_mm", to_mm(p.position)},
                    {"deviation_um", to_um(p.deviation)},
                    {"reversal_um", um_or_null(p.reversal)}});
  return list;
}

Json line_json(const LineKey& key, const Lines& lines) {
  const LineBundle bundle = analyse_line_bundle(lines.ways[0], lines.ways[1]);
  Json json{{"robot", std::get<0>(key)},
            {"series", std::get<1>(key)},
            {"test", std::get<2>(key)},
            {"axis", std::string(1, std::get<3>(key))}};
  json["runs"] = lines.ways[0].size() + lines.ways[1].size();
  json["all_runs"] = straightness_json(bundle.all_runs);
  json["forward"] = straightness_json(bundle.forward);
  json["forward_mean_of_runs"] = straightness_json(bundle.forward_mean_of_runs);
  json["backward"] = straightness_json(bundle.backward);
  json["backward_mean_of_runs"] = straightness_json(bundle.backward_mean_of_runs);
  json["reversal_max_um"] = um_or_null(bundle.reversal_max);
  json["reversal_mean_um"] = um_or_null(bundle.reversal_mean);
  json["bidirectional"] = bidirectional_json(bidirectional_figures(lines.ways[0], lines.ways[1]));
  json["between_the_ways"] = difference_json(difference_of(lines.ways[0], lines.ways[1]));
  json["poses"] = stops_json(stop_poses(lines.ways[0], lines.ways[1]),
                             "projected on " + std::string(1, std::get<3>(key)));
  json["forward_mean"] = profile_json(bundle.forward_mean);
  json["backward_mean"] = profile_json(bundle.backward_mean);
  return json;
}

/// Where the same runs measured another axis too: poses in the plane of both.
void add_planes(const std::map<LineKey, Lines>& groups, const LineKey& key, const Lines& lines, Json& json) {
  for (const auto& [other, across] : groups) {
    const auto& [robot, series, test, axis] = other;
    if (std::tie(robot, series, test) != std::tie(std::get<0>(key), std::get<1>(key), std::get<2>(key)) ||
        axis <= std::get<3>(key) || across.ids != lines.ids)
      continue;
    const std::string plane{std::get<3>(key), axis};
    json["poses_" + plane] = stops_json(
        stop_poses(lines.ways[0], lines.ways[1], across.ways[0], across.ways[1]), "projected on " + plane);
  }
}

}  // namespace

Json circles_summary(const Store& store, const std::vector<StoredRun>& runs, const std::string& baseline) {
  std::map<SummedKey, SummedCircles> groups;
  for (const StoredRun& run : runs) {
    if (run.kind != TestKind::kCircle || run.records.empty()) continue;
    const auto& values = run.records.front().values;
    if (!values.contains("ovality_um")) continue;
    SummedCircles& group = groups[{run.robot, run.series, run.test, run.direction, run.source}];
    for (const char* name : {"ovality_um", "ovality_cos_um", "ovality_sin_um", "mean_radius_deviation_um",
                             "circular_deviation_um"})
      if (const auto found = values.find(name); found != values.end())
        group.values[name].push_back(found->second.value);
    group.harmonics.push_back(run.harmonics);
    group.ids.push_back(run.id);
  }
  Json list = Json::array();
  for (auto& [key, group] : groups) {
    auto& values = group.values;
    const auto& [robot, series, test, direction, source] = key;
    const std::vector<RepeatedHarmonic> harmonics = repeat_harmonics(group.harmonics);
    Json json{{"robot", robot},
              {"series", series},
              {"test", test},
              {"direction", direction},
              {"source", source},
              {"runs", group.ids.size()},
              {"harmonic2_mean_amplitude_um", mean(values["ovality_um"])},
              {"harmonic2_amplitude_sd_um", spread(values["ovality_um"])},
              {"harmonic2_mean_vector_um", {mean(values["ovality_cos_um"]), mean(values["ovality_sin_um"])}},
              {"mean_radius_deviation_mean_um", mean(values["mean_radius_deviation_um"])},
              {"circular_deviation_mean_um", mean(values["circular_deviation_um"])}};
    json["path"] = path_json(path_of(store, group.ids));
    json["harmonics"] = harmonics_json(harmonics);
    if (const auto before = groups.find({robot, baseline, test, direction, source});
        !baseline.empty() && series != baseline && before != groups.end())
      json["drift"] = drift_json(harmonics, repeat_harmonics(before->second.harmonics));
    list.push_back(std::move(json));
  }
  return list;
}

Json lines_summary(const std::vector<StoredRun>& runs) {
  std::map<LineKey, Lines> groups;
  for (const StoredRun& run : runs)
    for (const auto& [axis, points] : run.lines) {
      if (run.direction == 0) continue;
      Lines& group = groups[{run.robot, run.series, run.test, axis}];
      const std::size_t way = run.direction > 0 ? 0 : 1;
      group.ways[way].push_back(points);
      group.ids[way].push_back(run.id);
    }
  Json list = Json::array();
  for (const auto& [key, lines] : groups) {
    Json json = line_json(key, lines);
    add_planes(groups, key, lines, json);
    list.push_back(std::move(json));
  }
  return list;
}

}  // namespace ballbar
