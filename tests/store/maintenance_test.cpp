/// Keeping house: retention, backup, restore, check, recovery.

#include "store/maintenance.hpp"

#include <gtest/gtest.h>
#include <sys/stat.h>
#include <unistd.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>
#include <memory>

#include "store/example_runs.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kDayUs = 86'400'000'000;

std::string file_bytes(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

class MaintenanceTest : public testing::Test {
 protected:
  std::int64_t count(Store& store, const std::string& table) {
    return store.database().integer("SELECT count(*) FROM " + table);
  }
  /// Circles of one robot, one a day, the newest today and stored last.
  void fill(Store& store, int days, const std::string& robot = "lrmate-1",
            std::int64_t today_us = test::kDay) {
    for (int i = days - 1; i >= 0; --i) {
      test::Saved s = test::circle(today_us - i * kDayUs, static_cast<unsigned>(i + 1));
      s.run.robot = s.records[0].robot = robot;
      const AlarmStatus firing = test::alarm(s, AlarmState::kFiring);
      store.save(s.run, s.result, s.records, {firing}, {{firing, AlarmState::kPending, s.run.started_us}});
    }
  }
  /// Steps until two in a row remove nothing, and what they removed in all.
  Removed retain(Store& store, const RetentionLimits& limits, std::int64_t now_us, int most = 3) {
    Retention retention;
    Removed all;
    for (int idle = 0, steps = 0; idle < 10 && steps < 1000; ++steps) {
      const Removed now = retention.step(store, limits, now_us, most);
      EXPECT_LE(now.traces, 2 * most);
      EXPECT_LE(now.runs, 2 * most);
      idle = now.none() ? idle + 1 : 0;
      all += now;
    }
    return all;
  }
  test::TempDir dir;
  std::string path = dir.path() + "/b.db";
};

TEST_F(MaintenanceTest, RecordingsGoBeforeResults) {
  Store store(path);
  fill(store, 20);
  RetentionLimits limits;
  limits.keep_us = 12 * kDayUs;
  limits.keep_traces_us = 5 * kDayUs;
  const Removed all = retain(store, limits, test::kDay + kDayUs);
  EXPECT_EQ(count(store, "run"), 13);  // today and twelve days before
  EXPECT_EQ(count(store, "trace"), 6);
  EXPECT_EQ(all.runs, 7);
  EXPECT_EQ(count(store, "quantity WHERE run_id NOT IN (SELECT id FROM run)"), 0);
  EXPECT_EQ(count(store, "alarm_event WHERE at_us < " + std::to_string(test::kDay - limits.keep_us)), 0);
  EXPECT_TRUE(retain(store, limits, test::kDay + kDayUs).none());
}

TEST_F(MaintenanceTest, AWrongClockDeletesNothing) {
  Store store(path);
  fill(store, 3, "past", 5 * kDayUs);  // a producer that believes it is 1970
  fill(store, 3, "future", test::kDay + 9000 * kDayUs);
  fill(store, 3, "now");
  RetentionLimits limits;
  limits.keep_us = limits.keep_traces_us = 3 * kDayUs;
  EXPECT_TRUE(retain(store, limits, test::kDay + kDayUs).none());
  EXPECT_TRUE(retain(store, limits, 0).none()) << "the daemon's clock, set back to 1970";
  EXPECT_TRUE(retain(store, limits, test::kDay + 9000 * kDayUs).none()) << "and ahead";
  EXPECT_EQ(count(store, "run"), 9);
}

TEST_F(MaintenanceTest, TheNumberOfAnAlarmEventIsNeverGivenTwice) {
  Store store(path);
  fill(store, 10, "lrmate-1", test::kDay - 100 * kDayUs);  // alarms of long ago,
  const std::int64_t last = store.last_event();
  ASSERT_EQ(last, 10);
  for (int i = 0; i < 3; ++i) {  // and healthy circles since
    const test::Saved s = test::circle(test::kDay - i * kDayUs, 100U + static_cast<unsigned>(i));
    store.save(s.run, s.result, s.records, {}, {});
  }
  RetentionLimits limits;
  limits.keep_us = 5 * kDayUs;
  retain(store, limits, test::kDay + kDayUs);
  EXPECT_EQ(count(store, "run"), 3);
  EXPECT_EQ(count(store, "alarm_event"), 1) << "the newest one only";
  const test::Saved s = test::circle(test::kDay + 1000, 200);
  const AlarmStatus firing = test::alarm(s, AlarmState::kFiring);
  store.save(s.run, s.result, s.records, {firing}, {{firing, AlarmState::kPending, s.run.started_us}});
  EventFilter later;
  later.after_id = last;
  ASSERT_EQ(store.events(later).size(), 1u) << "who had read up to event 10 hears of it";
  EXPECT_EQ(store.events(later)[0].id, 11);
}

TEST_F(MaintenanceTest, NothingIsDeletedWithoutALimit) {
  Store store(path);
  fill(store, 5);
  EXPECT_TRUE(retain(store, {}, test::kDay + 90'000 * kDayUs).none());
}

TEST_F(MaintenanceTest, ASizeIsHeldByTheOldestRecordingsAndThenTheOldestRuns) {
  Store store(path);
  const std::int64_t empty = data_bytes(store);
  fill(store, 40);
  const std::int64_t full = data_bytes(store);
  RetentionLimits limits;
  limits.max_bytes = full - 20'000;
  Removed all = retain(store, limits, test::kDay);
  EXPECT_GT(all.traces, 0);
  EXPECT_EQ(all.runs, 0);
  EXPECT_LE(data_bytes(store), limits.max_bytes);
  limits.max_bytes = empty + (full - empty) / 3;
  all = retain(store, limits, test::kDay);
  EXPECT_EQ(count(store, "trace"), 0);
  EXPECT_GT(all.runs, 0);
  EXPECT_GT(count(store, "run"), 0);
  EXPECT_LE(data_bytes(store), limits.max_bytes);
  const std::int64_t oldest = store.database().integer("SELECT min(started_us) FROM run");
  EXPECT_EQ(oldest, test::kDay - (count(store, "run") - 1) * kDayUs) << "those that stay are the newest";
}

TEST_F(MaintenanceTest, ABackupIsWhatWasThereAndIsRestored) {
  const std::string copy = dir.path() + "/backup.db";
  {
    Store store(path);  // open all the while, as the service has it
    fill(store, 4);
    backup(path, copy);
    fill(store, 1, "later");
    EXPECT_THROW(backup(path, copy), StoreError) << "an older backup stays";
  }
  EXPECT_EQ(Store::open_read_only(copy).counts().runs, 4);
  EXPECT_TRUE(damages(copy).empty());

  const std::string aside = restore(copy, path);
  EXPECT_EQ(aside, path + ".before-restore-1");
  EXPECT_EQ(Store(path).counts().runs, 4);
  EXPECT_EQ(Store::open_read_only(aside).counts().runs, 5);
}

TEST_F(MaintenanceTest, ADatabaseThatIsOpenIsNotReplaced) {
  const std::string copy = dir.path() + "/backup.db";
  Store service(path);
  fill(service, 2);
  backup(path, copy);
  try {
    restore(copy, path);
    ADD_FAILURE() << "the service would go on writing to what was set aside";
  } catch (const StoreError& error) {
    EXPECT_EQ(error.kind(), StoreFault::kLocked);
    EXPECT_NE(std::string(error.what()).find("is in use; stop ballbard"), std::string::npos);
  }
  fill(service, 1, "later");
  EXPECT_EQ(service.counts().runs, 3);
}

TEST_F(MaintenanceTest, ARestoredDatabaseBelongsToWhoHadIt) {
  if (geteuid() != 0) GTEST_SKIP() << "only root gives files away";
  constexpr uid_t kService = 54321;
  const std::string copy = dir.path() + "/backup.db";
  fill(*std::make_unique<Store>(path), 2);
  backup(path, copy);
  ASSERT_EQ(chown(path.c_str(), kService, kService), 0);
  restore(copy, path);
  struct stat now {};
  ASSERT_EQ(stat(path.c_str(), &now), 0);
  EXPECT_EQ(now.st_uid, kService);
  EXPECT_EQ(now.st_gid, kService);
  EXPECT_EQ(now.st_mode & 07777, 0640U);
}

TEST_F(MaintenanceTest, ADamagedBackupIsNotRestored) {
  const std::string copy = dir.path() + "/backup.db";
  {
    Store store(path);
    fill(store, 4);
  }
  backup(path, copy);
  std::string bytes = file_bytes(copy);
  std::fill(bytes.begin() + 20'480, bytes.begin() + 28'672, 'x');  // pages 6 and 7
  std::ofstream(copy, std::ios::binary) << bytes;
  EXPECT_FALSE(damages(copy).empty());
  const std::string before = file_bytes(path);
  EXPECT_THROW(restore(copy, path), StoreError);
  EXPECT_EQ(file_bytes(path), before);
}

/// Every ninth page of a database is damaged in turn: the check says so wherever something stood in
/// it, and the recovery gets out every run that lost no row to that page, and never a wrong one.
TEST_F(MaintenanceTest, WhateverPageIsDamagedTheRestIsRecovered) {
  {
    Store store(path);
    fill(store, 50);
    store.checkpoint();
  }
  const std::string sound = file_bytes(path);
  const std::string old = dir.path() + "/old.db";
  const std::size_t pages = sound.size() / 4096;
  ASSERT_GT(pages, 30U);
  std::int64_t noticed = 0, tried = 0;
  std::int64_t all = 0;
  for (std::size_t page = 1; page < pages; page += 9, ++tried) {
    SCOPED_TRACE(page);
    std::string bytes = sound;
    std::fill(bytes.begin() + static_cast<std::ptrdiff_t>(4096 * page),
              bytes.begin() + static_cast<std::ptrdiff_t>(4096 * (page + 1)), 'x');
    for (const std::string part : {"", "-wal", "-shm"}) std::filesystem::remove(old + part);
    std::ofstream(old, std::ios::binary) << bytes;
    if (!damages(old).empty()) ++noticed;
    const std::string into = dir.path() + "/into" + std::to_string(page) + ".db";
    Store fresh(into);
    Recovered found;
    try {
      found = recover(old, fresh);
    } catch (const StoreError& error) {  // the list of tables itself
      EXPECT_EQ(error.kind(), StoreFault::kCorrupt);
      continue;
    }
    EXPECT_EQ(fresh.counts().runs, found.runs);
    all += found.runs;
    Store original = Store::open_read_only(path);
    for (const StoredRun& run : fresh.runs()) {
      RunFilter same;
      same.since_us = run.started_us;
      same.until_us = run.started_us + 1;
      const StoredRun before = original.runs(same).at(0);
      if (!run.records.empty() && !run.records[0].values.empty()) {
        EXPECT_EQ(run.records[0].values.at("ovality_um").value,
                  before.records[0].values.at("ovality_um").value);
      }
    }
    EXPECT_EQ(file_bytes(old), bytes) << "the damaged one stays as it is";
    std::filesystem::remove(into);
  }
  EXPECT_EQ(noticed, tried);
  EXPECT_GT(all, 50 * tried * 3 / 5) << tried << " pages; what is lost is lost with the roots of tables";
}

TEST_F(MaintenanceTest, RecoveredAlarmEventsAreNotTheLatest) {
  {
    Store store(path);
    fill(store, 5);
  }
  for (const int later : {0, 2}) {
    SCOPED_TRACE(later);
    Store fresh(dir.path() + "/fresh" + std::to_string(later) + ".db");
    if (later > 0) fill(fresh, later, "later");
    EventFilter told;  // as who is told of alarms follows them
    told.after_id = fresh.last_event();
    for (int again = 0; again < 2; ++again) {
      recover(path, fresh);
      EXPECT_EQ(fresh.events(told).size(), 0U);
      EXPECT_EQ(fresh.events().size(), static_cast<std::size_t>(5 + later));
    }
    fill(fresh, 1, "after");
    EXPECT_EQ(fresh.events(told).size(), 1U);
    std::int64_t last_us = INT64_MIN;
    EventFilter by_id;
    by_id.after_id = INT64_MIN;
    by_id.robot = "lrmate-1";
    for (const StoredEvent& event : fresh.events(by_id)) {
      EXPECT_GT(event.event.at_us, last_us) << "in the sequence that they had";
      last_us = event.event.at_us;
    }
  }
}

TEST_F(MaintenanceTest, DiagnosesAndAlarmsOfBallbardItselfGoWithTheRuns) {
  Store store(path);
  const auto keep_in_mind = [&store](int days) {
    for (int i = days - 1; i >= 0; --i) {
      StoredGap gap;
      gap.record.robot = "lrmate-1";
      gap.record.series = "s" + std::to_string(i);
      gap.record.verdict = "explained";
      gap.record.ended_us = test::kDay - i * kDayUs;
      gap.started_us = gap.record.ended_us;
      gap.json = "{}";
      store.save_gap(gap);
      AlarmStatus own;
      own.key.rule = "ballbard_rules";
      own.state = AlarmState::kFiring;
      own.id = 1;
      own.since_us = test::kDay - i * kDayUs;
      store.save_alarms({own}, {{own, AlarmState::kInactive}});
    }
  };
  fill(store, 10);
  keep_in_mind(10);
  RetentionLimits limits;
  limits.keep_us = 5 * kDayUs;
  const Removed all = retain(store, limits, test::kDay);
  EXPECT_EQ(count(store, "run"), 6);
  EXPECT_EQ(count(store, "gap_result"), 6);
  EXPECT_EQ(count(store, "alarm_event WHERE robot = ''"), 6);
  EXPECT_EQ(all.diagnoses, 4);
  limits = {};
  limits.max_bytes = 1;
  retain(store, limits, test::kDay);
  EXPECT_EQ(count(store, "run"), 0);
  EXPECT_EQ(count(store, "gap_result"), 0) << "what is left is not runs alone";
  EXPECT_EQ(count(store, "alarm_event"), 1) << "the newest one only";
}

TEST_F(MaintenanceTest, RunsWhoseRecordingsAreGoneDoNotHideThoseBehindThem) {
  Store store(path);
  fill(store, 40);
  store.database().execute("DELETE FROM trace WHERE run_id <= 25");
  RetentionLimits limits;
  limits.keep_traces_us = 3 * kDayUs;
  retain(store, limits, test::kDay);  // three at a time
  EXPECT_EQ(count(store, "trace"), 4);
}

TEST_F(MaintenanceTest, ARecoveredAlarmWhoseNumberWasGivenAgainGetsAnother) {
  const test::Saved s = test::circle();
  AlarmStatus old = test::alarm(s, AlarmState::kFiring);
  old.id = 1;
  old.acknowledged = {"anna", "known", test::kDay};
  {
    Store store(path);
    store.save(s.run, s.result, s.records, {old}, {{old, AlarmState::kPending, s.run.started_us}});
  }
  Store fresh(dir.path() + "/fresh.db");
  AlarmStatus own;
  own.key.rule = "ballbard_database";
  own.state = AlarmState::kFiring;
  own.id = 1;
  fresh.save_alarms({own}, {{own, AlarmState::kInactive}});
  for (int again = 0; again < 2; ++again) {
    recover(path, fresh);
    const std::vector<AlarmStatus> found = fresh.alarm_states();
    ASSERT_EQ(found.size(), 2U);
    EXPECT_EQ(found[0].id, 1);
    EXPECT_EQ(found[1].key.rule, "ovality_high");
    EXPECT_EQ(found[1].acknowledged.by, "anna");
    EXPECT_EQ(found[1].id, 2);
    EventFilter of_it;
    of_it.alarm_id = 2;
    of_it.after_id = INT64_MIN;
    ASSERT_EQ(fresh.events(of_it).size(), 1U);
    EXPECT_EQ(fresh.events(of_it)[0].event.status.key.rule, "ovality_high");
  }
}

TEST_F(MaintenanceTest, WhatAFullDiskHeldBackIsDeletedLater) {
  Store store(path);
  fill(store, 10);
  RetentionLimits limits;
  limits.keep_traces_us = 3 * kDayUs;
  Retention retention;
  store.database().execute(
      "CREATE TEMP TRIGGER full BEFORE DELETE ON main.trace WHEN OLD.run_id > 2 "
      "BEGIN SELECT RAISE(ABORT, 'disk full'); END");
  EXPECT_THROW(retention.step(store, limits, test::kDay), StoreError);
  store.database().execute("DROP TRIGGER full");
  for (int i = 0; i < 5; ++i) retention.step(store, limits, test::kDay);
  EXPECT_EQ(count(store, "trace"), 4);
}

TEST_F(MaintenanceTest, WhatIsThereAlreadyIsNotRecoveredTwice) {
  {
    Store store(path);
    fill(store, 5);
  }
  Store fresh(dir.path() + "/fresh.db");
  fill(fresh, 2);
  const Recovered first = recover(path, fresh);
  EXPECT_EQ(first.runs, 3);
  EXPECT_EQ(first.traces, 3);
  EXPECT_EQ(first.lost, 0);
  EXPECT_EQ(recover(path, fresh).runs, 0);
  EXPECT_EQ(fresh.counts().runs, 5);
  EXPECT_EQ(fresh.runs()[0].harmonics.size(), Store::open_read_only(path).runs()[0].harmonics.size());
}

}  // namespace
}  // namespace ballbar
