/// Keeping house: retention, backup, restore, check, recovery.

#include "store/maintenance.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <fstream>
#include <iterator>

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
      all.traces += now.traces;
      all.runs += now.runs;
      all.events += now.events;
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
