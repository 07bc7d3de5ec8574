#include <algorithm>
#include <map>
#include <set>

#include "core/error.hpp"
#include "daemon/compare.hpp"
#include "daemon/config.hpp"
#include "daemon/pages.hpp"
#include "daemon/pictures.hpp"
#include "report/html.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kHistory = 200;  // runs of a trend

class Figures {
 public:
  explicit Figures(const Store& store) : store_(store) {}

  void add(PictureKind kind, const std::vector<StoredRun>& runs, const PictureOptions& options,
           const std::string& caption) {
    try {
      const std::string svg = svg_of(picture_of(kind, store_, runs, options));
      html_ += html_figure(svg, "p" + std::to_string(++count_), caption);
    } catch (const Error& error) {  // a recording that was deleted shall not cost the page
      if (error.cause() != Cause::kInput) throw;
      html_ += html_element("p", std::string("A picture is missing: ") + error.what());
    }
  }
  std::string take() {
    std::string all = "<div class=\"pictures\">\n" + html_ + "</div>\n";
    html_.clear();
    return all;
  }

 private:
  const Store& store_;
  int count_ = 0;
  std::string html_;
};

/// The first run of each direction of the latest series, of those that the model predicts.
std::vector<StoredRun> predicted_ones(const std::vector<StoredRun>& runs) {
  std::map<int, StoredRun> first;
  for (const StoredRun& run : runs)
    if (run.series == runs.back().series && !run.predicted_from.empty()) first.emplace(run.direction, run);
  std::vector<StoredRun> chosen;
  for (auto& [direction, run] : first) chosen.insert(chosen.begin(), std::move(run));
  return chosen;
}

std::vector<StoredRun> history_of(const Store& store, const StoredRun& last) {
  RunFilter filter;
  filter.robot = last.robot;
  filter.test = last.test;
  filter.kind = last.kind;
  filter.status = "ok";
  filter.until_us = last.started_us + 1;
  filter.limit = kHistory;
  filter.newest_first = true;
  std::vector<StoredRun> runs = store.runs(filter);
  std::reverse(runs.begin(), runs.end());
  std::erase_if(runs, [&](const StoredRun& run) { return run.source != last.source; });
  return runs;
}

void add_circles(Figures& figures, const std::vector<StoredRun>& runs) {
  PictureOptions measured;
  measured.measured_only = true;
  figures.add(PictureKind::kPolar, runs, measured,
              "The path as the bar saw it, its deviations enlarged: outside the dark circle the robot is too "
              "far from "
              "the ball, inside too near. A peanut is ovality; steps are joints that turn back.");
  if (const std::vector<StoredRun> predicted = predicted_ones(runs); !predicted.empty())
    figures.add(PictureKind::kPolar, predicted, {},
                "Measured, and what the robot's model predicts (dotted). What lies between them is not in "
                "the model.");
  figures.add(
      PictureKind::kHarmonics, runs, {},
      "The path taken apart into waves: order 2 is an oval, order 3 a rounded triangle, and so on; backlash "
      "shows in the orders above 3.");
  figures.add(
      PictureKind::kOvality, runs, {},
      "Ovality as a vector: its length is the amplitude, its angle twice the direction of the oval. Two "
      "vectors of the same length may lie far apart: then the robot has changed.");
}

void add_lines(Figures& figures, const std::vector<StoredRun>& runs) {
  std::set<char> axes;
  for (const StoredRun& run : runs)
    for (const auto& [axis, points] : run.lines) axes.insert(axis);
  for (const char axis : axes) {
    std::vector<StoredRun> of_axis;
    std::copy_if(runs.begin(), runs.end(), std::back_inserter(of_axis), [&](const StoredRun& run) {
      return std::any_of(run.lines.begin(), run.lines.end(),
                         [&](const auto& line) { return line.first == axis; });
    });
    PictureOptions options;
    options.axis = std::string(1, axis);
    options.measured_only = true;
    figures.add(
        PictureKind::kLine, of_axis, options,
        "Deviation along " + options.axis +
            " at each stop. Zero and slope are those of the optics. Two bundles are the two ways: what lies "
            "between them is lost when the robot turns back.");
  }
}

}  // namespace

std::string pictures_html(const Store& store, const std::vector<StoredRun>& runs,
                          const std::optional<PictureOptions>& trend) {
  std::map<std::pair<std::string, std::string>, std::vector<StoredRun>> groups;
  for (const StoredRun& run : runs) groups[{run.robot, run.test}].push_back(run);
  Figures figures(store);
  std::string html;
  for (const auto& [key, group] : groups) {
    html += html_element("h3", key.first + "   test " + key.second);
    const bool circle = group.front().kind == TestKind::kCircle;
    if (circle)
      add_circles(figures, group);
    else
      add_lines(figures, group);
    if (trend)
      figures.add(PictureKind::kTrend, history_of(store, group.back()), *trend,
                  std::string(circle ? "Ovality" : "Straightness (minimum zone)") +
                      " of this and earlier runs of the test, in sequence, series by series.");
    html += figures.take();
  }
  return html;
}

std::string compare_page(const Store& store, const std::vector<StoredRun>& before,
                         const std::vector<StoredRun>& after, const Json& comparison) {
  const std::string title =
      comparison["before"].get<std::string>() + " and " + comparison["after"].get<std::string>();
  std::string body = html_element("h1", title);
  body += html_element("h2", "What changed") + compare_html(comparison);
  std::vector<StoredRun> runs = before;
  runs.insert(runs.end(), after.begin(), after.end());
  body += html_element("h2", "Pictures") + pictures_html(store, runs, std::nullopt);
  return html_page(title, body);
}

void write_page(const std::string& path, const std::string& page) {
  if (!path.ends_with(".html")) throw Error(Cause::kInput, path + ": a page's name ends in .html");
  write_text(path, page);
}

}  // namespace ballbar
