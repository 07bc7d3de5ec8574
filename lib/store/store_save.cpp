#include <cmath>
#include <stdexcept>
#include <string>

#include "core/units.hpp"
#include "metrology/signatures.hpp"
#include "pipeline/catalogue.hpp"
#include "store/labels.hpp"
#include "store/store.hpp"
#include "store/stored_alarms.hpp"
#include "store/stored_run.hpp"

namespace ballbar {

namespace {

void require_finite(double value, const std::string& name) {
  if (!std::isfinite(value)) throw std::invalid_argument(name + " is not finite and cannot be stored");
}

void check_record(const Run& run, const Record& record) {
  if (record.robot != run.robot || record.started_us != run.started_us)
    throw std::invalid_argument("a record of robot " + record.robot + ", begin " +
                                std::to_string(record.started_us) + ", does not belong to the run");
  for (const auto& [name, estimate] : record.values) {
    require_finite(estimate.value, name);
    if (estimate.sd) require_finite(*estimate.sd, "the standard deviation of " + name);
  }
}

void check_harmonics(const std::vector<Harmonic>& harmonics, const std::string& name) {
  for (const Harmonic& h : harmonics)
    for (const double v : {h.cos, h.sin, h.var_cos, h.var_sin, h.cov_cos_sin})
      require_finite(v, name + " " + std::to_string(h.order));
}

void check_signatures(const std::optional<SignatureFit>& fit) {
  if (!fit) return;
  for (const Signature& s : fit->signatures) {
    for (const double v : {s.value.value_or(0.0), s.sd.value_or(0.0), s.span, s.share, s.without,
                           s.detail.value_or(0.0), fit->frame_angle})
      require_finite(v, "signature " + s.name);
    if (!s.value) throw std::invalid_argument("signature " + s.name + " has no value");
  }
  for (const SignatureGroup& g : fit->not_told_apart)
    for (const double v : {g.span, g.share}) require_finite(v, "a sum of signatures");
}

void check_result(const RunResult& result) {
  if (result.circle) check_harmonics(result.circle->harmonics, "harmonic");
  if (result.circle_gap) check_harmonics(result.circle_gap->harmonics, "the gap's harmonic");
  if (result.circle_test) {
    check_signatures(result.circle_test->signatures);
    check_signatures(result.circle_test->radial_signatures);
  }
  for (const LineResult& line : result.lines) {
    const std::string axis(1, line.axis);
    for (const LinePoint& p : line.points) {
      require_finite(p.position, "a point's position on line axis " + axis);
      require_finite(p.deviation, "a point's deviation on line axis " + axis);
      if (p.reversal) require_finite(*p.reversal, "a point's reversal on line axis " + axis);
      if (p.predicted) require_finite(*p.predicted, "a point's prediction on line axis " + axis);
    }
  }
}

std::int64_t insert_run(Database& db, const Run& run, const RunResult& result) {
  Statement insert(
      db,
      "INSERT INTO run (robot, test, kind, direction, repetition, series, started_us, ended_us, ended_by, "
      "status, message, angle_source, source, samples, lost_messages, receiver_restarts, feed_mm_s, "
      "payload_kg, temperature_c, predicted_from, plane) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, "
      "?11, ?12, "
      "?13, ?14, ?15, ?16, ?17, ?18, ?19, ?20, ?21) RETURNING id");
  insert.bind(run.robot, run.test, to_string(run.kind), run.direction, run.repetition, run.series,
              run.started_us, run.ended_us, to_string(run.end), result.status, result.message,
              result.angle_source, result.source, result.samples, run.lost_messages, run.receiver_restarts,
              to_mm(run.feed), run.payload, run.temperature, result.predicted_from, result.plane);
  insert.step();
  const std::int64_t id = insert.integer(0);
  insert.run();
  return id;
}

/// Harmonics of a circle stand in their own table, with covariance; the same numbers are not stored twice.
void insert_quantities(Database& db, std::int64_t id, const RunResult& result,
                       const std::vector<Record>& records) {
  Statement insert(db, "INSERT INTO quantity (run_id, axis, name, value, sd) VALUES (?1, ?2, ?3, ?4, ?5)");
  for (const Record& record : records)
    for (const auto& [name, estimate] : record.values)
      if ((!result.circle || !is_harmonic_name(name)) && !is_signature_name(name))
        insert.bind(id, record.axis, name, estimate.value, estimate.sd).run();
}

double to_um2(double square_metres) { return to_um(to_um(square_metres)); }

void insert_harmonics(Database& db, const std::string& table, std::int64_t id,
                      const std::vector<Harmonic>& harmonics) {
  Statement insert(db, "INSERT INTO " + table +
                           " (run_id, ord, cos_um, sin_um, var_cos_um2, var_sin_um2, cov_um2) "
                           "VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)");
  for (const Harmonic& h : harmonics)
    insert
        .bind(id, h.order, to_um(h.cos), to_um(h.sin), to_um2(h.var_cos), to_um2(h.var_sin),
              to_um2(h.cov_cos_sin))
        .run();
}

void insert_signatures(Database& db, std::int64_t id, const std::string& frame, const SignatureFit& fit) {
  Statement insert(
      db,
      "INSERT INTO signature (run_id, frame, frame_deg, place, name, value, sd, unit, span_um, "
      "share, without_um, detail_mm) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7, ?8, ?9, ?10, ?11, ?12)");
  int place = 0;
  for (const Signature& s : fit.signatures) {
    const SignatureUnit unit = unit_of(s.name);
    std::optional<double> sd;
    std::optional<double> detail_mm;
    if (s.sd) sd = unit.factor * *s.sd;
    if (s.detail) detail_mm = to_mm(*s.detail);
    insert
        .bind(id, frame, to_deg(fit.frame_angle), ++place, s.name, unit.factor * s.value.value(), sd,
              unit.unit, to_um(s.span), s.share, to_um(s.without), detail_mm)
        .run();
  }
  const std::optional<double> none;
  for (const SignatureGroup& g : fit.not_told_apart) {
    std::string names;
    for (const std::string& name : g.names) names += (names.empty() ? "" : kPlus) + name;
    insert
        .bind(id, frame, to_deg(fit.frame_angle), ++place, names, none, none, "", to_um(g.span), g.share,
              none, none)
        .run();
  }
}

void insert_points(Database& db, std::int64_t id, const std::vector<LineResult>& lines) {
  Statement insert(db,
                   "INSERT INTO line_point (run_id, axis, point, position_mm, deviation_um, reversal_um, "
                   "predicted_um) VALUES (?1, ?2, ?3, ?4, ?5, ?6, ?7)");
  for (const LineResult& line : lines) {
    int point = 0;
    for (const LinePoint& p : line.points) {
      std::optional<double> reversal_um;
      std::optional<double> predicted_um;
      if (p.reversal) reversal_um = to_um(*p.reversal);
      if (p.predicted) predicted_um = to_um(*p.predicted);
      insert
          .bind(id, std::string(1, line.axis), point++, to_mm(p.position), to_um(p.deviation), reversal_um,
                predicted_um)
          .run();
    }
  }
}

void insert_trace(Database& db, std::int64_t id, const Trace& trace) {
  if (trace.bar_time.empty() && trace.joint_time.empty() && trace.readings.empty()) return;
  Statement insert(db, "INSERT INTO trace (run_id, coding, bytes) VALUES (?1, ?2, ?3)");
  insert.bind(id, kTraceCoding, encode(trace)).run();
}

}  // namespace

std::int64_t Store::save(const Run& run, const RunResult& result, const std::vector<Record>& records,
                         const std::vector<AlarmStatus>& states, const std::vector<AlarmEvent>& events,
                         bool replace) {
  require_finite(run.feed, "feed_mm_s");
  require_finite(run.payload, "payload_kg");
  if (run.temperature) require_finite(*run.temperature, "temperature_c");
  for (const Record& record : records) check_record(run, record);
  check_result(result);

  Transaction transaction(*db_);
  if (replace)
    Statement(*db_, "DELETE FROM run WHERE robot = ?1 AND started_us = ?2")
        .bind(run.robot, run.started_us)
        .run();
  if (has(run.robot, run.started_us))
    throw StoreError(StoreFault::kDuplicate, path() + ": the run of robot " + run.robot + " that began at " +
                                                 std::to_string(run.started_us) + " us is stored already");
  const std::int64_t id = insert_run(*db_, run, result);
  insert_quantities(*db_, id, result, records);
  if (result.circle) insert_harmonics(*db_, "harmonic", id, result.circle->harmonics);
  if (result.circle_gap) insert_harmonics(*db_, "gap_harmonic", id, result.circle_gap->harmonics);
  if (result.circle_test) {
    if (const auto& fit = result.circle_test->signatures) insert_signatures(*db_, id, kPlaneFrame, *fit);
    if (const auto& fit = result.circle_test->radial_signatures)
      insert_signatures(*db_, id, kRadialFrame, *fit);
  }
  insert_points(*db_, id, result.lines);
  insert_trace(*db_, id, make_trace(run, result));
  put_states(*db_, states);
  insert_events(*db_, events);
  transaction.commit();
  return id;
}

}  // namespace ballbar
