#include "daemon/compare.hpp"

#include <array>
#include <map>
#include <set>
#include <tuple>

#include "core/units.hpp"
#include "daemon/pictures.hpp"
#include "daemon/summary_json.hpp"
#include "metrology/repeats.hpp"
#include "numerics/statistics.hpp"
#include "pipeline/catalogue.hpp"

namespace ballbar {
namespace {

constexpr std::size_t kOrdersCompared = 10;

/// Robot, test, direction (- first), source: a bar and joints are different measurements of one test.
using ComparedKey = std::tuple<std::string, std::string, int, std::string>;

struct ComparedCircles {
  std::array<std::vector<const StoredRun*>, 2> runs;  // before, after
};

/// Numbers that change for other reasons than the robot, and angles, whose mean is that of a vector.
bool is_compared(const Quantity& quantity) {
  return quantity.kind == "circle" && !quantity.name.ends_with("_deg") &&
         !quantity.name.starts_with("eccentricity");
}

struct Mean {
  Json value, sd;  // null where there is none
};

Mean mean_of(const std::vector<const StoredRun*>& runs, const std::string& name) {
  std::vector<double> values;
  for (const StoredRun* run : runs)
    if (const auto found = run->records.front().values.find(name); found != run->records.front().values.end())
      values.push_back(found->second.value);
  if (values.empty()) return {};
  const std::optional<double> sd = sample_sd(values);
  return {mean(values), sd ? Json(*sd) : Json()};
}

Json change_of(const Json& before, const Json& after) {
  return before.is_number() && after.is_number() ? Json(after.get<double>() - before.get<double>()) : Json();
}

Json figures_json(const ComparedCircles& circles) {
  Json list = Json::array();
  for (const Quantity& quantity : catalogue()) {
    if (!is_compared(quantity)) continue;
    const std::string name(quantity.name);
    const Mean before = mean_of(circles.runs[0], name);
    const Mean after = mean_of(circles.runs[1], name);
    if (before.value.is_null() && after.value.is_null()) continue;
    list.push_back({{"quantity", name},
                    {"before", before.value},
                    {"before_sd", before.sd},
                    {"after", after.value},
                    {"after_sd", after.sd},
                    {"change", change_of(before.value, after.value)}});
  }
  return list;
}

Json vector_um(const Eigen::Vector2d& metres) { return {to_um(metres.x()), to_um(metres.y())}; }

Json harmonics_json(const ComparedCircles& circles) {
  std::array<std::vector<RepeatedHarmonic>, 2> sides;
  for (std::size_t side = 0; side < 2; ++side) {
    std::vector<std::vector<Harmonic>> runs;
    for (const StoredRun* run : circles.runs.at(side)) runs.push_back(run->harmonics);
    sides.at(side) = repeat_harmonics(runs);
  }
  const auto& [before, after] = sides;
  Json list = Json::array();
  for (std::size_t i = 0; i < std::min({before.size(), after.size(), kOrdersCompared}); ++i) {
    const auto mean_amplitude = [](const RepeatedHarmonic& h) {
      double sum = 0.0;
      for (const Eigen::Vector2d& v : h.values) sum += to_um(v.norm());
      return sum / static_cast<double>(h.values.size());
    };
    const Eigen::Vector2d moved = after[i].sample.mean - before[i].sample.mean;
    const std::optional<T2Test> test = drift_of(after[i], before[i]);
    list.push_back({{"order", after[i].order},
                    {"before_vector_um", vector_um(before[i].sample.mean)},
                    {"before_mean_amplitude_um", mean_amplitude(before[i])},
                    {"after_vector_um", vector_um(after[i].sample.mean)},
                    {"after_mean_amplitude_um", mean_amplitude(after[i])},
                    {"amplitude_change_um", mean_amplitude(after[i]) - mean_amplitude(before[i])},
                    {"moved_vector_um", vector_um(moved)},
                    {"moved_um", to_um(moved.norm())},
                    {"t2", test ? Json(test->t2) : Json()},
                    {"dof", test ? Json(test->dof) : Json()},
                    {"p_value", test ? Json(test->p_value) : Json()}});
  }
  return list;
}

/// Where in the summary of a line a figure stands.
struct LineFigure {
  const char* name;
  const char* part;  // "" for the line itself
  const char* key;
  const char* meaning;
};
constexpr std::array<LineFigure, 9> kLineFigures{
    {{"straightness_mz_um", "all_runs", "minimum_zone_um", "all runs, both ways: minimum zone (ISO 230-1)"},
     {"straightness_ls_um", "all_runs", "least_squares_um",
      "all runs, both ways: about the least-squares line"},
     {"straightness_ep_um", "all_runs", "end_points_um",
      "all runs, both ways: about the line through the ends"},
     {"forward_straightness_mz_um", "forward", "minimum_zone_um", "forward runs: minimum zone"},
     {"backward_straightness_mz_um", "backward", "minimum_zone_um", "backward runs: minimum zone"},
     {"reversal_max_um", "", "reversal_max_um", "mean forward minus mean backward, the largest by size"},
     {"reversal_mean_um", "", "reversal_mean_um", "mean forward minus mean backward, over the points"},
     {"repeatability_um", "bidirectional", "repeatability_um", "both ways (ISO 230-2 R), of the deviation"},
     {"accuracy_um", "bidirectional", "accuracy_um", "both ways (ISO 230-2 A), of the deviation"}}};

Json line_figure(const Json& line, const LineFigure& figure) {
  const std::string part = figure.part;
  if (part.empty()) return line.value(figure.key, Json());
  if (!line.contains(part) || line[part].is_null()) return {};
  return line[part].value(figure.key, Json());
}

Json lines_json(const std::vector<StoredRun>& before, const std::vector<StoredRun>& after) {
  const Json first = lines_summary(before);
  const Json second = lines_summary(after);
  Json list = Json::array();
  for (const Json& a : first)
    for (const Json& b : second) {
      if (a["robot"] != b["robot"] || a["test"] != b["test"] || a["axis"] != b["axis"]) continue;
      Json line{{"robot", a["robot"]},
                {"test", a["test"]},
                {"axis", a["axis"]},
                {"runs_before", a["runs"]},
                {"runs_after", b["runs"]}};
      line["figures"] = Json::array();
      const Json x = line_figures(a);
      const Json y = line_figures(b);
      for (std::size_t i = 0; i < x.size(); ++i)
        line["figures"].push_back({{"quantity", x[i]["quantity"]},
                                   {"before", x[i]["value"]},
                                   {"after", y[i]["value"]},
                                   {"change", change_of(x[i]["value"], y[i]["value"])}});
      list.push_back(std::move(line));
    }
  return list;
}

}  // namespace

Json line_figures(const Json& line) {
  Json list = Json::array();
  for (const LineFigure& figure : kLineFigures)
    list.push_back(
        {{"quantity", figure.name}, {"value", line_figure(line, figure)}, {"meaning", figure.meaning}});
  return list;
}

Json compare_json(const std::vector<StoredRun>& before, const std::vector<StoredRun>& after) {
  std::map<ComparedKey, ComparedCircles> groups;
  for (const std::size_t side : {0, 1})
    for (const StoredRun& run : side == 0 ? before : after)
      if (run.kind == TestKind::kCircle && !run.records.empty() && !run.harmonics.empty())
        groups[{run.robot, run.test, -run.direction, run.source}].runs.at(side).push_back(&run);
  Json json{{"before", before.empty() ? "" : before.front().series},
            {"after", after.empty() ? "" : after.front().series},
            {"circles", Json::array()}};
  for (const auto& [key, circles] : groups) {
    if (circles.runs[0].empty() || circles.runs[1].empty()) continue;
    json["circles"].push_back({{"robot", std::get<0>(key)},
                               {"test", std::get<1>(key)},
                               {"direction", -std::get<2>(key)},
                               {"source", std::get<3>(key)},
                               {"runs_before", circles.runs[0].size()},
                               {"runs_after", circles.runs[1].size()},
                               {"harmonics", harmonics_json(circles)},
                               {"figures", figures_json(circles)}});
  }
  json["lines"] = lines_json(before, after);
  return json;
}

}  // namespace ballbar
