/// A user who may only read: file 0640, folder 0750, reader in the group. The writer runs, has stopped, has
/// crashed.

#include <grp.h>
#include <gtest/gtest.h>
#include <sys/stat.h>

#include <filesystem>

#include "store/example_runs.hpp"
#include "store/processes.hpp"
#include "store/store.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

constexpr ::uid_t kWriter = 61001, kReader = 61002;
constexpr ::gid_t kGroup = 61000;

/// Becomes that user for good. Only root can; others stay who they are.
void become(::uid_t user) {
  if (::geteuid() != 0) return;
  if (::setgroups(0, nullptr) != 0 || ::setgid(kGroup) != 0 || ::setuid(user) != 0)
    throw std::runtime_error("cannot become another user");
}

class ReadersTest : public testing::Test {
 protected:
  void SetUp() override {
    std::filesystem::create_directory(folder);
    ASSERT_EQ(::chmod(dir.path().c_str(), 0755), 0);
    if (::geteuid() == 0) {
      ASSERT_EQ(::chown(folder.c_str(), kWriter, kGroup), 0);
    }
    ASSERT_EQ(::chmod(folder.c_str(), 0750), 0);
  }
  void TearDown() override { allow_writing(true); }

  /// Without root there is one user only, so the files themselves say no.
  void allow_writing(bool yes) {
    if (::geteuid() == 0) return;
    ::chmod(folder.c_str(), yes ? 0750 : 0550);
    for (const char* suffix : {"", "-wal", "-shm"}) ::chmod((path + suffix).c_str(), yes ? 0640 : 0440);
  }

  /// Writes `runs` runs, says so, and goes on living until the pipe `stop` is closed.
  int write(int runs, test::Pipe& done, test::Pipe& stop) {
    become(kWriter);
    stop.close_write();
    Store store(path);
    for (int i = 0; i < runs; ++i) {
      const test::Saved s = test::circle(store.counts().runs + 1);
      store.save(s.run, s.result, s.records, {}, {});
    }
    done.put(runs);
    long long never = 0;
    stop.take(never);
    return 0;
  }

  /// Exit code of a reader that must see so many runs, and must not be able to write.
  int read(std::int64_t runs) {
    allow_writing(false);
    test::Child reader([this, runs] {
      become(kReader);
      Store store = Store::open_read_only(path);
      if (store.counts().runs != runs || static_cast<std::int64_t>(store.runs().size()) != runs) return 1;
      for (const StoredRun& run : store.runs())
        if (store.trace(run.id).bar_time.empty()) return 2;
      try {
        store.database().execute("DELETE FROM run");
        return 3;
      } catch (const StoreError& e) {
        if (e.kind() != StoreFault::kReadOnly) return 4;
      }
      try {
        Store second(path);  // nor open it as a writer
        return 5;
      } catch (const StoreError& e) {
        return e.kind() == StoreFault::kReadOnly ? 0 : 6;
      }
    });
    const int code = reader.wait();
    allow_writing(true);
    return code;
  }

  test::TempDir dir;
  std::string folder = dir.path() + "/db";
  std::string path = folder + "/ballbard.db";
};

TEST_F(ReadersTest, ReadsWhileTheWriterRunsAndAfterItStoppedAndAfterItCrashed) {
  long long said = 0;
  std::int64_t runs = 0;
  for (const bool crash : {false, true, false}) {
    SCOPED_TRACE(crash ? "crash" : "stop");
    test::Pipe done, stop;
    test::Child writer([&] { return write(3, done, stop); });
    ASSERT_TRUE(done.take(said));
    runs += said;
    EXPECT_EQ(read(runs), 0) << "while it runs";
    if (crash) {
      EXPECT_EQ(writer.kill(), -SIGKILL);
    } else {
      stop.close_write();
      EXPECT_EQ(writer.wait(), 0);
    }
    EXPECT_EQ(read(runs), 0) << "afterwards";
    EXPECT_EQ(read(runs), 0) << "and again";  // a reader leaves nothing behind that stops the next
  }
}

TEST_F(ReadersTest, StrangersCannotRead) {
  if (::geteuid() != 0) GTEST_SKIP() << "needs root, to be two users";
  test::Pipe done, stop;
  test::Child writer([&] { return write(1, done, stop); });
  long long said = 0;
  ASSERT_TRUE(done.take(said));
  test::Child stranger([this] {
    if (::setgroups(0, nullptr) != 0 || ::setgid(kGroup + 1) != 0 || ::setuid(kReader) != 0) return 1;
    try {
      Store::open_read_only(path);
      return 2;
    } catch (const StoreError& e) {
      return e.kind() == StoreFault::kCannotOpen ? 0 : 3;
    }
  });
  EXPECT_EQ(stranger.wait(), 0);
}

}  // namespace
}  // namespace ballbar
