#include "daemon/volumetric_out.hpp"

#include <cctype>
#include <map>
#include <optional>
#include <set>
#include <tuple>
#include <utility>

#include "core/units.hpp"
#include "daemon/text_table.hpp"
#include "metrology/volumetric.hpp"
#include "pipeline/circle_test.hpp"
#include "report/canvas.hpp"
#include "report/html.hpp"

namespace ballbar {
namespace {

using Group = std::tuple<std::string, std::string, std::string>;  // robot, series, source

/// The programmed circle of a run in a plane of the base frame.
std::optional<CircleSpec> circle_of(const StoredRun& run) {
  if (run.kind != TestKind::kCircle || run.direction == 0 || run.records.empty()) return std::nullopt;
  const auto& values = run.records.front().values;
  const auto radius = values.find("nominal_radius_mm");
  if (radius == values.end()) return std::nullopt;
  return plane_named(run.plane, radius->second.value * kMetresPerMm);
}

std::string upper(std::string text) {
  for (char& c : text) c = static_cast<char>(std::toupper(static_cast<unsigned char>(c)));
  return text;
}

/// Each of the six: its name in the JSON, and what people call it.
std::vector<std::pair<std::string, std::string>> figures() {
  std::vector<std::pair<std::string, std::string>> all;
  all.reserve(kAxisPairs.size() + kAxes.size());
  for (const char* pair : kAxisPairs)
    all.emplace_back(std::string("squareness_") + pair + "_um_per_m", "squareness " + upper(pair));
  for (const char* axis : kAxes)
    all.emplace_back(std::string("scaling_") + axis + "_um_per_m", "scaling " + upper(axis));
  return all;
}

std::string value_text(const Json& entry, const std::string& name, const char* plus_minus) {
  return shown(entry[name].get<double>(), 2) + plus_minus + shown(entry[name + "_sd"].get<double>(), 2);
}

}  // namespace

Json volumetric_summary(const Store& store, const std::vector<StoredRun>& runs) {
  std::map<Group, std::vector<const StoredRun*>> groups;
  for (const StoredRun& run : runs)
    if (circle_of(run)) groups[{run.robot, run.series, run.source}].push_back(&run);
  Json list = Json::array();
  for (const auto& [group, members] : groups) {
    std::set<std::string> planes, tests;
    for (const StoredRun* run : members) {
      planes.insert(run->plane.substr(0, 2));
      tests.insert(run->test);
    }
    if (planes.size() < 3) continue;
    std::vector<PlaneTrace> traces;
    for (const StoredRun* run : members) {
      const Trace trace = store.trace(run->id);
      if (trace.angle.size() != trace.bar_deviation.size()) continue;
      CircleTrace measured = measured_arc(trace.angle, trace.bar_deviation, trace.arc_begin, trace.arc_end);
      measured.direction = run->direction;
      traces.push_back({run->test, *circle_of(*run), std::move(measured)});
    }
    const std::optional<Volumetric> found = analyse_volumetric(traces);
    if (!found) continue;
    Json json{{"robot", std::get<0>(group)},  {"series", std::get<1>(group)},
              {"source", std::get<2>(group)}, {"tests", tests},
              {"runs", traces.size()},        {"residual_um", to_um(found->residual)}};
    const auto put = [&](const std::string& name, const Estimate& ratio) {
      json[name] = to_ppm(ratio.value);
      json[name + "_sd"] = to_ppm(ratio.sd.value_or(0.0));
    };
    for (std::size_t k = 0; k < 3; ++k) {
      put(std::string("squareness_") + kAxisPairs[k] + "_um_per_m", found->squareness[k]);
      put(std::string("scaling_") + kAxes[k] + "_um_per_m", found->scaling[k]);
    }
    list.push_back(std::move(json));
  }
  return list;
}

std::string volumetric_text(const Json& summary) {
  if (summary.empty()) return "";
  std::vector<std::vector<std::string>> rows{{"robot", "series", "source"}};
  for (const auto& [name, words] : figures()) rows.front().push_back(words);
  rows.front().emplace_back("residual um");
  for (const Json& entry : summary) {
    std::vector<std::string>& row = rows.emplace_back();
    for (const char* label : {"robot", "series", "source"}) row.push_back(entry[label]);
    for (const auto& [name, words] : figures()) row.push_back(value_text(entry, name, " +- "));
    row.push_back(shown(entry["residual_um"].get<double>(), 2));
  }
  constexpr std::size_t kLabels = 3;
  return "Volumetric analysis, circles in three planes: um/m. On a robot these are shapes of the volume, not "
         "causes\n" +
         text_table(rows, kLabels) + "\n";
}

std::string volumetric_html(const Json& summary) {
  std::string html;
  for (const Json& entry : summary) {
    HtmlTable table;
    table.heading = {"figure", "value µm/m", "what it is"};
    table.last_is_words = true;
    for (const auto& [name, words] : figures())
      table.rows.push_back({words, value_text(entry, name, " ± "),
                            words.starts_with("square")
                                ? "the angle between the two axes is so much more than 90 degrees: 1 µm/m is "
                                  "0.2 seconds of arc"
                                : "motion along the axis is so much longer than commanded; all three hold an "
                                  "error of the bar's length, their differences do not"});
    std::string tests;
    for (const Json& test : entry["tests"]) tests += (tests.empty() ? "" : ", ") + test.get<std::string>();
    html +=
        html_element("h3", "Volumetric analysis   " + entry["robot"].get<std::string>() + "   series " +
                               entry["series"].get<std::string>() +
                               (entry["source"] == "joints" ? "   from joints" : "")) +
        html_element(
            "p", "Circles in three planes (tests " + tests + ", " + std::to_string(entry["runs"].get<int>()) +
                     " runs) as one fit; what it leaves is " + shown(entry["residual_um"].get<double>(), 2) +
                     " µm rms. On a robot these are shapes of the volume about the ball, not "
                     "causes: it has no X, Y and Z slides.") +
        html_table(table);
  }
  return html;
}

}  // namespace ballbar
