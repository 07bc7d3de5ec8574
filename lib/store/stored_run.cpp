#include "store/stored_run.hpp"

#include <algorithm>
#include <cmath>
#include <utility>

#include "core/units.hpp"
#include "metrology/signatures.hpp"
#include "pipeline/catalogue.hpp"
#include "store/labels.hpp"

namespace ballbar {

namespace {

double square_metres_from_um2(double um2) { return metres_from_um(metres_from_um(um2)); }

/// Amplitude with its standard deviation, of first order in the errors; at amplitude 0 there is none.
Estimate amplitude(double cos, double sin, double var_cos, double var_sin, double cov) {
  Estimate e{std::hypot(cos, sin), std::nullopt};
  if (e.value > 0.0)
    e.sd =
        std::sqrt(std::max(0.0, cos * cos * var_cos + sin * sin * var_sin + 2.0 * cos * sin * cov)) / e.value;
  return e;
}

/// @param table  harmonic or gap_harmonic, which are also the names of the quantities
void add_harmonics(Database& db, const std::string& table, std::int64_t run_id, int max_order,
                   std::map<std::string, Estimate>& values) {
  Statement query(db, "SELECT ord, cos_um, sin_um, var_cos_um2, var_sin_um2, cov_um2 FROM " + table +
                          " WHERE run_id = ?1 AND ord <= ?2 ORDER BY ord");
  query.bind(run_id, max_order);
  while (query.step()) {
    const std::string name = table + std::to_string(query.integer(0));
    const double cos = query.real(1), sin = query.real(2), var_cos = query.real(3), var_sin = query.real(4);
    values[name + "_cos_um"] = {cos, std::sqrt(std::max(0.0, var_cos))};
    values[name + "_sin_um"] = {sin, std::sqrt(std::max(0.0, var_sin))};
    values[name + "_um"] = amplitude(cos, sin, var_cos, var_sin, query.real(5));
  }
}

/// "a + b".
std::vector<std::string> names_from(const std::string& joined) {
  std::vector<std::string> names;
  for (std::size_t at = 0; at != std::string::npos;) {
    const std::size_t end = joined.find(kPlus, at);
    names.push_back(joined.substr(at, end == std::string::npos ? end : end - at));
    at = end == std::string::npos ? end : end + std::string(kPlus).size();
  }
  return names;
}

}  // namespace

double metres_from_um(double um) { return um * kMetresPerUm; }
double metres_from_mm(double mm) { return mm * kMetresPerMm; }

Run run_of(const StoredRun& stored, Trace trace) {
  Run run;
  run.robot = stored.robot;
  run.test = stored.test;
  run.kind = stored.kind;
  run.direction = stored.direction;
  run.repetition = stored.repetition;
  run.series = stored.series;
  run.started_us = stored.started_us;
  run.ended_us = stored.ended_us;
  run.end = stored.end;
  run.feed = stored.feed;
  run.payload = stored.payload;
  run.temperature = stored.temperature;
  run.bar_time = std::move(trace.bar_time);
  run.bar_deviation = std::move(trace.bar_deviation);
  run.joints = trace.joints;
  run.joint_time = std::move(trace.joint_time);
  run.joint_position = std::move(trace.joint_position);
  run.joint_torque = std::move(trace.joint_torque);
  run.readings = std::move(trace.readings);
  return run;
}

StoredRun stored_run(const Run& run, const RunResult& result, std::vector<Record> records) {
  StoredRun shown;
  shown.robot = run.robot;
  shown.test = run.test;
  shown.series = run.series;
  shown.kind = run.kind;
  shown.direction = run.direction;
  shown.repetition = run.repetition;
  shown.started_us = run.started_us;
  shown.ended_us = run.ended_us;
  shown.end = run.end;
  shown.status = result.status;
  shown.message = result.message;
  shown.angle_source = result.angle_source;
  shown.source = result.source;
  shown.plane = result.plane;
  shown.predicted_from = result.predicted_from;
  shown.samples = result.samples;
  shown.lost_messages = run.lost_messages;
  shown.receiver_restarts = run.receiver_restarts;
  shown.feed = run.feed;
  shown.payload = run.payload;
  shown.temperature = run.temperature;
  shown.records = std::move(records);
  if (result.circle) shown.harmonics = result.circle->harmonics;
  if (result.circle_gap) shown.gap_harmonics = result.circle_gap->harmonics;
  if (result.circle_test) {
    shown.signatures = result.circle_test->signatures;
    shown.radial_signatures = result.circle_test->radial_signatures;
  }
  for (const LineResult& line : result.lines) shown.lines.emplace_back(line.axis, line.points);
  return shown;
}

StoredRun read_run(const Statement& row) {
  StoredRun run;
  run.id = row.integer(0);
  run.robot = row.text(1);
  run.test = row.text(2);
  run.kind = test_kind_from(row.text(3));
  run.direction = row.small(4);
  run.repetition = row.small(5);
  run.series = row.text(6);
  run.started_us = row.integer(7);
  run.ended_us = row.integer(8);
  run.end = run_end_from(row.text(9));
  run.status = row.text(10);
  run.message = row.text(11);
  run.angle_source = row.text(12);
  run.source = row.text(13);
  run.samples = row.integer(14);
  run.lost_messages = row.integer(15);
  run.receiver_restarts = row.small(16);
  run.feed = metres_from_mm(row.real(17));
  run.payload = row.real(18);
  run.temperature = row.maybe_real(19);
  run.predicted_from = row.text(20);
  run.plane = row.text(21);
  return run;
}

Record read_record(Database& db, const StoredRun& run, const std::string& axis, int max_order) {
  Record record;
  record.robot = run.robot;
  record.test = run.test;
  record.kind = to_string(run.kind);
  record.series = run.series;
  record.axis = axis;
  record.status = run.status;
  record.angle_source = run.angle_source;
  record.source = run.source;
  record.plane = run.plane;
  record.predicted_from = run.predicted_from;
  record.direction = run.direction;
  record.repetition = run.repetition;
  record.started_us = run.started_us;
  Statement query(db, "SELECT name, value, sd FROM quantity WHERE run_id = ?1 AND axis = ?2");
  query.bind(run.id, axis);
  while (query.step()) record.values[query.text(0)] = {query.real(1), query.maybe_real(2)};
  if (run.kind == TestKind::kCircle && max_order > 0)
    for (const char* table : {"harmonic", "gap_harmonic"})
      add_harmonics(db, table, run.id, max_order, record.values);
  if (run.kind == TestKind::kCircle && max_order > 0)
    for (const bool radial : {false, true})
      if (const std::optional<SignatureFit> fit = read_signatures(db, run.id, radial))
        put_signatures(*fit, radial, record.values);
  return record;
}

std::vector<Record> read_records(Database& db, const StoredRun& run, int max_order) {
  std::vector<Record> records;
  Statement axes(
      db,
      "SELECT axis FROM quantity WHERE run_id = ?1 UNION SELECT axis FROM line_point WHERE run_id = ?1 "
      "ORDER BY axis");
  axes.bind(run.id);
  while (axes.step()) records.push_back(read_record(db, run, axes.text(0), max_order));
  if (records.empty()) records.push_back(read_record(db, run, "", max_order));
  return records;
}

std::vector<Harmonic> read_harmonics(Database& db, const std::string& table, std::int64_t run_id) {
  Statement query(db, "SELECT ord, cos_um, sin_um, var_cos_um2, var_sin_um2, cov_um2 FROM " + table +
                          " WHERE run_id = ?1 ORDER BY ord");
  query.bind(run_id);
  std::vector<Harmonic> harmonics;
  while (query.step())
    harmonics.push_back({query.small(0), metres_from_um(query.real(1)), metres_from_um(query.real(2)),
                         square_metres_from_um2(query.real(3)), square_metres_from_um2(query.real(4)),
                         square_metres_from_um2(query.real(5))});
  return harmonics;
}

std::optional<SignatureFit> read_signatures(Database& db, std::int64_t run_id, bool radial) {
  Statement query(db,
                  "SELECT frame_deg, name, value, sd, span_um, share, without_um, detail_mm FROM signature "
                  "WHERE run_id = ?1 AND frame = ?2 ORDER BY place");
  query.bind(run_id, radial ? kRadialFrame : kPlaneFrame);
  std::optional<SignatureFit> fit;
  while (query.step()) {
    if (!fit) fit.emplace();
    fit->frame_angle = query.real(0) * kRadPerDeg;
    const std::string name = query.text(1);
    if (query.is_null(2)) {
      fit->not_told_apart.push_back({names_from(name), metres_from_um(query.real(4)), query.real(5)});
      continue;
    }
    Signature found;
    found.name = name;
    const double factor = unit_of(name).factor;
    found.value = query.real(2) / factor;
    if (const std::optional<double> sd = query.maybe_real(3)) found.sd = *sd / factor;
    found.span = metres_from_um(query.real(4));
    found.share = query.real(5);
    found.without = metres_from_um(query.real(6));
    if (const std::optional<double> mm = query.maybe_real(7)) found.detail = metres_from_mm(*mm);
    fit->signatures.push_back(std::move(found));
  }
  return fit;
}

AxisPoints read_points(Database& db, std::int64_t run_id) {
  Statement query(
      db,
      "SELECT axis, position_mm, deviation_um, reversal_um, predicted_um FROM line_point WHERE run_id = ?1 "
      "ORDER BY axis, point");
  query.bind(run_id);
  AxisPoints lines;
  while (query.step()) {
    const std::string axis = query.text(0);
    const char letter = axis.empty() ? ' ' : axis.front();
    if (lines.empty() || lines.back().first != letter) lines.emplace_back(letter, std::vector<LinePoint>());
    LinePoint point{metres_from_mm(query.real(1)), metres_from_um(query.real(2)), std::nullopt, std::nullopt};
    if (const std::optional<double> um = query.maybe_real(3)) point.reversal = metres_from_um(*um);
    if (const std::optional<double> um = query.maybe_real(4)) point.predicted = metres_from_um(*um);
    lines.back().second.push_back(point);
  }
  return lines;
}

}  // namespace ballbar
