#include "daemon/picture_parts.hpp"

#include <algorithm>
#include <array>
#include <map>
#include <set>
#include <utility>

#include "core/error.hpp"
#include "daemon/rule_limits.hpp"
#include "daemon/tool.hpp"
#include "pipeline/catalogue.hpp"
#include "report/trend_plot.hpp"

namespace ballbar {
namespace {

/// "A, B": each word once, in sequence.
void add_word(std::string& list, std::set<std::string>& seen, const std::string& word) {
  if (word.empty() || !seen.insert(word).second) return;
  list += (list.empty() ? "" : ", ") + word;
}

}  // namespace

Heading heading_of(const std::vector<StoredRun>& runs) {
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

std::string with_way(const std::string& group, TestKind kind, int direction) {
  return group + (group.empty() ? "" : "   ") + way_of(kind, direction);
}

std::string label_of_quantity(const std::string& name) {
  constexpr std::array<std::pair<const char*, const char*>, 8> kUnits{{{"_um_per_m", "µm/m"},
                                                                       {"_ppm_k", "ppm/K"},
                                                                       {"_um", "µm"},
                                                                       {"_mm_s", "mm/s"},
                                                                       {"_mm", "mm"},
                                                                       {"_deg", "°"},
                                                                       {"_kg", "kg"},
                                                                       {"_c", "°C"}}};
  std::string words = name;
  std::string unit;
  for (const auto& [ending, shown] : kUnits) {
    if (!words.ends_with(ending)) continue;
    words.resize(words.size() - std::string(ending).size());
    unit = std::string(" [") + shown + "]";
    break;
  }
  std::replace(words.begin(), words.end(), '_', ' ');
  return words + unit;
}

PlotScript trend_picture(const Store& store, const std::vector<StoredRun>& chosen,
                         const PictureOptions& options) {
  const std::string quantity = !options.quantity.empty()                  ? options.quantity
                               : chosen.front().kind == TestKind::kCircle ? "ovality_um"
                                                                          : "straightness_mz_um";
  if (!is_quantity(quantity, "circle") && !is_quantity(quantity, "line"))
    throw Error(Cause::kInput, "no quantity is called '" + quantity +
                                   "'; 'ballbar show RUN' names all, and harmonic<k>_um, harmonic<k>_cos_um, "
                                   "harmonic<k>_sin_um are there too");
  if (!options.limits_um.empty() && !quantity.ends_with("_um"))
    throw Error(Cause::kInput, "--limit-um is of lengths, but " + quantity + " is none");
  RunFilter filter;
  for (const StoredRun& run : chosen) filter.ids.push_back(run.id);
  filter.harmonic_orders = kAllHarmonicOrders;
  std::vector<StoredRun> runs = store.runs(filter);
  std::erase_if(runs, [&](const StoredRun& run) {
    return std::none_of(run.records.begin(), run.records.end(),
                        [&](const Record& record) { return record.values.contains(quantity); });
  });
  if (!options.axis.empty())
    for (StoredRun& run : runs)
      std::erase_if(run.records, [&](const Record& record) { return record.axis != options.axis; });
  if (runs.empty()) throw Error(Cause::kInput, "none of these runs gives " + quantity);
  const Apart apart(runs);
  const Heading head = heading_of(runs);
  TrendPlot plot;
  plot.title = head.title;
  plot.value_label = label_of_quantity(quantity);
  plot.subtitle = plot.value_label.substr(0, plot.value_label.find(" [")) + "   " +
                  utc_text(runs.front().started_us) + " to " + utc_text(runs.back().started_us) + " UTC";
  plot.by_run = options.by_run;
  std::vector<Record> records;
  for (const StoredRun& run : runs) records.insert(records.end(), run.records.begin(), run.records.end());
  plot.limits = limits_of(options.rules, quantity, records);
  for (const double limit : options.limits_um) plot.limits.push_back({limit});
  std::map<std::pair<std::string, int>, Trend> trends;
  Trend marked{options.marked_label, options.marked_label, chosen.front().direction, {}};
  for (const StoredRun& run : runs)
    for (const Record& record : run.records) {
      const auto found = record.values.find(quantity);
      if (found == record.values.end()) continue;
      std::string group = apart.group(run, false);
      if (!record.axis.empty()) group += (group.empty() ? "" : " ") + record.axis;
      Trend& trend = trends[{group, -run.direction}];
      trend.group = group;
      trend.direction = run.direction;
      trend.label = with_way(group, run.kind, run.direction);
      trend.points.push_back({run.started_us, found->second.value, found->second.sd, run.series});
      if (std::find(options.marked.begin(), options.marked.end(), run.started_us) == options.marked.end())
        continue;
      marked.points.push_back(trend.points.back());
    }
  plot.notes = options.notes;
  for (auto& [key, trend] : trends) plot.trends.push_back(std::move(trend));
  if (!marked.points.empty()) plot.trends.push_back(std::move(marked));
  return trend_script(plot);
}

}  // namespace ballbar
