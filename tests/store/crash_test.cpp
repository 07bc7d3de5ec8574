/// kill -9 under load: what was acknowledged is there, and nothing is there by halves.

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "store/example_runs.hpp"
#include "store/processes.hpp"
#include "store/store.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

/// Stores runs for ever, one after the other, and says each one that save() returned for.
int store_for_ever(const std::string& path, long long first, test::Pipe& stored) {
  stored.close_read();
  Store store(path);
  for (long long i = first;; ++i) {
    const test::Saved s = i % 3 == 0 ? test::line(i) : test::circle(i, static_cast<unsigned>(i));
    const AlarmStatus firing = test::alarm(s, AlarmState::kFiring);
    store.save(s.run, s.result, s.records, {firing}, {{firing, AlarmState::kPending, s.run.started_us}});
    stored.put(i);
  }
}

void expect_whole(Store& store, const StoredRun& run) {
  const test::Saved s = run.kind == TestKind::kLine
                            ? test::line(run.started_us)
                            : test::circle(run.started_us, static_cast<unsigned>(run.started_us));
  EXPECT_EQ(run.records, s.records);
  EXPECT_EQ(run.harmonics.size(), s.result.circle ? s.result.circle->harmonics.size() : 0);
  EXPECT_EQ(run.lines.size(), s.result.lines.size());
  EXPECT_EQ(store.trace(run.id).bar_time.size(), s.run.bar_time.size());
  EventFilter filter;
  filter.run_id = run.id;
  EXPECT_EQ(store.events(filter).size(), 1u);
}

TEST(Crash, LosesNoAcknowledgedRunWhenTheWriterIsKilledUnderLoad) {
  const test::TempDir dir;
  const std::string path = dir.path() + "/b.db";
  std::vector<long long> acknowledged;
  std::mt19937_64 rng(11);
  for (int round = 0; round < 8; ++round) {
    SCOPED_TRACE("round " + std::to_string(round));
    test::Pipe stored;
    const long long first = 1 + round * 100'000LL;
    test::Child writer([&] { return store_for_ever(path, first, stored); });
    stored.close_write();
    long long run = 0;
    for (auto left = 3 + rng() % 60; left > 0 && stored.take(run); --left) acknowledged.push_back(run);
    ASSERT_EQ(writer.kill(), -SIGKILL);
    while (stored.take(run)) acknowledged.push_back(run);

    Store store(path);
    for (const long long started_us : acknowledged)
      EXPECT_TRUE(store.has("lrmate-1", started_us)) << started_us;
    EXPECT_EQ(
        store.database().integer("SELECT count(*) FROM pragma_integrity_check WHERE integrity_check = 'ok'"),
        1);
    const std::vector<StoredRun> runs = store.runs();
    // At most one run a round was stored whose acknowledgement the kill cut off.
    EXPECT_LE(runs.size(), acknowledged.size() + static_cast<std::size_t>(round) + 1);
    for (const StoredRun& stored_run : runs) expect_whole(store, stored_run);
  }
}

}  // namespace
}  // namespace ballbar
