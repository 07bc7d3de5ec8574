/// What rules ask about earlier results: bounded windows of runs, and one figure of each at a time.

#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "pipeline/catalogue.hpp"
#include "store/labels.hpp"
#include "store/store.hpp"

namespace ballbar {
namespace {

constexpr std::string_view kNamed = "series ";
constexpr const char* kColumns =
    "SELECT r.id, r.series, r.direction, r.repetition, r.started_us, r.angle_source, r.plane, "
    "r.predicted_from "
    "FROM run r ";
// Each of these is answered from an index of its own; a line counts only where it has figures on the asked
// axis.
constexpr const char* kSame =
    "WHERE r.robot = ?1 AND r.test = ?2 AND r.direction = ?3 AND r.source = ?4 AND r.status = 'ok' AND "
    "r.started_us < ?5 AND r.started_us >= ?8 AND (?6 = '' OR EXISTS (SELECT 1 FROM quantity q WHERE "
    "q.run_id = r.id AND q.axis = ?6)) ";
constexpr const char* kOneWay =
    "SELECT id, started_us FROM run INDEXED BY run_judged_series WHERE robot = ?1 AND test = ?2 AND source = "
    "?4 AND "
    "status = 'ok' AND started_us < ?5 AND started_us >= ?8 AND series = ?9 AND direction = ";
constexpr const char* kEitherWay =
    "SELECT id, started_us FROM run INDEXED BY run_judged_both WHERE robot = ?1 AND test = ?2 AND source = "
    "?4 AND "
    "status = 'ok' AND started_us < ?5 AND started_us >= ?8 ";
// Both directions are completed by one of two runs, so they are looked for among more of them.
constexpr int kPairScan = 4;

/// "harmonic12_cos_um" as (table, order, column); nothing for other names.
struct HarmonicName {
  std::string table, column;
  int order = 0;
};
std::optional<HarmonicName> harmonic_name(const std::string& name) {
  if (!is_harmonic_name(name)) return std::nullopt;
  const bool gap = name.starts_with("gap_");
  const std::size_t digits = name.find("harmonic") + 8;
  const std::size_t rest = name.find('_', digits);
  return HarmonicName{gap ? "gap_harmonic" : "harmonic", name.substr(rest + 1),
                      std::stoi(name.substr(digits, rest - digits))};
}

class StorePast : public Past {
 public:
  StorePast(Database& db, Record like) : db_(db), like_(std::move(like)) {}

  const std::vector<Record>& window(const std::string& which) override { return window_of(which).records; }

  const std::vector<double>& column(const std::string& which, const std::string& name) override {
    Window& window = window_of(which);
    const auto found = window.columns.find(name);
    if (found != window.columns.end()) return found->second;
    const Snapshot snapshot(db_);  // one lock of the file for all rows
    return window.columns[name] = read(window.ids, name);
  }

 private:
  struct Window {
    std::vector<std::int64_t> ids;
    std::vector<Record> records;
    std::map<std::string, std::vector<double>> columns;
  };

  Window& window_of(const std::string& which) {
    const auto found = windows_.find(which);
    if (found != windows_.end()) return found->second;
    Window window;
    if (like_.kind == "circle" || like_.kind == "line" || like_.kind == "residual" || like_.kind == "test")
      fill(window, which);
    return windows_[which] = std::move(window);
  }

  void fill(Window& window, const std::string& which) {
    const Snapshot snapshot(db_);
    const bool newest = which == "recent";
    const std::size_t most = newest ? kPastRecent : kPastFirst;
    std::optional<std::string> series;
    if (which == "series") series = like_.series;
    if (which.starts_with(kNamed)) series = which.substr(kNamed.size());
    std::int64_t since_us = std::numeric_limits<std::int64_t>::min();
    if (which == "calibration") since_us = latest_mark().value_or(since_us);
    const std::string order = newest ? "ORDER BY started_us DESC LIMIT " : "ORDER BY started_us LIMIT ";
    const std::string sql = like_.kind == "test"
                                ? both_directions(order, series.has_value())
                                : std::string(kColumns) +
                                      (series ? "INDEXED BY run_judged_series " : "INDEXED BY run_judged ") +
                                      kSame + (series ? "AND r.series = ?9 " : "") + order + "?7";
    Statement query(db_, sql);
    const auto limit = static_cast<std::int64_t>(most);
    if (series) {
      query.bind(like_.robot, like_.test, like_.direction, like_.source, like_.started_us, like_.axis, limit,
                 since_us, *series);
    } else {
      query.bind(like_.robot, like_.test, like_.direction, like_.source, like_.started_us, like_.axis, limit,
                 since_us);
    }
    while (query.step()) {
      window.ids.push_back(query.integer(0));
      window.records.push_back(labels(query));
    }
    if (!newest) return;
    std::reverse(window.ids.begin(), window.ids.end());
    std::reverse(window.records.begin(), window.records.end());
  }

  static std::string both_directions(const std::string& order, bool one_series) {
    const std::string some = order + std::to_string(kPairScan) + " * ?7";
    const std::string runs = one_series ? std::string("SELECT * FROM (") + kOneWay + "1 " + some +
                                              ") UNION ALL SELECT * FROM (" + kOneWay + "-1 " + some + ")"
                                        : kEitherWay + some;
    return std::string(kColumns) + "WHERE ?3 = 0 AND ?6 = '' AND r.id IN (SELECT id FROM (" + runs +
           ") p WHERE EXISTS (SELECT 1 FROM quantity q WHERE q.run_id = p.id AND q.axis = '' AND "
           "q.name = 'positional_tolerance_um')) " +
           order + "?7";
  }

  Record labels(const Statement& row) const {
    Record record = like_;
    record.values.clear();
    record.series = row.text(1);
    if (like_.kind != "test") record.direction = row.small(2);
    record.repetition = row.small(3);
    record.started_us = row.integer(4);
    record.angle_source = row.text(5);
    record.plane = row.text(6);
    record.predicted_from = row.text(7);
    return record;
  }

  std::optional<std::int64_t> latest_mark() {
    Statement query(db_,
                    "SELECT max(at_us) FROM baseline_mark WHERE robot = ?1 AND (test = ?2 OR test = '') AND "
                    "at_us <= ?3");
    query.bind(like_.robot, like_.test, like_.started_us);
    return query.step() ? query.maybe_integer(0) : std::nullopt;
  }

  std::vector<double> read(const std::vector<std::int64_t>& ids, const std::string& name) {
    constexpr double kNone = std::numeric_limits<double>::quiet_NaN();
    std::vector<double> values;
    values.reserve(ids.size());
    const std::optional<HarmonicName> harmonic = harmonic_name(name);
    const std::string sql =
        harmonic ? "SELECT " +
                       (harmonic->column == "um" ? std::string("sqrt(cos_um * cos_um + sin_um * sin_um)")
                                                 : harmonic->column) +
                       " FROM " + harmonic->table + " WHERE run_id = ?1 AND ord = ?2"
                 : std::string("SELECT value FROM quantity WHERE run_id = ?1 AND axis = ?2 AND name = ?3");
    const bool radial = name.starts_with("radial_signature_");
    if (!harmonic && (radial || name.starts_with("signature_"))) return read_signature(ids, name, radial);
    Statement query(db_, sql);
    for (const std::int64_t id : ids) {
      if (harmonic) {
        query.bind(id, harmonic->order);
      } else {
        query.bind(id, like_.axis, name);
      }
      values.push_back(query.step() ? query.real(0) : kNone);
    }
    return values;
  }

  std::vector<double> read_signature(const std::vector<std::int64_t>& ids, const std::string& name,
                                     bool radial) {
    std::vector<double> values;
    Statement query(db_,
                    "SELECT value FROM signature WHERE run_id = ?1 AND frame = ?2 AND value IS NOT NULL AND "
                    "(CASE ?2 WHEN 'radial' THEN 'radial_' ELSE '' END) || 'signature_' || name || '_' || "
                    "replace(unit, '/', '_per_') = ?3");
    for (const std::int64_t id : ids) {
      query.bind(id, radial ? "radial" : "plane", name);
      values.push_back(query.step() ? query.real(0) : std::numeric_limits<double>::quiet_NaN());
    }
    return values;
  }

  Database& db_;
  Record like_;
  std::map<std::string, Window> windows_;
};

}  // namespace

std::unique_ptr<Past> Store::past(const Record& like) const {
  return std::make_unique<StorePast>(*db_, like);
}

void Store::set_baseline(const BaselineMark& mark) {
  Transaction transaction(*db_);
  Statement insert(
      *db_,
      "INSERT INTO baseline_mark (robot, test, at_us, note) SELECT ?1, ?2, ?3, ?4 WHERE NOT EXISTS "
      "(SELECT 1 FROM baseline_mark WHERE robot = ?1 AND test = ?2 AND at_us = ?3)");
  insert.bind(mark.robot, mark.test, mark.at_us, mark.note).run();
  transaction.commit();
}

std::vector<BaselineMark> Store::baselines() const {
  Statement query(*db_, "SELECT robot, test, at_us, note FROM baseline_mark ORDER BY at_us, id");
  std::vector<BaselineMark> marks;
  while (query.step()) marks.push_back({query.text(0), query.text(1), query.integer(2), query.text(3)});
  return marks;
}

std::vector<LastRun> Store::last_runs(std::int64_t until_us) const {
  Statement query(*db_,
                  "SELECT robot, test, max(ended_us) FROM run WHERE status = 'ok' AND ended_us <= ?1 "
                  "GROUP BY robot, test");
  query.bind(until_us);
  std::vector<LastRun> found;
  while (query.step()) found.push_back({query.text(0), query.text(1), query.integer(2)});
  return found;
}

DayCounts Store::counts_between(const std::string& robot, std::int64_t since_us,
                                std::int64_t until_us) const {
  Statement query(
      *db_,
      "SELECT count(*), total(status <> 'ok'), total(lost_messages), total(receiver_restarts) FROM "
      "run WHERE robot = ?1 AND started_us BETWEEN ?2 AND ?3");
  query.bind(robot, since_us, until_us).step();
  return {query.integer(0), static_cast<std::int64_t>(query.real(1)),
          static_cast<std::int64_t>(query.real(2)), static_cast<std::int64_t>(query.real(3))};
}

}  // namespace ballbar
