// The power fails after any of the writes: the database opens, is whole, and holds every acknowledged run.

#include <gtest/gtest.h>

#include <filesystem>
#include <set>

#include "fault/power_loss_vfs.hpp"
#include "store/example_runs.hpp"
#include "store/store.hpp"
#include "support/process.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

using test::Unsynced;

/// A folder in memory where there is one: a real sync of every image would take minutes.
class MemoryDir {
 public:
  MemoryDir() {
    const std::string base = std::filesystem::exists("/dev/shm") ? "/dev/shm" : "/tmp";
    std::string pattern = base + "/ballbar-power-XXXXXX";
    if (!mkdtemp(pattern.data())) throw std::runtime_error("no temporary folder");
    path_ = pattern;
  }
  ~MemoryDir() { std::filesystem::remove_all(path_); }
  const std::string& path() const { return path_; }

 private:
  std::string path_;
};

void save(Store& store, std::int64_t number) {
  const test::Saved s = number % 3 == 0 ? test::line(test::kDay + number)
                                        : test::circle(test::kDay + number, static_cast<unsigned>(number));
  const AlarmStatus firing = test::alarm(s, AlarmState::kFiring);
  store.save(s.run, s.result, s.records, {firing}, {{firing, AlarmState::kPending, s.run.started_us}});
}

/// A new database, runs, checkpoints between them, a clean end and a second start.
/// @param synchronous  empty: as the store sets it
std::vector<test::DiskOperation> recorded(const std::string& folder, const std::string& synchronous = "") {
  test::RecordedDisk disk;
  std::int64_t number = 1;
  for (const std::int64_t runs : {7, 4}) {
    Store store(folder + "/b.db");
    store.database().execute("PRAGMA wal_autocheckpoint = 60");
    if (!synchronous.empty()) store.database().execute("PRAGMA synchronous = " + synchronous);
    for (std::int64_t i = 0; i < runs; ++i) {
      save(store, number);
      disk.acknowledge(number++);
      if (i == 2) store.checkpoint();
    }
  }
  return disk.log;
}

struct Loss {
  int images = 0;
  int lost = 0;  ///< acknowledged runs that are missing, of all images
  std::string first;
};

/// Opens what a power cut left, and looks.
void look(const std::string& folder, const std::vector<test::DiskOperation>& log, std::size_t count,
          Unsynced unsynced, std::uint64_t seed, Loss& loss) {
  std::filesystem::remove_all(folder);
  std::filesystem::create_directory(folder);
  for (const auto& [name, bytes] : test::after_power_cut(log, count, unsynced, seed))
    test::write_file(folder + "/" + name, bytes);
  std::set<std::int64_t> acknowledged;
  for (std::size_t i = 0; i < count; ++i)
    if (log[i].kind == test::DiskOperation::Kind::kAcknowledged) acknowledged.insert(log[i].offset);
  ++loss.images;
  const std::string what = "behind operation " + std::to_string(count) + ", kind " +
                           std::to_string(static_cast<int>(unsynced)) + ", seed " + std::to_string(seed);
  try {
    Store store(folder + "/b.db");
    for (const std::int64_t number : acknowledged) {
      if (store.has("lrmate-1", test::kDay + number)) continue;
      ++loss.lost;
      if (loss.first.empty()) loss.first = "run " + std::to_string(number) + " " + what;
    }
    const std::int64_t whole =
        store.database().integer("SELECT count(*) FROM pragma_integrity_check WHERE integrity_check = 'ok'");
    const std::vector<StoredRun> runs = store.runs();
    bool once = runs.size() <= acknowledged.size() + 1;
    for (const StoredRun& run : runs)
      once = once && store.trace(run.id).bar_time.size() + store.trace(run.id).readings.size() > 0;
    if (whole == 1 && once) return;
    loss.lost += 1;
    if (loss.first.empty()) loss.first = "not whole " + what;
  } catch (const StoreError& error) {
    loss.lost += 1;
    if (loss.first.empty()) loss.first = std::string(error.what()) + " " + what;
  }
}

TEST(PowerLoss, AfterEveryPrefixOfTheWritesAllAcknowledgedRunsAreThere) {
  const MemoryDir dir;
  const std::vector<test::DiskOperation> log = recorded(dir.path());
  ASSERT_GT(log.size(), 300u);
  Loss loss;
  for (std::size_t count = 0; count <= log.size(); ++count)  // each prefix in one of the four ways
    look(dir.path() + "/cut", log, count, static_cast<Unsynced>(count % 4), count, loss);
  EXPECT_EQ(loss.lost, 0) << loss.first;
}

TEST(PowerLoss, IsSeenByThisTestWhereTheDiskIsNotWaitedFor) {
  const MemoryDir dir;
  const std::vector<test::DiskOperation> log = recorded(dir.path(), "NORMAL");
  Loss loss;
  for (std::size_t count = 0; count <= log.size(); count += 5)
    look(dir.path() + "/cut", log, count, Unsynced::kLost, count, loss);
  EXPECT_GT(loss.lost, 10);
}

// scripts/proof power
TEST(PowerLoss, DISABLED_AfterEveryPrefixInEveryWayAndTwentySeeds) {
  const MemoryDir dir;
  const std::vector<test::DiskOperation> log = recorded(dir.path());
  Loss loss;
  for (std::size_t count = 0; count <= log.size(); ++count) {
    look(dir.path() + "/cut", log, count, Unsynced::kLost, 0, loss);
    look(dir.path() + "/cut", log, count, Unsynced::kThere, 0, loss);
    for (std::uint64_t seed = 0; seed < 20; ++seed)
      for (const Unsynced unsynced : {Unsynced::kSome, Unsynced::kTorn})
        look(dir.path() + "/cut", log, count, unsynced, 1000 * count + seed, loss);
  }
  std::printf("power cut: %zu operations, %d images, %d not as promised\n", log.size(), loss.images,
              loss.lost);
  EXPECT_EQ(loss.lost, 0) << loss.first;
}

}  // namespace
}  // namespace ballbar
