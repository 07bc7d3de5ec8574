#include "store/migrations.hpp"

#include <gtest/gtest.h>

#include <array>
#include <filesystem>
#include <fstream>
#include <iterator>

#include "pipeline/catalogue.hpp"
#include "store/example_runs.hpp"
#include "store/schema.hpp"
#include "store/store.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

class MigrationsTest : public testing::Test {
 protected:
  std::int64_t version() { return db().integer("PRAGMA user_version"); }
  Database& db() {
    if (!db_) db_ = std::make_unique<Database>(path, Database::Mode::kReadWrite, 20);
    return *db_;
  }
  test::TempDir dir;
  std::string path = dir.path() + "/b.db";
  std::unique_ptr<Database> db_;
};

TEST_F(MigrationsTest, AnEmptyFileBecomesADatabaseOfOurs) {
  std::ofstream(path).close();
  EXPECT_EQ(identify(db(), 1), Identity::kEmpty);
  migrate(db(), schema_steps());
  EXPECT_EQ(identify(db(), static_cast<int>(schema_steps().size())), Identity::kOurs);
  EXPECT_EQ(db().integer("PRAGMA application_id"), 0x42414c42);
  EXPECT_EQ(version(), static_cast<std::int64_t>(schema_steps().size()));
}

TEST_F(MigrationsTest, EveryVersionComesUpToDateWithItsRuns) {
  const test::Saved s = test::circle();
  {
    Store store(path);
    store.save(s.run, s.result, s.records, {}, {});
  }
  std::vector<const char*> steps(schema_steps().begin(), schema_steps().end());
  steps.push_back("ALTER TABLE run ADD COLUMN operator TEXT NOT NULL DEFAULT ''");
  steps.push_back(
      "CREATE TABLE note (run_id INTEGER PRIMARY KEY, text TEXT) STRICT; INSERT INTO note VALUES (1, 'n')");
  migrate(db(), steps);
  EXPECT_EQ(version(), static_cast<std::int64_t>(steps.size()));
  EXPECT_EQ(db().integer("SELECT count(*) FROM run WHERE operator = ''"), 1);
  EXPECT_EQ(db().integer("SELECT count(*) FROM note"), 1);
  migrate(db(), steps);  // nothing left to do
  EXPECT_EQ(db().integer("SELECT count(*) FROM note"), 1);
}

TEST_F(MigrationsTest, RunsOfTheFirstVersionAreThereAfterTheUpgrade) {
  migrate(db(), schema_steps().first(1));
  db().execute(
      "INSERT INTO run VALUES (7, 'r', 'A', 'circle', 1, 1, 's', 1000, 2000, 'mark', 'ok', '', 'joints', "
      "'bar', 10, "
      "0, 0, 50.0, 0.4, NULL); INSERT INTO harmonic VALUES (7, 1, 1.5, 2.5, 0.1, 0.1, 0.0);"
      "INSERT INTO line_point VALUES (7, 'X', 0, 1.0, 2.0, NULL)");
  db_.reset();
  const std::vector<StoredRun> runs = Store(path).runs();
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0].id, 7);
  EXPECT_EQ(runs[0].predicted_from, "");
  EXPECT_EQ(runs[0].plane, "");
  ASSERT_EQ(runs[0].harmonics.size(), 1u);
  EXPECT_TRUE(runs[0].gap_harmonics.empty());
  EXPECT_FALSE(runs[0].lines.at(0).second.at(0).predicted.has_value());
}

/// As ballbard wrote it when that was the newest version, its recording too.
TEST_F(MigrationsTest, ADatabaseOfTheFirstVersionKeepsAllItHeld) {
  std::ifstream file(BALLBAR_SOURCE_DIR "/tests/store/version1.sql");
  db().execute({std::istreambuf_iterator<char>(file), {}});
  ASSERT_EQ(version(), 1);
  const std::int64_t figures = db().integer("SELECT count(*) FROM quantity");
  const std::int64_t events = db().integer("SELECT count(*) FROM alarm_event");
  db_.reset();
  Store store(path);
  EXPECT_EQ(version(), static_cast<std::int64_t>(schema_steps().size()));
  const std::vector<StoredRun> runs = store.runs();
  ASSERT_EQ(runs.size(), 3u);
  EXPECT_EQ(runs[0].harmonics.size(), 30u);
  EXPECT_GT(store.trace(runs[0].id).bar_time.size(), 100u);
  EXPECT_FALSE(runs[2].lines.empty());
  EXPECT_EQ(db().integer("SELECT count(*) FROM quantity"), figures);
  EXPECT_EQ(store.events().size(), static_cast<std::size_t>(events));
  EXPECT_FALSE(store.alarm_states().empty());
}

TEST_F(MigrationsTest, AStepThatFailsLeavesTheVersionBeforeIt) {
  const std::array<const char*, 3> steps = {
      "CREATE TABLE a (x INTEGER) STRICT", "CREATE TABLE b (x INTEGER) STRICT",
      "CREATE TABLE c (x INTEGER) STRICT; INSERT INTO nowhere VALUES (1)"};
  EXPECT_THROW(migrate(db(), steps), StoreError);
  EXPECT_EQ(version(), 2);
  EXPECT_EQ(db().integer("SELECT count(*) FROM sqlite_schema WHERE name = 'c'"), 0);
  EXPECT_EQ(db().integer("SELECT count(*) FROM sqlite_schema WHERE name IN ('a', 'b')"), 2);
}

TEST_F(MigrationsTest, AnotherConnectionMayBeFirst) {
  Database other(path, Database::Mode::kReadWrite, 20);
  migrate(other, schema_steps());
  EXPECT_NO_THROW(migrate(db(), schema_steps()));
  EXPECT_NO_THROW(migrate(other, schema_steps()));
}

TEST_F(MigrationsTest, ViewsAreWrittenAnewOnlyWhereTheyDiffer) {
  { Store store(path); }
  const std::int64_t before = db().integer("PRAGMA schema_version");
  { Store store(path); }
  EXPECT_EQ(db().integer("PRAGMA schema_version"), before);
  db().execute("DROP VIEW circle; CREATE VIEW circle AS SELECT 1 AS old_column");
  { Store store(path); }
  EXPECT_EQ(db().integer("SELECT count(*) FROM pragma_table_info('circle') WHERE name = 'ovality_um'"), 1);
}

TEST_F(MigrationsTest, ViewsShowEveryNumberOfTheCatalogue) {
  { Store store(path); }
  for (const Quantity& q : catalogue())
    for (const std::string view : {"circle", "line"}) {
      if (q.kind != "run" && q.kind != view) continue;
      EXPECT_EQ(db().integer("SELECT count(*) FROM pragma_table_info('" + view + "') WHERE name = '" +
                             std::string(q.name) + "'"),
                1)
          << view << " " << q.name;
    }
}

TEST_F(MigrationsTest, EveryTableIsStrictAndEveryReferenceHolds) {
  { Store store(path); }
  EXPECT_EQ(
      db().integer("SELECT count(*) FROM pragma_table_list WHERE type = 'table' AND schema = 'main' AND "
                   "strict = 0 AND name NOT LIKE 'sqlite_%'"),
      0);
  EXPECT_EQ(db().integer("SELECT count(*) FROM pragma_table_list WHERE strict = 1"), 16);
}

TEST_F(MigrationsTest, HistoryIsReadFromItsIndex) {
  Store store(path);
  const auto plan = [&store](const std::string& where) {
    Statement query(store.database(), "EXPLAIN QUERY PLAN SELECT id FROM run WHERE " + where);
    std::string all;
    while (query.step()) all += query.text(3) + "\n";
    return all;
  };
  const std::string recent = plan(
      "robot = 'r' AND test = 't' AND direction = 1 AND source = 'bar' AND status = 'ok' AND "
      "started_us < 9 ORDER BY started_us DESC");
  EXPECT_NE(recent.find("run_judged"), std::string::npos) << recent;
  EXPECT_EQ(recent.find("TEMP B-TREE"), std::string::npos) << recent;
  const std::string series = plan(
      "series = 's' AND robot = 'r' AND test = 't' AND direction = 1 AND source = 'bar' AND status = 'ok' "
      "AND "
      "started_us < 9 ORDER BY started_us");
  EXPECT_NE(series.find("run_judged_series"), std::string::npos) << series;
  EXPECT_EQ(series.find("TEMP B-TREE"), std::string::npos) << series;
}

}  // namespace
}  // namespace ballbar
