#pragma once
/// Runs, results, recordings and alarms on disk. The tables are explained in docs/database.md.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/alarm.hpp"
#include "core/baseline_mark.hpp"
#include "core/gap_record.hpp"
#include "core/past.hpp"
#include "core/result.hpp"
#include "core/run.hpp"
#include "store/sqlite.hpp"
#include "store/trace.hpp"

namespace ballbar {

struct StoreOptions {
  int busy_timeout_ms = 5000;  ///< how long to wait for another writer
};

using AxisPoints =
    std::vector<std::pair<char, std::vector<LinePoint>>>;  ///< by axis; points by rising position

/// A run as it was stored, without its recording. Members as in Run and RunResult.
struct StoredRun {
  std::int64_t id = 0;
  std::string robot, test, series;
  TestKind kind = TestKind::kCircle;
  int direction = 0;
  int repetition = 0;
  std::int64_t started_us = 0, ended_us = 0;
  RunEnd end = RunEnd::kMark;
  std::string status, message, angle_source, source, plane, predicted_from;
  std::int64_t samples = 0, lost_messages = 0;
  int receiver_restarts = 0;
  double feed = 0.0;                  ///< [m/s]
  double payload = 0.0;               ///< [kg]
  std::optional<double> temperature;  ///< [degC]

  std::vector<Record> records;                    ///< as saved: one for a circle, one per axis for a line
  std::vector<Harmonic> harmonics;                ///< by order
  std::vector<Harmonic> gap_harmonics;            ///< by order, of measured minus predicted
  std::optional<SignatureFit> signatures;         ///< of both directions, without residual and not_defined
  std::optional<SignatureFit> radial_signatures;  ///< likewise
  AxisPoints lines;
};

/// A run as it would be read back if it were stored, without an id.
/// @param records  as for save()
StoredRun stored_run(const Run& run, const RunResult& result, std::vector<Record> records);

/// The run as it was assembled, but for what was lost on the way. `trace` is that of `stored`.
Run run_of(const StoredRun& stored, Trace trace);

/// The run the other way of a circle.
struct CirclePartner {
  std::int64_t id = 0;
  int direction = 0;
  double feed = 0.0;                  ///< [m/s]
  std::optional<double> temperature;  ///< [degC]
  Trace trace;
};

/// Which runs; what is absent does not matter.
struct RunFilter {
  std::vector<std::int64_t> ids;  ///< empty: all
  std::optional<std::string> robot, test, series, status;
  std::optional<TestKind> kind;
  std::optional<int> direction;
  std::optional<std::int64_t> since_us, until_us;  ///< started_us in [since_us, until_us)
  std::int64_t limit = 0;                          ///< 0: no limit
  bool newest_first = false;                       ///< also which ones the limit keeps
  int harmonic_orders =
      0;  ///< records of circles also hold harmonic<k>_cos_um, _sin_um, _um of so many orders, and gap_...
  bool labels_only = false;  ///< neither records nor harmonics, signatures and points
};

inline constexpr int kAllHarmonicOrders = 30;

struct EventFilter {
  std::optional<std::string> robot, test, rule;
  std::optional<std::int64_t> run_id;
  std::optional<std::int64_t> since_us;  ///< of the change
  std::int64_t limit = 0;                ///< 0: no limit
  bool newest_first = false;
  std::optional<std::int64_t> alarm_id;
  std::optional<std::int64_t> after_id;  ///< StoredEvent::id, which rises with each event
  bool states_only = true;               ///< false: also what people did
};

/// A set of rules as it was in use.
struct RuleGeneration {
  int generation = 0;  ///< from 1
  std::int64_t taken_us = 0;
  std::vector<std::pair<std::string, std::string>> files;  ///< name and text, in their order
};

inline constexpr int kKeptGenerations = 10;

struct StoredEvent {
  std::int64_t id = 0;
  std::optional<std::int64_t> run_id;  ///< absent where that run was deleted
  AlarmEvent event;
};

/// The diagnosis of a series.
struct StoredGap {
  GapRecord record;
  std::int64_t started_us = 0;  ///< begin of its first run: with robot and series what it is
  std::string json;             ///< the whole diagnosis, design.md 7
};

struct GapFilter {
  std::optional<std::string> robot, series;
  std::optional<std::int64_t> before_us;  ///< ended_us below it
  std::int64_t limit = 0;                 ///< the latest ones; 0: no limit
};

/// A commissioned robot's whole model: later diagnoses look for what has changed since.
struct ModelBaseline {
  std::string robot, series;
  std::int64_t ended_us = 0;  ///< of the series' last run
  double noise_floor = 0.0;   ///< [m]
  std::string model;          ///< JSON: {"effects": [...]}
};

struct LastRun {
  std::string robot, test;
  std::int64_t ended_us = 0;
};

struct DayCounts {
  std::int64_t runs = 0, runs_failed = 0, lost_messages = 0, receiver_restarts = 0;
};

struct StoreCounts {
  std::int64_t runs = 0;
  std::int64_t runs_ok = 0;
  std::int64_t alarms_pending = 0;
  std::int64_t alarms_firing = 0;
  std::int64_t alarm_events = 0;
};

/// One database file. All functions throw StoreError where the world fails. Not for two threads at once.
class Store {
 public:
  /// Opens for writing: makes the file (mode 0640) where it is missing, brings it up to date, checks it. WAL,
  /// synchronous=FULL: what save() returned for survives a power cut. A file of another application or of a
  /// newer version is left as it is.
  explicit Store(const std::string& path, const StoreOptions& options = {});

  /// Opens for reading only, with no more than read permission: a writer may run, have stopped or have
  /// crashed.
  static Store open_read_only(const std::string& path, const StoreOptions& options = {});

  const std::string& path() const { return db_->path(); }

  /// True if the run of this robot and begin is stored.
  bool has(const std::string& robot, std::int64_t started_us) const;

  /// How the stored run of this robot and begin came to its end; nothing where there is none.
  std::optional<RunEnd> end_of(const std::string& robot, std::int64_t started_us) const;

  /// Stores all of a run in one transaction: when it throws, nothing is stored.
  ///
  /// @param records  of this run, as records(run, result) makes them; harmonics of a circle are taken from
  ///                 result.circle, with their covariance
  /// @param states   alarm states that replace those of the same key
  /// @param events   in the order in which they happened; appended
  /// @param replace  the stored run of this identity, if any, gives way to this one, in the same transaction
  /// @return id of the run
  /// @throws StoreError kDuplicate where has() is true and `replace` is not
  /// @throws std::invalid_argument naming the number that is not finite, or the label that does not fit
  std::int64_t save(const Run& run, const RunResult& result, const std::vector<Record>& records,
                    const std::vector<AlarmStatus>& states, const std::vector<AlarmEvent>& events,
                    bool replace = false);

  /// Stores alarms that no run moved, e.g. because a person acknowledged one, in one transaction.
  void save_alarms(const std::vector<AlarmStatus>& states, const std::vector<AlarmEvent>& events);

  /// Stores a diagnosis; one of the same robot, series and begin gives way to it.
  /// @throws std::invalid_argument for a figure that is not finite
  void save_gap(const StoredGap& gap);

  /// By end.
  std::vector<StoredGap> gaps(const GapFilter& filter = {}) const;

  /// Replaces that of the same robot.
  void set_model_baseline(const ModelBaseline& baseline);
  std::optional<ModelBaseline> model_baseline(const std::string& robot) const;

  /// Earlier results of the same subject as `like`, read as rules ask for them: same robot, test, direction,
  /// axis and source, begun before it, status "ok"; of kind "test" the runs that completed both directions.
  /// Each question reads a bounded number of rows by index, however long the history is. Not longer than the
  /// store.
  std::unique_ptr<Past> past(const Record& like) const;

  /// Once: the same robot, test and time again changes nothing.
  void set_baseline(const BaselineMark& mark);
  std::vector<BaselineMark> baselines() const;  ///< by time

  /// When each test of each robot ended "ok" for the last time, until then.
  std::vector<LastRun> last_runs(std::int64_t until_us = INT64_MAX) const;

  /// Of all runs of a robot that began between these, both included.
  DayCounts counts_between(const std::string& robot, std::int64_t since_us, std::int64_t until_us) const;

  /// All alarms that were ever judged, by key.
  std::vector<AlarmStatus> alarm_states() const;

  /// The points of the latest "ok" run the other way of the same robot, test and series that began before
  /// `before_us`, the same repetition preferred. Empty where there is none, or where `direction` is 0.
  AxisPoints line_partner(const std::string& robot, const std::string& test, const std::string& series,
                          int direction, int repetition, std::int64_t before_us) const;

  /// The latest "ok" circle the other way of the same robot, test, series, repetition, source and feed (to a
  /// hundredth) that began before `run` and was not joined with an earlier one. Where the series has no name,
  /// repetitions of other days have the same number: then only within the hour before. Nothing where there is
  /// none, its recording cannot be read, or the direction is 0.
  /// @param source  as in RunResult
  std::optional<CirclePartner> circle_partner(const Run& run, const std::string& source) const;

  /// `source` of the "ok" circle before `run` in the series of the same robot, the same test preferred. No
  /// more than a day before; where the series has no name, an hour. Empty where there is none.
  std::string source_before(const Run& run) const;

  /// By begin, then robot.
  std::vector<StoredRun> runs(const RunFilter& filter = {}) const;

  /// The recording; an empty one where the run has none.
  /// @throws StoreError kNotFound for an id that no run has, kCorrupt for damaged bytes
  Trace trace(std::int64_t run_id) const;

  std::vector<StoredEvent> events(const EventFilter& filter = {}) const;

  /// Id of the last event; 0 where there is none.
  std::int64_t last_event() const;

  /// The last event that people were told of; nothing where none ever was.
  std::optional<std::int64_t> notified() const;
  void save_notified(std::int64_t event_id);
  void forget_notified();

  /// The set of rules that was taken last; nothing where none ever was.
  std::optional<RuleGeneration> last_rules() const;
  /// Stores a set under the next number and drops all but the last kKeptGenerations. @return the number
  int save_rules(const std::vector<std::pair<std::string, std::string>>& files, std::int64_t taken_us);

  StoreCounts counts() const;

  /// Copies the WAL into the database and empties it. False where a reader still needs it: try again later.
  bool checkpoint();

  /// For what has no function here: check, backup, tests.
  Database& database() { return *db_; }

 private:
  explicit Store(std::unique_ptr<Database> db) : db_(std::move(db)) {}

  std::unique_ptr<Database> db_;
};

}  // namespace ballbar
