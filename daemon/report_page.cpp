#include <algorithm>
#include <map>
#include <optional>
#include <set>
#include <tuple>

#include "core/error.hpp"
#include "core/units.hpp"
#include "daemon/compare.hpp"
#include "daemon/diagnosis_page.hpp"
#include "daemon/pages.hpp"
#include "daemon/pictures.hpp"
#include "daemon/report_parts.hpp"
#include "daemon/service.hpp"
#include "daemon/summary_json.hpp"
#include "daemon/tool.hpp"
#include "daemon/volumetric_out.hpp"
#include "numerics/statistics.hpp"
#include "pipeline/catalogue.hpp"
#include "report/canvas.hpp"
#include "report/html.hpp"

namespace ballbar {
namespace {

using Runs = std::vector<StoredRun>;

/// By robot, test, series and source; series of one test by their begin.
std::vector<Runs> groups_of(const Runs& runs) {
  std::vector<Runs> groups;
  for (const StoredRun& run : runs) {
    const auto found = std::find_if(groups.begin(), groups.end(), [&](const Runs& g) {
      return g.front().robot == run.robot && g.front().test == run.test && g.front().series == run.series &&
             g.front().source == run.source;
    });
    if (found == groups.end())
      groups.push_back({run});
    else
      found->push_back(run);
  }
  std::stable_sort(groups.begin(), groups.end(), [](const Runs& a, const Runs& b) {
    return std::tie(a.front().robot, a.front().test) < std::tie(b.front().robot, b.front().test);
  });
  return groups;
}

/// "55.33", or "55.33 to 60".
std::string range(const std::vector<double>& values, int decimals) {
  if (values.empty()) return "not known";
  const auto [low, high] = std::minmax_element(values.begin(), values.end());
  const std::string from = shown(*low, decimals);
  const std::string to = shown(*high, decimals);
  return from == to ? from : from + " to " + to;
}

std::string conditions_html(const std::vector<Runs>& groups) {
  HtmlTable table;
  table.left = 5;
  table.heading = {"robot", "test",      "series",        "begin (UTC)",    "end (UTC)",
                   "runs",  "feed mm/s", "payload kg",    "temperature °C", "plane",
                   "arc °", "filter",    "samples a run", "messages lost"};
  for (const Runs& runs : groups) {
    std::vector<double> feeds, payloads, temperatures, samples, begins, ends, filters;
    std::int64_t lost = 0;
    for (const StoredRun& run : runs) {
      feeds.push_back(to_mm(run.feed));
      payloads.push_back(run.payload);
      if (run.temperature) temperatures.push_back(*run.temperature);
      samples.push_back(static_cast<double>(run.samples));
      lost += run.lost_messages;
      if (run.records.empty()) continue;
      const auto take = [&](const char* name, std::vector<double>& values) {
        const auto& all = run.records.front().values;
        if (const auto found = all.find(name); found != all.end()) values.push_back(found->second.value);
      };
      // Clockwise runs begin where the others end.
      take(run.direction > 0 ? "start_angle_deg" : "end_angle_deg", begins);
      take(run.direction > 0 ? "end_angle_deg" : "start_angle_deg", ends);
      take("filter_upr", filters);
    }
    const StoredRun& first = runs.front();
    const bool circle = first.kind == TestKind::kCircle;
    table.rows.push_back({first.robot, first.test, first.series, utc_text(first.started_us),
                          utc_text(runs.back().ended_us), std::to_string(runs.size()), range(feeds, 2),
                          range(payloads, 3), range(temperatures, 1), first.plane,
                          circle ? range(begins, 1) + " to " + range(ends, 1) : "",
                          circle ? (filters.empty() ? "none" : range(filters, 0) + " upr") : "",
                          range(samples, 0), std::to_string(lost)});
  }
  std::string html = html_table(table);
  HtmlTable bad;
  bad.left = 5;
  bad.heading = {"run", "series", "begin (UTC)", "status", "why"};
  for (const Runs& runs : groups)
    for (const StoredRun& run : runs)
      if (run.status != "ok")
        bad.rows.push_back({run_name(run.test, run.direction, run.repetition), run.series,
                            utc_text(run.started_us), run.status, run.message});
  if (bad.rows.empty()) return html;
  return html + html_element("h3", "Runs that give no figures") + html_table(bad);
}

std::string mean_text(const std::vector<double>& values) {
  if (values.empty()) return "-";
  const std::optional<double> sd = sample_sd(values);
  return shown(mean(values), 2) + (sd ? " ± " + shown(*sd, 2) : "");
}

/// Means over the repetitions, one column a direction; for lines one a direction and axis.
std::string means_html(const Runs& runs, bool gap) {
  std::map<std::pair<std::string, int>, std::vector<const Record*>> columns;  // axis, direction: - first
  for (const StoredRun& run : runs)
    for (const Record& record : run.records) columns[{record.axis, -record.direction}].push_back(&record);
  const TestKind kind = runs.front().kind;
  HtmlTable table;
  table.heading = {"figure"};
  for (const auto& [key, records] : columns)
    table.heading.push_back(key.first + (key.first.empty() ? "" : " ") + way_of(kind, -key.second) + " (" +
                            std::to_string(records.size()) + ")");
  table.heading.emplace_back("what it is");
  table.last_is_words = true;
  for (const Quantity& quantity : catalogue()) {
    if (quantity.kind != (kind == TestKind::kCircle ? "circle" : "line")) continue;
    if (quantity.name.starts_with("gap_") != gap || quantity.name == "points") continue;
    std::vector<std::string> row{label_of_quantity(std::string(quantity.name))};
    bool known = false;
    for (const auto& [key, records] : columns) {
      std::vector<double> values;
      for (const Record* record : records)
        if (const auto found = record->values.find(std::string(quantity.name)); found != record->values.end())
          values.push_back(found->second.value);
      known = known || !values.empty();
      // A mean of angles is none: 179 and 1 degrees are 2 degrees apart.
      const bool angle = quantity.name.ends_with("_deg") || quantity.name == "gap_largest_mm";
      row.push_back(angle && values.size() > 1 ? "" : mean_text(values));
    }
    row.emplace_back(quantity.meaning);
    const bool empty =
        std::all_of(row.begin() + 1, row.end() - 1, [](const std::string& s) { return s.empty(); });
    if (known && !empty) table.rows.push_back(std::move(row));
  }
  return table.rows.empty() ? "" : html_table(table);
}

std::string bundles_html(const Runs& runs) {
  HtmlTable table;
  table.last_is_words = true;
  table.heading = {"all runs together", "value", "what it is"};
  const Json lines = lines_summary(runs);
  for (const Json& line : lines)
    for (const Json& figure : line_figures(line))
      if (figure["value"].is_number())
        table.rows.push_back(
            {line["axis"].get<std::string>() + " " + label_of_quantity(figure["quantity"].get<std::string>()),
             shown(figure["value"].get<double>(), 2), figure["meaning"].get<std::string>()});
  return table.rows.empty() ? "" : html_table(table);
}

std::string title_of(const Runs& group) {
  return group.front().robot + "   test " + group.front().test + "   series " + group.front().series +
         (group.front().source == "joints" ? "   from joints" : "");
}

std::string figures_html(const Store& store, const std::vector<Runs>& groups) {
  std::string html = html_element(
      "p",
      "Means over the runs ± standard deviation of a single run; the number of runs stands in brackets.");
  for (const Runs& runs : groups) {
    html += html_element("h3", title_of(runs));
    if (runs.front().kind == TestKind::kLine) html += bundles_html(runs);
    html += means_html(runs, false) + repeats_html(store, runs) + shapes_html(runs);
  }
  return html;
}

std::string gap_html(const std::vector<Runs>& groups) {
  std::string html;
  for (const Runs& runs : groups)
    if (const std::string table = means_html(runs, true); !table.empty())
      html += html_element("h3", title_of(runs)) + table;
  if (html.empty()) return html_element("p", "The model predicts none of these runs.");
  return html_element(
             "p",
             "Gap = measured minus predicted, with the ball, or the optics, where the model fits best: how "
             "these were set up is not the robot's error.") +
         html;
}

std::string baseline_of(const Store& store, const StoredRun& run, const std::string& wanted) {
  if (!wanted.empty()) return wanted;
  RunFilter filter;
  filter.robot = run.robot;
  filter.test = run.test;
  filter.status = "ok";
  filter.limit = 1;
  const Runs first = store.runs(filter);
  return first.empty() ? run.series : first.front().series;
}

/// A series and the baseline that it is held against.
struct Change {
  std::string baseline, series;
  Runs before, after;
  Json comparison;
};

/// Pairs of series, each with the runs of all tests that both have. Series that are baselines themselves are
/// left out.
std::vector<Change> changes_of(const Store& store, const std::vector<Runs>& groups,
                               const std::string& wanted) {
  std::vector<Change> changes;
  bool found = false;
  for (const Runs& runs : groups) {
    RunFilter filter;
    filter.robot = runs.front().robot;
    filter.test = runs.front().test;
    filter.series = baseline_of(store, runs.front(), wanted);
    filter.status = "ok";
    Runs before = store.runs(filter);
    std::erase_if(before, [&](const StoredRun& run) { return run.source != runs.front().source; });
    found = found || !before.empty();
    if (before.empty() || *filter.series == runs.front().series) continue;
    auto change = std::find_if(changes.begin(), changes.end(), [&](const Change& c) {
      return c.baseline == *filter.series && c.series == runs.front().series;
    });
    if (change == changes.end())
      change = changes.insert(changes.end(), {*filter.series, runs.front().series, {}, {}, {}});
    change->before.insert(change->before.end(), before.begin(), before.end());
    change->after.insert(change->after.end(), runs.begin(), runs.end());
  }
  if (!wanted.empty() && !found)
    throw Error(Cause::kInput, "no run of the baseline '" + wanted +
                                   "' that is ok fits these robots and tests; 'ballbar list' shows all runs");
  for (Change& change : changes) change.comparison = compare_json(change.before, change.after);
  return changes;
}

std::string changes_html(const std::vector<Change>& changes) {
  std::string html;
  for (const Change& change : changes)
    html += html_element("p", "before: series " + change.baseline + "   after: series " + change.series) +
            compare_html(change.comparison);
  return html.empty() ? html_element("p", "These runs are the baseline, or it has none of these tests.")
                      : html;
}

/// The figures to look at first: harmonic 2 as a vector, straightness of all runs.
std::string glance_html(const std::vector<Change>& changes) {
  HtmlTable table;
  table.left = 4;
  table.heading = {"test", "direction", "figure", "series", "baseline µm", "now µm", "moved µm", "p"};
  for (const Change& change : changes) {
    for (const Json& circle : change.comparison["circles"])
      for (const Json& h : circle["harmonics"])
        if (h["order"] == 2)
          table.rows.push_back({circle["test"], way_of(TestKind::kCircle, circle["direction"].get<int>()),
                                "ovality (harmonic 2)", change.series,
                                shown(h["before_mean_amplitude_um"].get<double>()),
                                shown(h["after_mean_amplitude_um"].get<double>()),
                                shown(h["moved_um"].get<double>()), p_text(h["p_value"])});
    for (const Json& line : change.comparison["lines"])
      for (const Json& f : line["figures"])
        if (f["quantity"] == "straightness_mz_um" && f["change"].is_number())
          table.rows.push_back({line["test"], "along " + line["axis"].get<std::string>(),
                                "straightness (minimum zone)", change.series,
                                shown(f["before"].get<double>()), shown(f["after"].get<double>()),
                                shown(f["change"].get<double>()), "-"});
  }
  if (table.rows.empty()) return "";
  return html_element("h2", "At a glance") + html_table(table);
}

std::string alarms_html(const Store& store, const Runs& runs) {
  HtmlTable table;
  table.left = 6;
  table.heading = {"time (UTC)", "run", "series", "severity", "became", "rule", "text"};
  table.last_is_words = true;
  for (const StoredRun& run : runs) {
    EventFilter filter;
    filter.run_id = run.id;
    for (const StoredEvent& event : store.events(filter)) {
      const AlarmStatus& status = event.event.status;
      table.rows.push_back({utc_text(status.since_us), run_name(run.test, run.direction, run.repetition),
                            run.series, status.severity, to_string(status.state), status.key.rule,
                            status.text});
    }
  }
  return table.rows.empty() ? html_element("p", "These runs changed no alarm.") : html_table(table);
}

/// The latest diagnosis of each series.
std::string diagnoses_html(const Store& store, const std::set<std::string>& robots,
                           const std::set<std::string>& series) {
  std::string html;
  for (const std::string& robot : robots) {
    const std::string before = robot + "   series ";
    for (const std::string& name : series) {
      GapFilter filter;
      filter.robot = robot;
      filter.series = name;
      filter.limit = 1;
      for (const StoredGap& gap : store.gaps(filter))
        html.append(html_element("h3", before + name))
            .append(diagnosis_html(nlohmann::ordered_json::parse(gap.json)));
    }
  }
  return html.empty() ? "" : html_element("h2", "Which physics the model lacks") + html;
}

}  // namespace

std::string report_page(const Store& store, const Runs& runs, const std::string& baseline,
                        const std::vector<Rule>& rules) {
  Runs ok;
  std::copy_if(runs.begin(), runs.end(), std::back_inserter(ok),
               [](const StoredRun& run) { return run.status == "ok" && !run.records.empty(); });
  std::set<std::string> robots, series;
  for (const StoredRun& run : runs) {
    robots.insert(run.robot);
    series.insert(run.series);
  }
  const auto list = [](const std::set<std::string>& words) {
    std::string all;
    for (const std::string& word : words) all += (all.empty() ? "" : ", ") + word;
    return all;
  };
  const std::string title = list(robots) + "   " + list(series);
  std::string body = html_element("h1", title);
  body += html_element("p", std::to_string(runs.size()) + (runs.size() == 1 ? " run" : " runs") + " from " +
                                utc_text(runs.front().started_us) + " to " + utc_text(runs.back().ended_us) +
                                " UTC, " + std::to_string(ok.size()) + " with figures.");
  const std::vector<Runs> groups = groups_of(ok);
  const std::vector<Change> changes = changes_of(store, groups, baseline);
  body += glance_html(changes);
  body += html_element("h2", "Alarms") + alarms_html(store, runs);
  if (!ok.empty()) {
    PictureOptions trend;
    trend.by_run = true;
    trend.rules = rules;
    body += html_element("h2", "Pictures") + pictures_html(store, ok, trend);
    body += html_element("h2", "What changed against the baseline") + changes_html(changes);
    body += html_element("h2", "Figures") + figures_html(store, groups) +
            volumetric_html(volumetric_summary(store, ok));
    body += html_element("h2", "Measured against predicted") + gap_html(groups);
  }
  body += diagnoses_html(store, robots, series);
  body += html_element("h2", "Conditions") + conditions_html(groups_of(runs));
  return html_page(title, body);
}

}  // namespace ballbar
