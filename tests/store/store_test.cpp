#include "store/store.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>

#include "core/units.hpp"
#include "store/example_runs.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

class StoreTest : public testing::Test {
 protected:
  std::int64_t put(const test::Saved& s, const std::vector<AlarmStatus>& states = {},
                   const std::vector<AlarmEvent>& events = {}) {
    return store.save(s.run, s.result, s.records, states, events);
  }
  test::TempDir dir;
  std::string path = dir.path() + "/b.db";
  Store store{path};
};

void expect_labels(const StoredRun& stored, const test::Saved& s) {
  EXPECT_EQ(stored.robot, s.run.robot);
  EXPECT_EQ(stored.test, s.run.test);
  EXPECT_EQ(stored.series, s.run.series);
  EXPECT_EQ(stored.kind, s.run.kind);
  EXPECT_EQ(stored.direction, s.run.direction);
  EXPECT_EQ(stored.repetition, s.run.repetition);
  EXPECT_EQ(stored.started_us, s.run.started_us);
  EXPECT_EQ(stored.ended_us, s.run.ended_us);
  EXPECT_EQ(stored.end, s.run.end);
  EXPECT_EQ(stored.status, s.result.status);
  EXPECT_EQ(stored.message, s.result.message);
  EXPECT_EQ(stored.angle_source, s.result.angle_source);
  EXPECT_EQ(stored.source, s.result.source);
  EXPECT_EQ(stored.predicted_from, s.result.predicted_from);
  EXPECT_EQ(stored.samples, s.result.samples);
  EXPECT_EQ(stored.lost_messages, s.run.lost_messages);
  EXPECT_EQ(stored.receiver_restarts, s.run.receiver_restarts);
  EXPECT_EQ(to_mm(stored.feed), to_mm(s.run.feed));
  EXPECT_EQ(stored.payload, s.run.payload);
  EXPECT_EQ(stored.temperature, s.run.temperature);
}

void expect_harmonics(const std::vector<Harmonic>& stored, const std::vector<Harmonic>& expected) {
  ASSERT_EQ(stored.size(), expected.size());
  for (std::size_t i = 0; i < expected.size(); ++i) {
    const Harmonic& h = stored[i];
    EXPECT_EQ(h.order, expected[i].order);
    EXPECT_EQ(to_um(h.cos), to_um(expected[i].cos));  // the shown digits, to the last bit
    EXPECT_EQ(to_um(h.sin), to_um(expected[i].sin));
    EXPECT_DOUBLE_EQ(h.var_cos, expected[i].var_cos);
    EXPECT_DOUBLE_EQ(h.var_sin, expected[i].var_sin);
    EXPECT_DOUBLE_EQ(h.cov_cos_sin, expected[i].cov_cos_sin);
  }
}

void expect_signatures(const std::optional<SignatureFit>& stored, const std::optional<SignatureFit>& saved) {
  ASSERT_TRUE(stored && saved);
  EXPECT_DOUBLE_EQ(stored->frame_angle, saved->frame_angle);
  ASSERT_EQ(stored->signatures.size(), saved->signatures.size());
  for (std::size_t i = 0; i < saved->signatures.size(); ++i) {
    const Signature& s = stored->signatures[i];
    const Signature& expected = saved->signatures[i];
    EXPECT_EQ(s.name, expected.name);
    EXPECT_DOUBLE_EQ(*s.value, *expected.value);
    EXPECT_DOUBLE_EQ(*s.sd, *expected.sd);
    EXPECT_DOUBLE_EQ(s.span, expected.span);
    EXPECT_EQ(s.share, expected.share);
    EXPECT_DOUBLE_EQ(s.without, expected.without);
    EXPECT_EQ(s.detail.has_value(), expected.detail.has_value());
    EXPECT_DOUBLE_EQ(s.detail.value_or(0.0), expected.detail.value_or(0.0));
  }
  ASSERT_EQ(stored->not_told_apart.size(), saved->not_told_apart.size());
  for (std::size_t i = 0; i < saved->not_told_apart.size(); ++i) {
    EXPECT_EQ(stored->not_told_apart[i].names, saved->not_told_apart[i].names);
    EXPECT_DOUBLE_EQ(stored->not_told_apart[i].span, saved->not_told_apart[i].span);
    EXPECT_EQ(stored->not_told_apart[i].share, saved->not_told_apart[i].share);
  }
}

TEST_F(StoreTest, GivesACircleBackAsItWasSaved) {
  const test::Saved s = test::circle();
  const std::int64_t id = put(s);
  const std::vector<StoredRun> runs = store.runs();
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0].id, id);
  expect_labels(runs[0], s);
  EXPECT_EQ(runs[0].records, s.records);
  EXPECT_TRUE(runs[0].lines.empty());
  expect_harmonics(runs[0].harmonics, s.result.circle->harmonics);
  expect_harmonics(runs[0].gap_harmonics, s.result.circle_gap->harmonics);
  expect_signatures(runs[0].signatures, s.result.circle_test->signatures);
  expect_signatures(runs[0].radial_signatures, s.result.circle_test->radial_signatures);
}

TEST_F(StoreTest, GivesALineBackAsItWasSaved) {
  const test::Saved s = test::line();
  put(s);
  const std::vector<StoredRun> runs = store.runs();
  ASSERT_EQ(runs.size(), 1u);
  expect_labels(runs[0], s);
  EXPECT_EQ(runs[0].records, s.records);
  ASSERT_EQ(runs[0].lines.size(), 2u);
  for (std::size_t a = 0; a < 2; ++a) {
    const std::vector<LinePoint>& expected = s.result.lines[a].points;
    const std::vector<LinePoint>& points = runs[0].lines[a].second;
    EXPECT_EQ(runs[0].lines[a].first, s.result.lines[a].axis);
    ASSERT_EQ(points.size(), expected.size());
    for (std::size_t i = 0; i < points.size(); ++i) {
      EXPECT_EQ(to_mm(points[i].position), to_mm(expected[i].position));
      EXPECT_EQ(to_um(points[i].deviation), to_um(expected[i].deviation));
      ASSERT_EQ(points[i].reversal.has_value(), expected[i].reversal.has_value());
      EXPECT_EQ(to_um(points[i].reversal.value_or(0.0)), to_um(expected[i].reversal.value_or(0.0)));
      ASSERT_EQ(points[i].predicted.has_value(), expected[i].predicted.has_value());
      EXPECT_EQ(to_um(points[i].predicted.value_or(0.0)), to_um(expected[i].predicted.value_or(0.0)));
    }
  }
}

TEST_F(StoreTest, ShowsARunThatIsNotStoredAsOneThatIs) {
  for (const test::Saved& s : {test::circle(), test::line(test::kDay + 1)}) {
    SCOPED_TRACE(s.run.test);
    RunFilter filter;
    filter.ids = {put(s)};
    const StoredRun read = store.runs(filter).at(0);
    const StoredRun made = stored_run(s.run, s.result, s.records);
    EXPECT_EQ(made.id, 0);
    expect_labels(made, s);
    EXPECT_EQ(made.records, read.records);
    expect_harmonics(read.harmonics, made.harmonics);
    expect_harmonics(read.gap_harmonics, made.gap_harmonics);
    EXPECT_EQ(made.signatures.has_value(), read.signatures.has_value());
    if (made.signatures) {
      expect_signatures(read.signatures, made.signatures);
      expect_signatures(read.radial_signatures, made.radial_signatures);
    }
    ASSERT_EQ(made.lines.size(), read.lines.size());
    for (std::size_t a = 0; a < read.lines.size(); ++a) {
      EXPECT_EQ(made.lines[a].first, read.lines[a].first);
      EXPECT_EQ(made.lines[a].second.size(), read.lines[a].second.size());
    }
  }
}

TEST_F(StoreTest, ShowsTheSameDigitsAgainWhatsoeverTheyAre) {
  test::Saved s = test::line();
  std::mt19937_64 rng(3);
  std::uniform_real_distribution<double> um(-200e-6, 200e-6);
  for (int i = 0; i < 5000; ++i) s.result.lines[0].points.push_back({1.0 + i * 0.000188, um(rng), um(rng)});
  put(s);
  const StoredRun stored = store.runs().at(0);
  const std::vector<LinePoint>& points = stored.lines.at(0).second;
  ASSERT_EQ(points.size(), s.result.lines[0].points.size());
  for (std::size_t i = 0; i < points.size(); ++i) {
    const LinePoint& expected = s.result.lines[0].points[i];
    ASSERT_EQ(to_mm(points[i].position), to_mm(expected.position)) << i;
    ASSERT_EQ(to_um(points[i].deviation), to_um(expected.deviation)) << i;
  }
}

TEST_F(StoreTest, GivesTheRecordingBackToItsStatedSteps) {
  const test::Saved s = test::circle();
  const Trace t = store.trace(put(s));
  ASSERT_EQ(t.bar_time.size(), s.run.bar_time.size());
  ASSERT_EQ(t.joint_position.size(), s.run.joint_position.size());
  EXPECT_EQ(t.arc_begin, 10u);
  EXPECT_EQ(t.arc_end, 290u);
  for (std::size_t i = 0; i < t.bar_time.size(); ++i) {
    EXPECT_NEAR(t.bar_deviation[i], s.run.bar_deviation[i], 0.5001e-9);
    EXPECT_EQ(std::isnan(t.angle[i]), i < 5);
  }
}

TEST_F(StoreTest, KeepsARunThatGaveNoFigures) {
  test::Saved s = test::circle();
  s.run = ballbar::Run{};
  s.run.robot = "lrmate-1";
  s.run.test = "A";
  s.run.started_us = test::kDay;
  s.run.end = RunEnd::kAborted;
  s.result = RunResult{};
  s.result.status = "aborted";
  s.result.message = "the run was aborted by its mark";
  s.records = {test::labels_of(s)};
  const std::int64_t id = put(s);
  const std::vector<StoredRun> runs = store.runs();
  ASSERT_EQ(runs.size(), 1u);
  expect_labels(runs[0], s);
  EXPECT_EQ(runs[0].records, s.records);
  EXPECT_TRUE(store.trace(id).bar_time.empty());
}

TEST_F(StoreTest, StoresANumberThatItHasNeverHeardOf) {
  test::Saved s = test::circle();
  s.records[0].values["squareness_um_per_m"] = {12.5, 0.5};
  put(s);
  EXPECT_EQ(store.runs()[0].records[0].values.at("squareness_um_per_m"), (Estimate{12.5, 0.5}));
}

TEST_F(StoreTest, KnowsARunByRobotAndBegin) {
  put(test::circle());
  EXPECT_TRUE(store.has("lrmate-1", test::kDay));
  EXPECT_FALSE(store.has("lrmate-1", test::kDay + 1));
  EXPECT_FALSE(store.has("lrmate-2", test::kDay));
}

TEST_F(StoreTest, ReplacesARunThatWasCutShortWhenAskedTo) {
  test::Saved cut = test::circle(test::kDay, 1);
  cut.run.end = RunEnd::kInterrupted;
  put(cut);
  EXPECT_EQ(store.end_of("lrmate-1", test::kDay), RunEnd::kInterrupted);
  EXPECT_EQ(store.end_of("lrmate-1", test::kDay + 1), std::nullopt);
  test::Saved whole = test::circle(test::kDay, 2);
  whole.run.repetition = whole.records[0].repetition = 2;
  store.save(whole.run, whole.result, whole.records, {}, {}, true);
  ASSERT_EQ(store.runs().size(), 1u);
  EXPECT_EQ(store.runs()[0].end, RunEnd::kMark);
  EXPECT_EQ(store.runs()[0].repetition, 2);
  EXPECT_EQ(store.end_of("lrmate-1", test::kDay), RunEnd::kMark);
}

TEST_F(StoreTest, RefusesTheSameRunTwiceAndKeepsTheFirst) {
  put(test::circle(test::kDay, 1));
  test::Saved again = test::circle(test::kDay, 2);
  again.run.test = "B";  // a label, not a key
  again.records[0].test = "B";
  try {
    put(again);
    FAIL() << "the second one was taken";
  } catch (const StoreError& e) {
    EXPECT_EQ(e.kind(), StoreFault::kDuplicate);
    EXPECT_NE(std::string(e.what()).find(path), std::string::npos);
  }
  ASSERT_EQ(store.runs().size(), 1u);
  EXPECT_EQ(store.runs()[0].test, "A");
  again.run.robot = again.records[0].robot = "lrmate-2";  // another robot may begin at the same time
  EXPECT_NO_THROW(put(again));
}

TEST_F(StoreTest, RefusesNumbersThatAreNotFiniteByNameAndStoresNothing) {
  const auto refused = [this](const test::Saved& s) -> std::string {
    try {
      put(s);
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "";
  };
  const auto expect_named = [&](const test::Saved& s, const std::string& name) {
    EXPECT_NE(refused(s).find(name), std::string::npos) << name << ": " << refused(s);
  };
  test::Saved s = test::circle();
  s.records[0].values["ovality_um"].value = std::nan("");
  expect_named(s, "ovality_um");
  s = test::circle();
  s.records[0].values["ovality_um"].sd = HUGE_VAL;
  expect_named(s, "ovality_um");
  s = test::circle();
  s.result.circle->harmonics[6].var_sin = -HUGE_VAL;
  expect_named(s, "harmonic 7");
  s = test::circle();
  s.run.payload = std::nan("");
  expect_named(s, "payload_kg");
  s = test::circle();
  s.run.temperature = std::nan("");
  expect_named(s, "temperature_c");
  s = test::line();
  s.result.lines[1].points[3].deviation = std::nan("");
  expect_named(s, "axis Z");
  EXPECT_EQ(store.counts().runs, 0);
}

TEST_F(StoreTest, RefusesARecordOfAnotherRun) {
  test::Saved s = test::circle();
  s.records[0].started_us += 1;
  EXPECT_THROW(put(s), std::invalid_argument);
}

TEST_F(StoreTest, RemembersAlarmsAndReplacesStatesByKey) {
  const test::Saved first = test::circle(test::kDay), second = test::circle(test::kDay + 1'000'000, 2);
  const AlarmStatus pending = test::alarm(first, AlarmState::kPending, 1);
  AlarmStatus other = pending;
  other.key.axis = "X";
  const AlarmStatus firing = test::alarm(second, AlarmState::kFiring, 2);
  put(first, {pending, other}, {{pending, AlarmState::kInactive, first.run.started_us}});
  const std::int64_t id = put(second, {firing}, {{firing, AlarmState::kPending, second.run.started_us}});

  EXPECT_EQ(store.alarm_states(), (std::vector<AlarmStatus>{firing, other}));
  EXPECT_EQ(Store(path).alarm_states(), (std::vector<AlarmStatus>{firing, other}));  // and after a restart

  const std::vector<StoredEvent> events = store.events();
  ASSERT_EQ(events.size(), 2u);
  EXPECT_EQ(events[0].event.status, pending);
  EXPECT_EQ(events[0].event.from, AlarmState::kInactive);
  EXPECT_EQ(events[1].event.status, firing);
  EXPECT_EQ(events[1].event.from, AlarmState::kPending);
  EXPECT_EQ(events[1].event.run_started_us, second.run.started_us);
  EXPECT_EQ(events[1].run_id, id);

  const StoreCounts counts = store.counts();
  EXPECT_EQ(counts.runs, 2);
  EXPECT_EQ(counts.runs_ok, 2);
  EXPECT_EQ(counts.alarms_firing, 1);
  EXPECT_EQ(counts.alarms_pending, 1);
  EXPECT_EQ(counts.alarm_events, 2);
}

TEST_F(StoreTest, StoresAlarmsThatNoRunMoved) {
  const test::Saved s = test::circle();
  const AlarmStatus firing = test::alarm(s, AlarmState::kFiring);
  put(s, {firing}, {});
  AlarmStatus retired = firing;
  retired.state = AlarmState::kInactive;
  store.save_alarms({retired}, {{retired, AlarmState::kFiring, 0}});
  EXPECT_EQ(store.alarm_states(), std::vector<AlarmStatus>{retired});
  ASSERT_EQ(store.events().size(), 1u);
  EXPECT_EQ(store.events()[0].event.status, retired);
  EXPECT_EQ(store.events()[0].event.run_started_us, 0);
  EXPECT_FALSE(store.events()[0].run_id);
}

TEST_F(StoreTest, FiltersEvents) {
  for (int i = 0; i < 4; ++i) {
    const test::Saved s = test::circle(test::kDay + i * 1'000'000LL);
    AlarmStatus status = test::alarm(s, AlarmState::kFiring);
    if (i == 3) status.key.rule = "ovality_drift";
    put(s, {}, {{status, AlarmState::kPending, s.run.started_us}});
  }
  const auto count = [this](const EventFilter& f) { return store.events(f).size(); };
  EventFilter f;
  f.rule = "ovality_drift";
  EXPECT_EQ(count(f), 1u);
  f = {};
  f.since_us = test::kDay + 12'000'000 + 2'000'000;
  EXPECT_EQ(count(f), 2u);
  f = {};
  f.robot = "lrmate-2";
  EXPECT_EQ(count(f), 0u);
  f = {};
  f.run_id = 2;
  EXPECT_EQ(count(f), 1u);
  f = {};
  f.limit = 1;
  f.newest_first = true;
  ASSERT_EQ(count(f), 1u);
  EXPECT_EQ(store.events(f)[0].event.status.key.rule, "ovality_drift");
}

TEST_F(StoreTest, DeletesAllOfARunButTheHistoryOfAlarms) {
  const test::Saved s = test::circle();
  put(s, {}, {{test::alarm(s, AlarmState::kFiring), AlarmState::kPending, s.run.started_us}});
  put(test::line(test::kDay + 1));
  store.database().execute("DELETE FROM run");
  for (const char* table : {"quantity", "harmonic", "line_point", "trace"})
    EXPECT_EQ(store.database().integer(std::string("SELECT count(*) FROM ") + table), 0) << table;
  ASSERT_EQ(store.events().size(), 1u);
  EXPECT_FALSE(store.events()[0].run_id);
  EXPECT_EQ(store.events()[0].event.run_started_us, s.run.started_us);
}

TEST_F(StoreTest, TellsThatARunOrItsRecordingIsNotThere) {
  const auto kind = [this](std::int64_t id) {
    try {
      store.trace(id);
    } catch (const StoreError& e) {
      return e.kind();
    }
    return StoreFault::kOther;
  };
  EXPECT_EQ(kind(7), StoreFault::kNotFound);
  const std::int64_t id = put(test::circle());
  store.database().execute("UPDATE trace SET bytes = substr(bytes, 1, 100)");
  EXPECT_EQ(kind(id), StoreFault::kCorrupt);
  store.database().execute("UPDATE trace SET coding = 99");
  EXPECT_EQ(kind(id), StoreFault::kCorrupt);
}

TEST_F(StoreTest, LetsTheGroupReadWhateverTheUmask) {
  const ::mode_t before = ::umask(0077);
  const Store other(dir.path() + "/other.db");
  ::umask(before);
  for (const char* suffix : {"", "-wal", "-shm"}) {
    struct ::stat s {};
    ASSERT_EQ(::stat((other.path() + suffix).c_str(), &s), 0) << suffix;
    EXPECT_EQ(s.st_mode & 0777, 0640u) << suffix;
  }
}

TEST_F(StoreTest, EmptiesTheWalOnRequestButNotUnderAReader) {
  put(test::circle());
  ASSERT_GT(std::filesystem::file_size(path + "-wal"), 0u);
  EXPECT_TRUE(store.checkpoint());
  EXPECT_EQ(std::filesystem::file_size(path + "-wal"), 0u);

  put(test::circle(test::kDay + 1));
  Store reader = Store::open_read_only(path);
  StoreOptions impatient;
  impatient.busy_timeout_ms = 10;
  Store writer(path, impatient);
  {
    const Snapshot snapshot(reader.database());
    EXPECT_EQ(reader.counts().runs, 2);
    EXPECT_FALSE(writer.checkpoint());
  }
  EXPECT_TRUE(writer.checkpoint());
}

}  // namespace
}  // namespace ballbar
