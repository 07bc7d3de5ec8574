#include "daemon/since_when.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "core/error.hpp"
#include "core/units.hpp"
#include "daemon/series_diagnosis.hpp"
#include "daemon/service.hpp"
#include "daemon/tool.hpp"
#include "numerics/change_point.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using nlohmann::ordered_json;

constexpr double kAlpha = 0.01;        // of all histories of a robot together
constexpr double kSameFeed = 0.01;     // share by which feeds may differ
constexpr double kSamePayload = 0.01;  // [kg]
constexpr double kAsGood = 5.0;        // ln: what is less likely by less could as well be it
constexpr std::size_t kMostTwins = 4;

Index columns() { return 2 * Index{kLastChangedOrder - kFirstChangedOrder + 1}; }

/// cos 2, sin 2, cos 3, ... of each run [m].
MatrixXd harmonics_of(const std::vector<StoredRun>& runs) {
  MatrixXd rows = MatrixXd::Zero(static_cast<Index>(runs.size()), columns());
  for (std::size_t i = 0; i < runs.size(); ++i)
    for (const Harmonic& h : runs[i].harmonics) {
      if (h.order < kFirstChangedOrder || h.order > kLastChangedOrder) continue;
      const Index at = 2 * Index{h.order - kFirstChangedOrder};
      rows(static_cast<Index>(i), at) = h.cos;
      rows(static_cast<Index>(i), at + 1) = h.sin;
    }
  return rows;
}

std::vector<TestHistory> histories_of(const Store& store, const RobotSpec& robot, const std::string& test) {
  RunFilter filter;
  filter.robot = robot.name;
  filter.kind = TestKind::kCircle;
  filter.status = "ok";
  if (!test.empty()) filter.test = test;
  std::map<std::pair<std::string, int>, TestHistory> all;
  for (StoredRun& run : store.runs(filter)) {
    if (!can_be_diagnosed(run) || run.direction == 0 || !robot.find_test(run.test)) continue;
    if (run.harmonics.empty() || run.harmonics.back().order < kFirstChangedOrder) continue;
    TestHistory& history = all[{run.test, -run.direction}];
    history.test = run.test;
    history.direction = run.direction;
    history.runs.push_back(std::move(run));
  }
  std::vector<TestHistory> histories;
  for (auto& [key, history] : all) {
    const double feed = history.runs.back().feed, payload = history.runs.back().payload;
    std::erase_if(history.runs, [&](const StoredRun& run) {
      return std::abs(run.feed - feed) > kSameFeed * feed || std::abs(run.payload - payload) > kSamePayload;
    });
    histories.push_back(std::move(history));
  }
  return histories;
}

std::vector<SeenChange> changes_in(const TestHistory& history, double alpha) {
  const MatrixXd rows = harmonics_of(history.runs);
  std::vector<SeenChange> seen;
  for (const ChangePoint& change : changes(rows, alpha)) {
    const auto run = [&](Index i) -> const StoredRun& { return history.runs[static_cast<std::size_t>(i)]; };
    SeenChange one;
    one.test = history.test;
    one.direction = history.direction;
    one.last_before = run(change.first_after - 1).id;
    one.first_after = run(change.first_after).id;
    one.first_after_us = run(change.first_after).started_us;
    // It lies behind the begin of the run before the first that may be the first.
    one.earliest_us = run(change.earliest - 1).started_us;
    one.latest_us = run(change.latest).started_us;
    one.place = static_cast<int>(change.first_after);
    one.earliest_run = static_cast<int>(change.earliest);
    one.latest_run = static_cast<int>(change.latest);
    one.orders = static_cast<int>(std::max<Index>(1, components_for(rows.rows()) / 2));
    one.orders = std::min(one.orders, kLastChangedOrder - kFirstChangedOrder + 1);
    one.step = change.step.norm();
    one.p_value = change.p_value;
    one.gradual = change.gradual;
    seen.push_back(one);
  }
  return seen;
}

/// Changes whose ranges of time overlap are one, by time.
std::vector<RobotChange> joined(std::vector<SeenChange> seen) {
  std::stable_sort(seen.begin(), seen.end(), [](const SeenChange& a, const SeenChange& b) {
    return a.first_after_us < b.first_after_us;
  });
  std::vector<RobotChange> all;
  for (SeenChange& one : seen) {
    const bool same = !all.empty() && one.earliest_us < all.back().latest_us;
    if (!same) {
      all.push_back({{}, one.earliest_us, one.latest_us, {}});
    } else {
      all.back().earliest_us = std::max(all.back().earliest_us, one.earliest_us);
      all.back().latest_us = std::min(all.back().latest_us, one.latest_us);
    }
    all.back().seen.push_back(std::move(one));
  }
  for (RobotChange& change : all)
    std::stable_sort(change.seen.begin(), change.seen.end(),
                     [](const SeenChange& a, const SeenChange& b) { return a.p_value < b.p_value; });
  return all;
}

/// Mean and scatter of the runs that began in [from, to).
struct Part {
  VectorXd mean, variance;
  double count = 0.0;
};

Part part_of(const TestHistory& history, std::int64_t from_us, std::int64_t to_us) {
  std::vector<StoredRun> runs;
  for (const StoredRun& run : history.runs)
    if (run.started_us >= from_us && run.started_us < to_us) runs.push_back(run);
  Part part{VectorXd::Zero(columns()), VectorXd::Zero(columns()), static_cast<double>(runs.size())};
  if (runs.empty()) return part;
  const MatrixXd rows = harmonics_of(runs);
  part.mean = rows.colwise().mean();
  part.variance = (rows.rowwise() - part.mean.transpose()).cwiseAbs2().colwise().sum();
  return part;
}

/// What every test and direction says of a change between its neighbours in time.
void liken(const Store& store, const GapModel& model, const std::vector<TestHistory>& histories,
           std::int64_t from_us, std::int64_t to_us, RobotChange& change) {
  std::vector<MeasuredRun> runs;
  std::vector<std::pair<const TestHistory*, HarmonicChange>> moved;
  for (const TestHistory& history : histories) {
    const Part before = part_of(history, from_us, change.earliest_us + 1);
    const Part after = part_of(history, change.latest_us, to_us);
    if (before.count < 2.0 || after.count < 2.0) continue;
    HarmonicChange one;
    one.step = after.mean - before.mean;
    const VectorXd variance = (before.variance + after.variance) / (before.count + after.count - 2.0);
    // Orders alike: few runs do not tell their scatters apart.
    const double common = std::max(variance.mean(), 1e-16);
    one.sd = (0.5 * (variance.array() + common) * (1.0 / before.count + 1.0 / after.count)).sqrt();
    moved.emplace_back(&history, one);
    runs.push_back(measured_run(store, history.runs.back()));
  }
  const Observations observations = observe(std::move(runs), model.spec(), model.model());
  std::vector<HarmonicChange> changes;
  for (auto& [history, one] : moved)
    for (std::size_t i = 0; i < observations.all.size(); ++i)
      if (observations.all[i].test == history->test && observations.all[i].direction == history->direction) {
        one.observation = i;
        changes.push_back(one);
        break;
      }
  change.likeness = looks_like(model, observations.all, changes);
}

std::string number(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string way(const std::string& test, int direction) { return test + (direction > 0 ? "+1" : "-1"); }

std::string name_of(const Likeness& like) {
  std::string name = like.effect + (like.kind.empty() ? "" : " (" + like.kind + ")");
  if (like.joint > 0) name += " of joint " + std::to_string(like.joint);
  return name;
}

/// Those that are as good as the best, without it.
std::vector<Likeness> twins_of(const RobotChange& change) {
  std::vector<Likeness> twins;
  for (std::size_t i = 1; i < change.likeness.size() && twins.size() < kMostTwins; ++i)
    if (change.likeness[i].worse < kAsGood) twins.push_back(change.likeness[i]);
  return twins;
}

ordered_json to_json(const Likeness& like) {
  ordered_json json{{"effect", like.effect}};
  if (!like.kind.empty()) json["kind"] = like.kind;
  json["joint"] = like.joint;
  json["explains"] = like.explains;
  json["size_um"] = like.size / kMetresPerUm;
  json["less_likely"] = like.worse;
  json["parameters"] = ordered_json::array();
  for (const auto& [name, value] : like.parameters)
    json["parameters"].push_back({{"name", name}, {"change", value}});
  return json;
}

}  // namespace

SinceWhen since_when(const Store& store, const RobotSpec& robot, const AsBuilt& built,
                     const std::string& test) {
  SinceWhen found{robot.name, histories_of(store, robot, test), {}};
  std::erase_if(found.histories, [](const TestHistory& history) {
    return components_for(static_cast<Index>(history.runs.size())) < 1;
  });
  if (found.histories.empty())
    throw Error(Cause::kInput,
                "robot '" + robot.name +
                    "' has no history of five or more circles of one test, direction, feed and payload" +
                    (test.empty() ? "" : " '" + test + "'") + "; see ballbar list");
  std::vector<SeenChange> seen;
  for (const TestHistory& history : found.histories)
    for (SeenChange& one : changes_in(history, kAlpha / static_cast<double>(found.histories.size())))
      seen.push_back(std::move(one));
  found.changes = joined(std::move(seen));
  const GapModel model(built, robot);
  for (std::size_t i = 0; i < found.changes.size(); ++i) {
    const std::int64_t from = i == 0 ? INT64_MIN : found.changes[i - 1].latest_us;
    const std::int64_t to = i + 1 == found.changes.size() ? INT64_MAX : found.changes[i + 1].earliest_us + 1;
    liken(store, model, found.histories, from, to, found.changes[i]);
  }
  return found;
}

ordered_json to_json(const SinceWhen& found) {
  ordered_json json{{"robot", found.robot}};
  json["histories"] = ordered_json::array();
  for (const TestHistory& history : found.histories)
    json["histories"].push_back(
        {{"test", history.test}, {"direction", history.direction}, {"runs", history.runs.size()}});
  json["changes"] = ordered_json::array();
  for (const RobotChange& change : found.changes) {
    ordered_json one{{"between_us", {change.earliest_us, change.latest_us}}};
    one["seen"] = ordered_json::array();
    for (const SeenChange& seen : change.seen)
      one["seen"].push_back({{"test", seen.test},
                             {"direction", seen.direction},
                             {"last_run_before", seen.last_before},
                             {"first_run_after", seen.first_after},
                             {"place", seen.place},
                             {"place_95_percent", {seen.earliest_run, seen.latest_run}},
                             {"step_um", seen.step / kMetresPerUm},
                             {"p_value", seen.p_value},
                             {"gradual", seen.gradual}});
    one["looks_like"] = ordered_json::array();
    if (!change.likeness.empty()) one["looks_like"].push_back(to_json(change.likeness.front()));
    one["cannot_be_told_from"] = ordered_json::array();
    for (const Likeness& twin : twins_of(change)) one["cannot_be_told_from"].push_back(to_json(twin));
    json["changes"].push_back(std::move(one));
  }
  return json;
}

std::string to_text(const SinceWhen& found) {
  std::size_t runs = 0;
  for (const TestHistory& history : found.histories) runs += history.runs.size();
  std::string text = "Robot " + found.robot + ": " + std::to_string(runs) + " circles in " +
                     std::to_string(found.histories.size()) +
                     " histories of one test, direction, feed and payload.\n";
  if (found.changes.empty())
    return text + "Nothing has changed that the scatter of the runs does not explain.\n";
  for (const RobotChange& change : found.changes) {
    const bool gradual = std::any_of(change.seen.begin(), change.seen.end(),
                                     [](const SeenChange& seen) { return seen.gradual; });
    text += "\nThe robot changed between " + utc_text(change.earliest_us) + " and " +
            utc_text(change.latest_us) + " (UTC, 95 %)" +
            (gradual ? ", or went over by and by: an even drift fits better than a step" : "") + ".\n";
    if (!change.likeness.empty()) {
      const Likeness& best = change.likeness.front();
      text += "It looks like " + name_of(best) + ", which explains " + number("%.0f", 100.0 * best.explains) +
              " % of it (" + number("%.1f", best.size / kMetresPerUm) + " um)";
      for (const auto& [name, value] : best.parameters) text += ", " + name + " " + number("%+.4g", value);
      text += ".";
      for (const Likeness& twin : twins_of(change)) text += "\nIt could as well be " + name_of(twin) + ".";
      text += "\n";
    }
    for (const SeenChange& seen : change.seen)
      text += "- " + way(seen.test, seen.direction) + ": run " + std::to_string(seen.first_after) +
              " is the first after it (" + std::to_string(seen.place + 1) +
              " of the history, 95 %: " + std::to_string(seen.earliest_run + 1) + " to " +
              std::to_string(seen.latest_run + 1) + "), run " + std::to_string(seen.last_before) +
              " the last before; harmonics moved by " + number("%.2f", seen.step / kMetresPerUm) + " um, p " +
              number("%.2g", seen.p_value) + "\n";
  }
  return text;
}

}  // namespace ballbar
