/// Bad weather: full disks, locks, damaged and foreign files.

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>

#include <filesystem>
#include <fstream>
#include <iterator>
#include <map>

#include "store/example_runs.hpp"
#include "store/migrations.hpp"
#include "store/processes.hpp"
#include "store/store.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

StoreOptions impatient() {
  StoreOptions options;
  options.busy_timeout_ms = 20;
  return options;
}

std::int64_t put(Store& store, const test::Saved& s) {
  const AlarmStatus firing = test::alarm(s, AlarmState::kFiring);
  return store.save(s.run, s.result, s.records, {firing}, {{firing, AlarmState::kPending, s.run.started_us}});
}

std::string bytes_of(const std::string& path) {
  std::ifstream file(path, std::ios::binary);
  return {std::istreambuf_iterator<char>(file), {}};
}

void write_bytes(const std::string& path, const std::string& bytes) {
  std::ofstream(path, std::ios::binary | std::ios::trunc) << bytes;
}

/// What went wrong when `work` ran; its message must name the file and be one line.
template <class Work>
StoreFault fault_of(const std::string& path, Work work) {
  try {
    work();
  } catch (const StoreError& e) {
    const std::string what = e.what();
    EXPECT_EQ(what.find(path), 0u) << what;
    EXPECT_EQ(what.find('\n'), std::string::npos) << what;
    EXPECT_NE(what.find(';'), std::string::npos) << "does not say what to do: " << what;
    EXPECT_EQ(e.cause(), Cause::kWorld);
    return e.kind();
  }
  ADD_FAILURE() << "nothing was wrong";
  return StoreFault::kOther;
}

std::map<std::string, std::int64_t> rows(Store& store) {
  std::map<std::string, std::int64_t> counts;
  for (const char* t : {"run", "quantity", "harmonic", "line_point", "trace", "alarm_state", "alarm_event"})
    counts[t] = store.database().integer(std::string("SELECT count(*) FROM ") + t);
  return counts;
}

class FailureTest : public testing::Test {
 protected:
  test::TempDir dir;
  std::string path = dir.path() + "/b.db";
};

TEST_F(FailureTest, AFullDatabaseKeepsNothingOfARunWhereverItGotFull) {
  Store store(path);
  put(store, test::circle());
  const auto before = rows(store);
  test::Saved large = test::circle(test::kDay + 1, 2);
  for (int i = 0; i < 20'000; ++i) large.run.readings.push_back({'X', 0.0, 0.0, std::sin(i * i) * 1e-4});
  int failed = 0;
  for (std::int64_t spare = 0;;
       ++spare) {  // one page more each time: another statement is the one that fails
    const std::int64_t pages = store.database().integer("PRAGMA page_count");
    store.database().execute("PRAGMA max_page_count = " + std::to_string(pages + spare));
    try {
      put(store, large);
      break;
    } catch (const StoreError& e) {
      ASSERT_EQ(e.kind(), StoreFault::kFull) << e.what();
      ASSERT_EQ(rows(store), before) << spare;
      ++failed;
    }
    ASSERT_LT(spare, 1000);
  }
  EXPECT_GT(failed, 5);
  EXPECT_EQ(store.counts().runs, 2);  // the same connection works again when there is room
  EXPECT_EQ(
      store.database().integer("SELECT count(*) FROM pragma_integrity_check WHERE integrity_check = 'ok'"),
      1);
}

TEST_F(FailureTest, AFullDiskIsSaidAndSurvived) {
  if (::geteuid() != 0) GTEST_SKIP() << "needs root, for a small disk of its own";
  test::Child child([this] {
    if (::unshare(CLONE_NEWNS) != 0 || ::mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        ::mount("ballbar", dir.path().c_str(), "tmpfs", 0, "size=2m") != 0)
      return 77;
    std::int64_t stored = 0;
    const std::string filler = dir.path() + "/filler";
    write_bytes(filler, std::string(500'000, 'x'));
    Store store(path);
    try {
      for (; stored < 10'000; ++stored)
        put(store, test::circle(test::kDay + stored, static_cast<unsigned>(stored)));
      return 1;  // never full
    } catch (const StoreError& e) {
      if (e.kind() != StoreFault::kFull) throw;
    }
    if (store.counts().runs != stored) return 2;
    std::filesystem::remove(filler);
    put(store, test::circle(test::kDay + 20'000));
    if (store.counts().runs != stored + 1) return 3;
    return store.database().integer(
               "SELECT count(*) FROM pragma_integrity_check WHERE integrity_check = 'ok'") == 1
               ? 0
               : 4;
  });
  const int code = child.wait();
  if (code == 77) GTEST_SKIP() << "this machine allows no mount";
  EXPECT_EQ(code, 0);
}

TEST_F(FailureTest, AnotherWriterIsWaitedForThenSaid) {
  Store store(path, impatient());
  Store other(path);
  {
    const Transaction transaction(other.database());
    EXPECT_EQ(fault_of(path, [&] { put(store, test::circle()); }), StoreFault::kLocked);
    EXPECT_EQ(store.counts().runs, 0);  // readers do not wait for writers
  }
  EXPECT_NO_THROW(put(store, test::circle()));
}

TEST_F(FailureTest, AMissingFolderIsNotMade) {
  const std::string lost = dir.path() + "/no/such/b.db";
  EXPECT_EQ(fault_of(lost, [&] { Store store(lost); }), StoreFault::kCannotOpen);
  EXPECT_FALSE(std::filesystem::exists(dir.path() + "/no"));
  EXPECT_EQ(fault_of(dir.path(), [&] { Store store(dir.path()); }),
            StoreFault::kCannotOpen);  // a folder, no file
}

TEST_F(FailureTest, ReadingMakesNoFile) {
  EXPECT_EQ(fault_of(path, [&] { Store::open_read_only(path); }), StoreFault::kCannotOpen);
  EXPECT_FALSE(std::filesystem::exists(path));
  write_bytes(path, "");
  EXPECT_EQ(fault_of(path, [&] { Store::open_read_only(path); }), StoreFault::kOlder);
  EXPECT_EQ(bytes_of(path), "");
}

TEST_F(FailureTest, AReaderCannotWrite) {
  { Store store(path); }
  Store reader = Store::open_read_only(path);
  EXPECT_EQ(fault_of(path, [&] { put(reader, test::circle()); }), StoreFault::kReadOnly);
}

TEST_F(FailureTest, AFileThatIsNoDatabaseIsLeftAsItIs) {
  const std::string text(5000, '#');
  write_bytes(path, text);
  EXPECT_EQ(fault_of(path, [&] { Store store(path); }), StoreFault::kNotADatabase);
  EXPECT_EQ(fault_of(path, [&] { Store::open_read_only(path); }), StoreFault::kNotADatabase);
  EXPECT_EQ(bytes_of(path), text);
}

TEST_F(FailureTest, ADatabaseOfAnotherApplicationIsLeftAsItIs) {
  for (const char* mode : {"delete", "wal"}) {
    const std::string foreign = dir.path() + "/" + mode + ".db";
    Database other(foreign, Database::Mode::kReadWrite, 20);
    other.integer(std::string("PRAGMA journal_mode = ") + mode);
    other.execute("CREATE TABLE song (name TEXT); INSERT INTO song VALUES ('a')");
    const std::string before = bytes_of(foreign);
    EXPECT_EQ(fault_of(foreign, [&] { Store store(foreign); }), StoreFault::kForeign);
    EXPECT_EQ(fault_of(foreign, [&] { Store::open_read_only(foreign); }), StoreFault::kForeign);
    EXPECT_EQ(bytes_of(foreign), before);
    EXPECT_EQ(other.integer("SELECT count(*) FROM song"), 1);
  }
  EXPECT_FALSE(std::filesystem::exists(dir.path() + "/delete.db-wal"));
}

TEST_F(FailureTest, AForeignDatabaseThatCrashedKeepsItsWalToo) {
  test::Child writer([this] {
    Database other(path, Database::Mode::kReadWrite, 20);
    other.integer("PRAGMA journal_mode = wal");
    other.execute("CREATE TABLE song (name TEXT)");
    ::raise(SIGKILL);
    return 1;
  });
  ASSERT_EQ(writer.wait(), -SIGKILL);
  const std::string before = bytes_of(path);
  EXPECT_EQ(fault_of(path, [&] { Store store(path); }), StoreFault::kForeign);
  EXPECT_EQ(bytes_of(path), before);  // the last to close would copy the WAL into it
  Database again(path, Database::Mode::kReadWrite, 20);
  EXPECT_EQ(again.integer("SELECT count(*) FROM song"), 0);  // it is there
}

TEST_F(FailureTest, ANewerDatabaseIsLeftAsItIs) {
  {
    Store store(path);
    put(store, test::circle());
    store.database().execute("PRAGMA user_version = 99");
  }
  const std::string before = bytes_of(path);
  EXPECT_EQ(fault_of(path, [&] { Store store(path); }), StoreFault::kNewer);
  EXPECT_EQ(fault_of(path, [&] { Store::open_read_only(path); }), StoreFault::kNewer);
  EXPECT_EQ(bytes_of(path), before);
}

TEST_F(FailureTest, DamageIsFoundWhenItIsOpenedAndLeftAsItIs) {
  std::int64_t page = 0;
  {
    Store store(path);
    for (int i = 0; i < 20; ++i) put(store, test::circle(test::kDay + i));
    page = store.database().integer("SELECT rootpage FROM sqlite_schema WHERE name = 'quantity'");
  }
  const std::string good = bytes_of(path);
  std::string bad = good;
  bad.replace(static_cast<std::size_t>(page - 1) * 4096, 4096, std::string(4096, '\x7f'));
  write_bytes(path, bad);
  EXPECT_EQ(fault_of(path, [&] { Store store(path); }), StoreFault::kCorrupt);
  EXPECT_EQ(bytes_of(path), bad);

  write_bytes(path, good.substr(0, good.size() / 2));
  EXPECT_EQ(fault_of(path, [&] { Store store(path); }), StoreFault::kCorrupt);

  bad = good;
  bad.replace(0, 100, std::string(100, '\0'));
  write_bytes(path, bad);
  EXPECT_EQ(fault_of(path, [&] { Store store(path); }), StoreFault::kNotADatabase);
  EXPECT_EQ(bytes_of(path), bad);

  write_bytes(path, good);
  EXPECT_EQ(Store(path).counts().runs, 20);
}

TEST_F(FailureTest, AnyDamageOfAFileIsAnErrorOrHarmlessAndNeverACrash) {
  {
    Store store(path);
    for (int i = 0; i < 5; ++i) put(store, test::line(test::kDay + i));
  }
  const std::string good = bytes_of(path);
  int told = 0;
  for (unsigned seed = 0; seed < 200; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 rng(seed);
    std::string bad = good;
    for (int n = 0; n < 50; ++n) bad[rng() % bad.size()] = static_cast<char>(rng());
    std::filesystem::remove(path + "-wal");
    std::filesystem::remove(path + "-shm");
    write_bytes(path, bad);
    try {
      Store store(path, impatient());
      for (const StoredRun& run : store.runs()) store.trace(run.id);
      store.past(test::line().records[0])->window("recent");
      store.events();
    } catch (const StoreError&) {
      ++told;
    }
  }
  EXPECT_GT(told, 100);
}

TEST(Sqlite, RefusesToBindANumberThatSqliteWouldTurnIntoNull) {
  const test::TempDir dir;
  Database db(dir.path() + "/b.db", Database::Mode::kReadWrite, 20);
  Statement select(db, "SELECT ?1");
  EXPECT_THROW(select.bind(std::nan("")), std::invalid_argument);
  EXPECT_THROW(select.bind(HUGE_VAL), std::invalid_argument);
  ASSERT_TRUE(select.bind("").step());
  EXPECT_FALSE(select.is_null(0));
}

}  // namespace
}  // namespace ballbar
