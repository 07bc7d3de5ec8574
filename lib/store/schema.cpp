#include "store/schema.hpp"

#include <algorithm>
#include <array>
#include <string_view>

#include "pipeline/catalogue.hpp"

namespace ballbar {

namespace {

// Every number has its unit in its name. A quantity is a row, never a column.
constexpr const char* kVersion1 = R"(
CREATE TABLE run (
  id                INTEGER PRIMARY KEY,
  robot             TEXT    NOT NULL,
  test              TEXT    NOT NULL,
  kind              TEXT    NOT NULL CHECK (kind IN ('circle', 'line')),
  direction         INTEGER NOT NULL,
  repetition        INTEGER NOT NULL,
  series            TEXT    NOT NULL,
  started_us        INTEGER NOT NULL,
  ended_us          INTEGER NOT NULL,
  ended_by          TEXT    NOT NULL,
  status            TEXT    NOT NULL,
  message           TEXT    NOT NULL,
  angle_source      TEXT    NOT NULL,
  source            TEXT    NOT NULL,
  samples           INTEGER NOT NULL,
  lost_messages     INTEGER NOT NULL,
  receiver_restarts INTEGER NOT NULL,
  feed_mm_s         REAL    NOT NULL,
  payload_kg        REAL    NOT NULL,
  temperature_c     REAL,
  UNIQUE (robot, started_us)
) STRICT;
CREATE INDEX run_history ON run (robot, test, direction, started_us);
CREATE INDEX run_series ON run (series, robot, test, direction, started_us);
CREATE INDEX run_time ON run (started_us);

CREATE TABLE quantity (
  run_id INTEGER NOT NULL REFERENCES run (id) ON DELETE CASCADE,
  axis   TEXT    NOT NULL,
  name   TEXT    NOT NULL,
  value  REAL    NOT NULL,
  sd     REAL,
  PRIMARY KEY (run_id, axis, name)
) STRICT, WITHOUT ROWID;

CREATE TABLE harmonic (
  run_id      INTEGER NOT NULL REFERENCES run (id) ON DELETE CASCADE,
  ord         INTEGER NOT NULL,
  cos_um      REAL    NOT NULL,
  sin_um      REAL    NOT NULL,
  var_cos_um2 REAL    NOT NULL,
  var_sin_um2 REAL    NOT NULL,
  cov_um2     REAL    NOT NULL,
  PRIMARY KEY (run_id, ord)
) STRICT, WITHOUT ROWID;

CREATE TABLE line_point (
  run_id       INTEGER NOT NULL REFERENCES run (id) ON DELETE CASCADE,
  axis         TEXT    NOT NULL,
  point        INTEGER NOT NULL,
  position_mm  REAL    NOT NULL,
  deviation_um REAL    NOT NULL,
  reversal_um  REAL,
  PRIMARY KEY (run_id, axis, point)
) STRICT, WITHOUT ROWID;

CREATE TABLE trace (
  run_id INTEGER PRIMARY KEY REFERENCES run (id) ON DELETE CASCADE,
  coding INTEGER NOT NULL,
  bytes  BLOB    NOT NULL
) STRICT;

CREATE TABLE alarm_state (
  rule       TEXT    NOT NULL,
  robot      TEXT    NOT NULL,
  test       TEXT    NOT NULL,
  direction  INTEGER NOT NULL,
  axis       TEXT    NOT NULL,
  state      TEXT    NOT NULL CHECK (state IN ('inactive', 'pending', 'firing', 'resolved')),
  severity   TEXT    NOT NULL,
  since_us   INTEGER NOT NULL,
  judged_us  INTEGER NOT NULL,
  bad_runs   INTEGER NOT NULL,
  clean_runs INTEGER NOT NULL,
  text       TEXT    NOT NULL,
  PRIMARY KEY (rule, robot, test, direction, axis)
) STRICT, WITHOUT ROWID;

-- What was said stays said: an event outlives its run, and holds the run's identity itself.
CREATE TABLE alarm_event (
  id             INTEGER PRIMARY KEY,
  rule           TEXT    NOT NULL,
  robot          TEXT    NOT NULL,
  test           TEXT    NOT NULL,
  direction      INTEGER NOT NULL,
  axis           TEXT    NOT NULL,
  from_state     TEXT    NOT NULL,
  to_state       TEXT    NOT NULL,
  severity       TEXT    NOT NULL,
  at_us          INTEGER NOT NULL,
  judged_us      INTEGER NOT NULL,
  bad_runs       INTEGER NOT NULL,
  clean_runs     INTEGER NOT NULL,
  run_id         INTEGER REFERENCES run (id) ON DELETE SET NULL,
  run_started_us INTEGER NOT NULL,
  text           TEXT    NOT NULL
) STRICT;
CREATE INDEX alarm_event_run ON alarm_event (run_id);
CREATE INDEX alarm_event_time ON alarm_event (at_us);
)";

// Measured against predicted.
constexpr const char* kVersion2 = R"(
ALTER TABLE run ADD COLUMN predicted_from TEXT NOT NULL DEFAULT '';
ALTER TABLE line_point ADD COLUMN predicted_um REAL;
CREATE TABLE gap_harmonic (
  run_id      INTEGER NOT NULL REFERENCES run (id) ON DELETE CASCADE,
  ord         INTEGER NOT NULL,
  cos_um      REAL    NOT NULL,
  sin_um      REAL    NOT NULL,
  var_cos_um2 REAL    NOT NULL,
  var_sin_um2 REAL    NOT NULL,
  cov_um2     REAL    NOT NULL,
  PRIMARY KEY (run_id, ord)
) STRICT, WITHOUT ROWID;
)";

// Error signatures of both directions, ranked. Where only the sum of some is known, their names are joined.
constexpr const char* kVersion3 = R"(
CREATE TABLE signature (
  run_id     INTEGER NOT NULL REFERENCES run (id) ON DELETE CASCADE,
  frame      TEXT    NOT NULL CHECK (frame IN ('plane', 'radial')),
  frame_deg  REAL    NOT NULL,
  place      INTEGER NOT NULL,
  name       TEXT    NOT NULL,
  value      REAL,
  sd         REAL,
  unit       TEXT    NOT NULL,
  span_um    REAL    NOT NULL,
  share      REAL    NOT NULL,
  without_um REAL,
  detail_mm  REAL,
  PRIMARY KEY (run_id, frame, place)
) STRICT, WITHOUT ROWID;
)";

// The plane of a circle, in words: what ISO 230-4 wants on record.
constexpr const char* kVersion4 = "ALTER TABLE run ADD COLUMN plane TEXT NOT NULL DEFAULT ''";

// Alarms that people answer, that explain themselves, and that are told; the sets of rules that were in use.
// What was told before is not told again: `notified` begins where the history of then ends.
constexpr const char* kAlarms = R"(
ALTER TABLE alarm_state ADD COLUMN id INTEGER NOT NULL DEFAULT 0;
ALTER TABLE alarm_state ADD COLUMN streak_us INTEGER NOT NULL DEFAULT 0;
ALTER TABLE alarm_state ADD COLUMN fires INTEGER NOT NULL DEFAULT 0;
ALTER TABLE alarm_state ADD COLUMN flapping INTEGER NOT NULL DEFAULT 0;
ALTER TABLE alarm_state ADD COLUMN numbers TEXT NOT NULL DEFAULT '[]';
ALTER TABLE alarm_state ADD COLUMN runs TEXT NOT NULL DEFAULT '[]';
ALTER TABLE alarm_state ADD COLUMN acknowledged_by TEXT NOT NULL DEFAULT '';
ALTER TABLE alarm_state ADD COLUMN acknowledged_comment TEXT NOT NULL DEFAULT '';
ALTER TABLE alarm_state ADD COLUMN acknowledged_us INTEGER NOT NULL DEFAULT 0;
ALTER TABLE alarm_state ADD COLUMN shelved_by TEXT NOT NULL DEFAULT '';
ALTER TABLE alarm_state ADD COLUMN shelved_comment TEXT NOT NULL DEFAULT '';
ALTER TABLE alarm_state ADD COLUMN shelved_until_us INTEGER NOT NULL DEFAULT 0;
UPDATE alarm_state SET streak_us = CASE state WHEN 'pending' THEN since_us ELSE judged_us END,
  id = (SELECT count(*) FROM alarm_state b WHERE (b.rule, b.robot, b.test, b.direction, b.axis) <=
        (alarm_state.rule, alarm_state.robot, alarm_state.test, alarm_state.direction, alarm_state.axis));
CREATE UNIQUE INDEX alarm_state_id ON alarm_state (id) WHERE id > 0;
ALTER TABLE alarm_event ADD COLUMN alarm_id INTEGER NOT NULL DEFAULT 0;
ALTER TABLE alarm_event ADD COLUMN change TEXT NOT NULL DEFAULT 'state';
ALTER TABLE alarm_event ADD COLUMN by_whom TEXT NOT NULL DEFAULT '';
ALTER TABLE alarm_event ADD COLUMN comment TEXT NOT NULL DEFAULT '';
ALTER TABLE alarm_event ADD COLUMN since_us INTEGER NOT NULL DEFAULT 0;
ALTER TABLE alarm_event ADD COLUMN shelved_until_us INTEGER NOT NULL DEFAULT 0;
ALTER TABLE alarm_event ADD COLUMN numbers TEXT NOT NULL DEFAULT '[]';
ALTER TABLE alarm_event ADD COLUMN runs TEXT NOT NULL DEFAULT '[]';
UPDATE alarm_event SET since_us = at_us, alarm_id = coalesce((SELECT s.id FROM alarm_state s WHERE
  (s.rule, s.robot, s.test, s.direction, s.axis) =
  (alarm_event.rule, alarm_event.robot, alarm_event.test, alarm_event.direction, alarm_event.axis)), 0);
CREATE INDEX alarm_event_alarm ON alarm_event (alarm_id);

CREATE TABLE rule_generation (
  generation INTEGER PRIMARY KEY,
  taken_us   INTEGER NOT NULL
) STRICT;
CREATE TABLE rule_file (
  generation INTEGER NOT NULL REFERENCES rule_generation (generation) ON DELETE CASCADE,
  place      INTEGER NOT NULL,
  file       TEXT    NOT NULL,
  text       TEXT    NOT NULL,
  PRIMARY KEY (generation, place)
) STRICT, WITHOUT ROWID;

CREATE TABLE notified (
  one   INTEGER PRIMARY KEY CHECK (one = 1),
  event INTEGER NOT NULL
) STRICT;
)";

// Diagnoses of whole series, and the model that a commissioned robot is held against.
constexpr const char* kGapResults = R"(
CREATE TABLE gap_result (
  id             INTEGER PRIMARY KEY,
  robot          TEXT    NOT NULL,
  series         TEXT    NOT NULL,
  started_us     INTEGER NOT NULL,
  ended_us       INTEGER NOT NULL,
  verdict        TEXT    NOT NULL,
  noise_floor_um REAL    NOT NULL,
  rms_before_um  REAL    NOT NULL,
  rms_after_um   REAL    NOT NULL,
  json           TEXT    NOT NULL,
  UNIQUE (robot, series, started_us)
) STRICT;
CREATE INDEX gap_result_time ON gap_result (robot, ended_us);
CREATE TABLE gap_finding (
  gap_id   INTEGER NOT NULL REFERENCES gap_result (id) ON DELETE CASCADE,
  place    INTEGER NOT NULL,
  effect   TEXT    NOT NULL,
  kind     TEXT    NOT NULL,
  joint    INTEGER NOT NULL,
  level    INTEGER NOT NULL,
  share    REAL    NOT NULL,
  evidence REAL    NOT NULL,
  PRIMARY KEY (gap_id, place)
) STRICT, WITHOUT ROWID;
CREATE TABLE model_baseline (
  robot          TEXT    PRIMARY KEY,
  series         TEXT    NOT NULL,
  ended_us       INTEGER NOT NULL,
  noise_floor_um REAL    NOT NULL,
  model          TEXT    NOT NULL
) STRICT, WITHOUT ROWID;
)";

// Rules look back by index; calibrations begin a new baseline.
constexpr const char* kRuleHistory = R"(
CREATE INDEX run_judged ON run (robot, test, direction, source, started_us) WHERE status = 'ok';
CREATE INDEX run_judged_series ON run (robot, test, direction, source, series, started_us) WHERE status = 'ok';
CREATE INDEX run_judged_both ON run (robot, test, source, started_us) WHERE status = 'ok';
CREATE TABLE baseline_mark (
  id    INTEGER PRIMARY KEY,
  robot TEXT    NOT NULL,
  test  TEXT    NOT NULL,
  at_us INTEGER NOT NULL,
  note  TEXT    NOT NULL
) STRICT;
CREATE INDEX baseline_mark_time ON baseline_mark (robot, at_us);
)";

constexpr std::array<const char*, 7> kSteps = {kVersion1,   kVersion2, kVersion3,   kVersion4,
                                               kGapResults, kAlarms,   kRuleHistory};

std::string utc(const std::string& column) {
  return "strftime('%Y-%m-%dT%H:%M:%fZ', " + column + " / 1e6, 'unixepoch')";
}

/// Columns of `run` that every view of results shows.
const std::string kLabels = "r.id AS run, r.robot, r.test, r.direction, r.repetition, r.series,\n  " +
                            utc("r.started_us") + " AS started_utc, r.started_us, r.status";
constexpr std::string_view kConditions =
    "r.angle_source, r.source, r.plane, r.predicted_from, r.samples, r.lost_messages, r.feed_mm_s, "
    "r.payload_kg, "
    "r.temperature_c";

/// One column per quantity of the catalogue, looked up by the primary key where a query asks for it.
std::string figures(std::string_view kind, const std::string& axis) {
  const std::string shown = kLabels + ", " + std::string(kConditions) + ",";
  std::string columns;
  for (const Quantity& q : catalogue()) {
    const std::string name(q.name);
    if ((q.kind != kind && q.kind != "run") || shown.find("r." + name + ",") != std::string::npos) continue;
    columns.append(",\n  (SELECT value FROM quantity WHERE run_id = r.id AND axis = ").append(axis);
    columns.append(" AND name = '").append(name).append("') AS ").append(name);
  }
  return columns;
}

std::string run_list() {
  return "CREATE VIEW run_list AS SELECT r.id AS run, r.robot, r.test, r.kind, r.direction, r.repetition, "
         "r.series,\n  " +
         utc("r.started_us") +
         " AS started_utc, r.started_us, (r.ended_us - r.started_us) / 1e6 AS duration_s, r.ended_by, "
         "r.status,\n"
         "  r.message, r.angle_source, r.source, r.plane, r.predicted_from, r.samples, r.lost_messages, "
         "r.receiver_restarts, "
         "r.feed_mm_s, "
         "r.payload_kg,\n  r.temperature_c\nFROM run r";
}

std::string circle() {
  return "CREATE VIEW circle AS SELECT " + kLabels + ", " + std::string(kConditions) +
         figures("circle", "''") + "\nFROM run r WHERE r.kind = 'circle'";
}

std::string line() {
  return "CREATE VIEW line AS SELECT " + kLabels + ", p.axis, " + std::string(kConditions) +
         figures("line", "p.axis") +
         "\nFROM run r LEFT JOIN line_point p ON p.run_id = r.id AND p.point = 0 WHERE r.kind = 'line'";
}

std::string figure() {
  return "CREATE VIEW figure AS SELECT " + kLabels +
         ", r.kind, q.axis, q.name, q.value, q.sd\nFROM run r JOIN quantity q ON q.run_id = r.id";
}

/// @param table  harmonic or gap_harmonic
std::string harmonics(const std::string& view, const std::string& table) {
  return "CREATE VIEW " + view + " AS SELECT " + kLabels +
         ", h.ord, h.cos_um, h.sin_um,\n  sqrt(h.cos_um * h.cos_um + h.sin_um * h.sin_um) AS amplitude_um, "
         "sqrt(h.var_cos_um2) AS sd_cos_um,\n  sqrt(h.var_sin_um2) AS sd_sin_um\n"
         "FROM run r JOIN " +
         table + " h ON h.run_id = r.id";
}

std::string signature_list() {
  return "CREATE VIEW signature_list AS SELECT " + kLabels +
         ", s.frame, s.frame_deg, s.place, s.name, s.value, s.sd, s.unit,\n  s.span_um, s.share, "
         "s.without_um, "
         "s.detail_mm\nFROM run r JOIN signature s ON s.run_id = r.id";
}

std::string alarm_now() {
  return "CREATE VIEW alarm_now AS SELECT id AS alarm, rule, robot, test, direction, axis, state, "
         "severity,\n  " +
         utc("since_us") +
         " AS since_utc, since_us, bad_runs, flapping, acknowledged_by, shelved_by, shelved_until_us, text\n"
         "FROM alarm_state WHERE state IN ('pending', 'firing')";
}

std::string alarm_history() {
  return "CREATE VIEW alarm_history AS SELECT id AS event, " + utc("at_us") +
         " AS at_utc, at_us, rule, robot, test, direction, axis,\n"
         "  from_state, to_state, severity, run_id AS run, run_started_us, text,\n"
         "  change, by_whom, comment, alarm_id AS alarm\nFROM alarm_event";
}

std::string gap_list() {
  return "CREATE VIEW gap_list AS SELECT g.robot, g.series, " + utc("g.ended_us") +
         " AS ended_utc, g.ended_us, g.verdict, g.noise_floor_um,\n"
         "  g.rms_before_um, g.rms_after_um, f.place, f.effect, f.kind, f.joint, f.share, f.evidence\n"
         "FROM gap_result g LEFT JOIN gap_finding f ON f.gap_id = g.id";
}

}  // namespace

std::span<const char* const> schema_steps() { return kSteps; }

std::vector<View> schema_views() {
  return {{"run_list", run_list()},
          {"circle", circle()},
          {"line", line()},
          {"figure", figure()},
          {"harmonic_list", harmonics("harmonic_list", "harmonic")},
          {"gap_harmonic_list", harmonics("gap_harmonic_list", "gap_harmonic")},
          {"signature_list", signature_list()},
          {"alarm_now", alarm_now()},
          {"alarm_history", alarm_history()},
          {"gap_list", gap_list()}};
}

}  // namespace ballbar
