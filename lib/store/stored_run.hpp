#pragma once
/// Reading results back; used by the store alone.

#include "core/result.hpp"
#include "store/sqlite.hpp"
#include "store/store.hpp"

namespace ballbar {

/// Words of the table `signature`.
inline constexpr const char* kPlaneFrame = "plane";
inline constexpr const char* kRadialFrame = "radial";
inline constexpr const char* kPlus = " + ";  ///< between names whose sum alone is known

/// To SI. Converted to the unit of the border once more, the numbers that save() wrote show the same digits.
double metres_from_um(double um);
double metres_from_mm(double mm);

/// A WHERE on `run` r gives rows of these columns, in the order that read_run() takes.
inline constexpr const char* kRunColumns =
    "r.id, r.robot, r.test, r.kind, r.direction, r.repetition, r.series, r.started_us, r.ended_us, "
    "r.ended_by, r.status, r.message, r.angle_source, r.source, r.samples, r.lost_messages, "
    "r.receiver_restarts, r.feed_mm_s, r.payload_kg, r.temperature_c, r.predicted_from, r.plane";

/// Labels and conditions of the row under `row`, without figures.
StoredRun read_run(const Statement& row);

/// The labels of `run` with the quantities of one axis, and for circles harmonics up to `max_order`.
Record read_record(Database& db, const StoredRun& run, const std::string& axis, int max_order);

/// All records of a run: one for a circle or a run without figures, one per axis for a line.
std::vector<Record> read_records(Database& db, const StoredRun& run, int max_order);

/// @param table  harmonic or gap_harmonic
std::vector<Harmonic> read_harmonics(Database& db, const std::string& table, std::int64_t run_id);
std::optional<SignatureFit> read_signatures(Database& db, std::int64_t run_id, bool radial);
AxisPoints read_points(Database& db, std::int64_t run_id);

}  // namespace ballbar
