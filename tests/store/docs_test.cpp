/// docs/database.md is true: every query in it runs and finds something, every table and view stands in it.

#include <gtest/gtest.h>

#include <fstream>
#include <iterator>

#include "store/example_runs.hpp"
#include "store/schema.hpp"
#include "store/store.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

std::string document() {
  std::ifstream file(BALLBAR_SOURCE_DIR "/docs/database.md");
  return {std::istreambuf_iterator<char>(file), {}};
}

std::vector<std::string> queries(const std::string& text) {
  const std::string begin = "```sql\n", end = "```";
  std::vector<std::string> all;
  for (std::size_t at = text.find(begin); at != std::string::npos; at = text.find(begin, at)) {
    at += begin.size();
    const std::size_t stop = text.find(end, at);
    all.push_back(text.substr(at, stop - at));
    at = stop + end.size();
  }
  return all;
}

/// Some of everything that the examples ask for.
void fill(Store& store) {
  for (int i = 0; i < 4; ++i) {
    test::Saved s = test::circle(test::kDay + i * 60'000'000LL, static_cast<unsigned>(i));
    s.run.series = i < 2 ? "before" : "after";
    if (i == 1) s.result.status = "no_end";
    s.records[0].values["ovality_cos_um"] = {3.0, 0.1};
    s.records[0].values["ovality_sin_um"] = {i - 1.5, 0.1};
    const AlarmStatus firing = test::alarm(s, AlarmState::kFiring);
    store.save(s.run, s.result, s.records, {firing}, {{firing, AlarmState::kPending, s.run.started_us}});
  }
  const test::Saved l = test::line(test::kDay + 600'000'000);
  store.save(l.run, l.result, l.records, {}, {});
  GapRecord gap{l.run.robot, "after", "explained", l.run.ended_us, 0.9e-6, 41e-6, 1.1e-6, {}};
  gap.left_out.push_back({"joint_lost_motion", "backlash", 2, 3, 0.83, 913.0});
  store.save_gap({gap, l.run.started_us, R"({"verdict": "explained"})"});
}

TEST(DatabaseDocument, EveryQueryFindsSomething) {
  const test::TempDir dir;
  const std::string path = dir.path() + "/b.db";
  Store store(path);
  fill(store);
  Store reader = Store::open_read_only(path);
  const std::vector<std::string> all = queries(document());
  EXPECT_GE(all.size(), 10u);
  for (const std::string& sql : all) {
    SCOPED_TRACE(sql);
    Statement query(reader.database(), sql);
    EXPECT_TRUE(query.step());
    EXPECT_NO_THROW(query.run());
  }
}

TEST(DatabaseDocument, NamesEveryTableAndView) {
  const test::TempDir dir;
  Store store(dir.path() + "/b.db");
  const std::string text = document();
  Statement names(
      store.database(),
      "SELECT name FROM sqlite_schema WHERE type IN ('table', 'view') AND name NOT LIKE 'sqlite_%'");
  int count = 0;
  for (; names.step(); ++count)
    EXPECT_NE(text.find("`" + names.text(0) + "`"), std::string::npos) << names.text(0);
  EXPECT_EQ(count, 26);
}

/// One text per row, so that a wrong join, pivot or unit shows.
std::string row(Store& store, const std::string& sql) {
  Statement query(store.database(), sql);
  std::string text;
  while (query.step()) text += (text.empty() ? "" : "\n") + query.text(0);
  return text;
}

TEST(Views, ShowWhatWasSaved) {
  const test::TempDir dir;
  Store store(dir.path() + "/b.db");
  fill(store);
  EXPECT_EQ(
      row(store,
          "SELECT concat FROM (SELECT run || ' ' || started_utc || ' ' || series || ' ' || status || ' ' || "
          "feed_mm_s || ' ' || ovality_cos_um || ' ' || ovality_sin_um AS concat FROM circle ORDER BY run)"),
      "1 2026-03-11T08:59:59.980Z before ok 55.33 3.0 -1.5\n"
      "2 2026-03-11T09:00:59.980Z before no_end 55.33 3.0 -0.5\n"
      "3 2026-03-11T09:01:59.980Z after ok 55.33 3.0 0.5\n"
      "4 2026-03-11T09:02:59.980Z after ok 55.33 3.0 1.5");
  EXPECT_EQ(row(store, "SELECT count(*) FROM circle WHERE noise_um IS NULL"), "4");  // not saved: not known
  EXPECT_EQ(row(store, "SELECT run || axis FROM line ORDER BY axis"), "5X\n5Z");
  const test::Saved l = test::line();
  for (const Record& r : l.records)
    EXPECT_EQ(store.database().integer(
                  "SELECT straightness_mz_um = (SELECT value FROM quantity WHERE run_id = 5 AND axis = '" +
                  r.axis + "' AND name = 'straightness_mz_um') FROM line WHERE axis = '" + r.axis + "'"),
              1);
  EXPECT_EQ(row(store, "SELECT kind || duration_s FROM run_list ORDER BY run DESC LIMIT 2"),
            "line60.0\ncircle12.0");
  EXPECT_EQ(row(store,
                "SELECT round(amplitude_um - sqrt(cos_um*cos_um + sin_um*sin_um), 9) FROM harmonic_list "
                "WHERE run = 1 AND ord = 2"),
            "0.0");
  EXPECT_EQ(row(store, "SELECT state || ' ' || since_utc FROM alarm_now"), "firing 2026-03-11T09:03:11.980Z");
  EXPECT_EQ(row(store, "SELECT from_state || to_state || run FROM alarm_history WHERE event = 4"),
            "pendingfiring4");
}

}  // namespace
}  // namespace ballbar
