#include <algorithm>
#include <stdexcept>
#include <string>

#include "core/units.hpp"
#include "store/labels.hpp"
#include "store/store.hpp"
#include "store/stored_run.hpp"

namespace ballbar {

namespace {

constexpr std::int64_t kHour = 3'600'000'000;  // us

std::int64_t limit_or_all(std::int64_t limit) { return limit > 0 ? limit : -1; }  // SQLite: negative = all

/// JSON list, for json_each: one prepared statement whatever the number of ids.
std::optional<std::string> id_list(const std::vector<std::int64_t>& ids) {
  if (ids.empty()) return std::nullopt;
  std::string list = "[";
  for (const std::int64_t id : ids) list += (list.size() > 1 ? "," : "") + std::to_string(id);
  return list + "]";
}

}  // namespace

bool Store::has(const std::string& robot, std::int64_t started_us) const {
  Statement query(*db_, "SELECT 1 FROM run WHERE robot = ?1 AND started_us = ?2");
  return query.bind(robot, started_us).step();
}

std::optional<RunEnd> Store::end_of(const std::string& robot, std::int64_t started_us) const {
  Statement query(*db_, "SELECT ended_by FROM run WHERE robot = ?1 AND started_us = ?2");
  if (!query.bind(robot, started_us).step()) return {};
  return run_end_from(query.text(0));
}

AxisPoints Store::line_partner(const std::string& robot, const std::string& test, const std::string& series,
                               int direction, int repetition, std::int64_t before_us) const {
  if (direction == 0) return {};
  Statement query(
      *db_,
      "SELECT r.id FROM run r WHERE r.robot = ?1 AND r.test = ?2 AND r.series = ?3 AND r.direction = ?4 "
      "AND r.started_us < ?6 AND r.kind = 'line' AND r.status = 'ok' "
      "AND EXISTS (SELECT 1 FROM line_point p WHERE p.run_id = r.id) "
      "ORDER BY r.repetition = ?5 DESC, r.started_us DESC LIMIT 1");
  query.bind(robot, test, series, -direction, repetition, before_us);
  if (!query.step()) return {};
  return read_points(*db_, query.integer(0));
}

std::string Store::source_before(const Run& run) const {
  Statement query(*db_,
                  "SELECT source FROM run INDEXED BY run_time WHERE started_us < ?4 AND started_us >= ?5 "
                  "AND robot = ?1 AND series = ?2 AND kind = 'circle' AND status = 'ok' "
                  "ORDER BY test = ?3 DESC, started_us DESC LIMIT 1");
  query.bind(run.robot, run.series, run.test, run.started_us,
             run.started_us - (run.series.empty() ? kHour : 24 * kHour));
  return query.step() ? query.text(0) : "";
}

std::optional<CirclePartner> Store::circle_partner(const Run& run, const std::string& source) const {
  if (run.direction == 0) return std::nullopt;
  Statement query(*db_,
                  "SELECT r.id, r.feed_mm_s, r.temperature_c, t.coding, t.bytes FROM run r "
                  "JOIN trace t ON t.run_id = r.id WHERE r.robot = ?1 AND r.test = ?2 AND r.series = ?3 "
                  "AND r.direction = ?4 AND r.repetition = ?5 AND r.source = ?6 AND r.kind = 'circle' "
                  "AND r.status = 'ok' AND r.started_us < ?7 AND (?3 <> '' OR r.started_us >= ?7 - ?8) "
                  "AND abs(r.feed_mm_s - ?9) <= 0.01 * ?9 AND NOT EXISTS (SELECT 1 FROM quantity q "
                  "WHERE q.run_id = r.id AND q.axis = '' AND q.name = 'hysteresis_um') "
                  "ORDER BY r.started_us DESC LIMIT 1");
  query.bind(run.robot, run.test, run.series, -run.direction, run.repetition, source, run.started_us, kHour,
             to_mm(run.feed));
  if (!query.step()) return std::nullopt;
  CirclePartner partner;
  partner.id = query.integer(0);
  partner.direction = -run.direction;
  partner.feed = metres_from_mm(query.real(1));
  partner.temperature = query.maybe_real(2);
  try {
    partner.trace = decode(query.small(3), query.blob(4));
  } catch (const std::runtime_error&) {
    return std::nullopt;  // its results stand, only the recording is lost
  }
  return partner;
}

std::vector<StoredRun> Store::runs(const RunFilter& filter) const {
  const Snapshot snapshot(*db_);
  const std::string order = filter.newest_first ? "r.started_us DESC, r.robot DESC" : "r.started_us, r.robot";
  Statement query(*db_, std::string("SELECT ") + kRunColumns +
                            " FROM run r WHERE (?1 IS NULL OR r.id IN (SELECT value FROM json_each(?1))) "
                            "AND (?2 IS NULL OR r.robot = ?2) AND (?3 IS NULL OR r.test = ?3) "
                            "AND (?4 IS NULL OR r.series = ?4) AND (?5 IS NULL OR r.status = ?5) "
                            "AND (?6 IS NULL OR r.kind = ?6) AND (?7 IS NULL OR r.direction = ?7) "
                            "AND r.started_us >= coalesce(?8, -9223372036854775808) AND r.started_us < "
                            "coalesce(?9, 9223372036854775807) ORDER BY " +
                            order + " LIMIT ?10");
  std::optional<std::string> kind;
  if (filter.kind) kind = to_string(*filter.kind);
  query.bind(id_list(filter.ids), filter.robot, filter.test, filter.series, filter.status, kind,
             filter.direction, filter.since_us, filter.until_us, limit_or_all(filter.limit));
  std::vector<StoredRun> runs;
  while (query.step()) {
    StoredRun& run = runs.emplace_back(read_run(query));
    if (filter.labels_only) continue;
    run.records = read_records(*db_, run, filter.harmonic_orders);
    run.harmonics = read_harmonics(*db_, "harmonic", run.id);
    run.gap_harmonics = read_harmonics(*db_, "gap_harmonic", run.id);
    run.signatures = read_signatures(*db_, run.id, false);
    run.radial_signatures = read_signatures(*db_, run.id, true);
    run.lines = read_points(*db_, run.id);
  }
  return runs;
}

Trace Store::trace(std::int64_t run_id) const {
  Statement query(*db_,
                  "SELECT t.coding, t.bytes FROM run r LEFT JOIN trace t ON t.run_id = r.id WHERE r.id = ?1");
  if (!query.bind(run_id).step())
    throw StoreError(StoreFault::kNotFound, path() + ": there is no run " + std::to_string(run_id) +
                                                "; `ballbar list` shows the runs");
  if (query.is_null(0)) return {};
  try {
    return decode(query.small(0), query.blob(1));
  } catch (const std::runtime_error& error) {
    throw StoreError(StoreFault::kCorrupt, path() + ": run " + std::to_string(run_id) + ": " + error.what() +
                                               "; its results stand, only the recording is lost");
  }
}

StoreCounts Store::counts() const {
  return {db_->integer("SELECT count(*) FROM run"),
          db_->integer("SELECT count(*) FROM run WHERE status = 'ok'"),
          db_->integer("SELECT count(*) FROM alarm_state WHERE state = 'pending'"),
          db_->integer("SELECT count(*) FROM alarm_state WHERE state = 'firing'"),
          db_->integer("SELECT count(*) FROM alarm_event")};
}

}  // namespace ballbar
