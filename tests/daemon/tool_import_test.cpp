// ballbar import: files of instruments into the database; all or nothing.

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "support/csv.hpp"
#include "support/tool_test.hpp"

namespace ballbar {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::ballbar;
using test::Outcome;
using test::Words;

/// Readings of an even circle in micrometres: ovality and a step by direction.
std::string readings(double cos2, double sin2, int direction, int count = 1200) {
  std::string text;
  for (int i = 0; i < count; ++i) {
    const double part = (i + 0.5) / count;
    const double angle = 2 * std::numbers::pi * (direction > 0 ? part : 1 - part);
    text += std::to_string(5.0 + cos2 * std::cos(2 * angle) + sin2 * std::sin(2 * angle)) + " ";
  }
  return text;
}

std::string b5r(const std::string& started = "2022-10-11T12:09:24") {
  return "<?xml version=\"1.0\"?>\n<B><PLANE TEST_PLANE=\"XY\"/><TEST_SPEC NAME=\"A\"/><DATE_STARTED>" +
         started +
         "</DATE_STARTED><SERIAL_NUMBER>H12345</SERIAL_NUMBER>\n<RUN_DIRECTION>CCW</"
         "RUN_DIRECTION><READINGS>" +
         readings(80, -30, 1) + "</READINGS>\n<RUN_DIRECTION>CW</RUN_DIRECTION><READINGS>" +
         readings(100, 40, -1) + "</READINGS></B>\n";
}

class ToolImport : public test::ToolTest {
 protected:
  void SetUp() override {
    db = path(std::string(testing::UnitTest::GetInstance()->current_test_info()->name()) + ".db");
    test::write_file(path("good.b5r"), b5r());
  }
  Words words(Words more) const {
    Words all{"import", "--config", path("lrmate.toml"), "--db", db};
    all.insert(all.end(), more.begin(), more.end());
    return all;
  }
  Outcome import(Words more) const { return ballbar(words(std::move(more))); }
  json runs() const { return json::parse(ballbar({"export", "--json", "--db", db}).out)["runs"]; }
  std::string db;
};

TEST_F(ToolImport, ABallbarResultIsTwoRunsWithTheFiguresThatWerePutIn) {
  const Outcome outcome = import({path("good.b5r"), "--unit", "um", "--series", "old"});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("bar H12345"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("2 runs stored, 2 of them ok, 0 already known"), std::string::npos)
      << outcome.out;
  const json all = runs();
  ASSERT_EQ(all.size(), 2u);
  const double expected[2][2] = {{80, -30}, {100, 40}};
  for (std::size_t i = 0; i < 2; ++i) {
    SCOPED_TRACE(all[i]["run"]);
    EXPECT_EQ(all[i]["run"], i == 0 ? "A+1#1" : "A-1#1");
    EXPECT_EQ(all[i]["status"], "ok");
    EXPECT_EQ(all[i]["angle_source"], "time");
    EXPECT_EQ(all[i]["source"], "bar");
    EXPECT_EQ(all[i]["series"], "old");
    EXPECT_EQ(all[i]["samples"], 1200);
    EXPECT_EQ(all[i]["started_us"].get<std::int64_t>(),
              1'665'490'164'000'000 + 600'000'000 * std::int64_t(i));
    EXPECT_NEAR(all[i]["harmonics"][1]["cos_um"], expected[i][0], 0.01);
    EXPECT_NEAR(all[i]["harmonics"][1]["sin_um"], expected[i][1], 0.01);
    EXPECT_NEAR(all[i]["mean_radius_deviation_um"], 5.0, 0.01);
  }
}

TEST_F(ToolImport, TheSameFileTwiceIsStoredOnce) {
  ASSERT_EQ(import({path("good.b5r"), "--unit", "um"}).code, 0);
  const json before = runs();
  const Outcome again = import({path("good.b5r"), path("good.b5r"), "--unit", "um"});
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_NE(again.out.find("0 runs stored, 0 of them ok, 4 already known"), std::string::npos) << again.out;
  EXPECT_EQ(runs(), before);
}

TEST_F(ToolImport, WhatIsExportedComesInAgain) {
  // A line: recordings are kept to the nanometre, and a range has two ends.
  for (const std::string way : {"+1", "-1"}) {
    const std::string name = "before-mastering:Y" + way + "#1";
    test::write_file(path("line.csv"), ballbar({"export", "--trace", name, "--db", path("a.db")}).out);
    const Outcome outcome =
        import({path("line.csv"), "--test", "Y", "--direction", way == "+1" ? "forward" : "backward",
                "--started", way == "+1" ? "2026-03-11T09:00:00Z" : "2026-03-11T09:10:00Z"});
    ASSERT_EQ(outcome.code, 0) << outcome.err << outcome.out;
    const json original = show(name), imported = runs().back();
    for (const char* figure :
         {"straightness_mz_um", "straightness_ls_um", "straightness_ep_um", "slope_um_per_m"})
      EXPECT_NEAR(imported[figure], original[figure].get<double>(), 2e-3) << figure;
    EXPECT_EQ(imported["status"], "ok");
    EXPECT_EQ(imported["samples"], original["samples"]);
    EXPECT_EQ(imported["profile"].size(), original["profile"].size());
    if (way == "-1") {
      EXPECT_NEAR(imported["reversal_max_um"], original["reversal_max_um"].get<double>(), 2e-3);
    }
  }
  // A circle: the joints are not in the CSV, so its angles come from time.
  test::write_file(path("bar.csv"),
                   ballbar({"export", "--trace", "before-mastering:A-1#1", "--db", path("a.db")}).out);
  const Outcome outcome = import({path("bar.csv"), "--test", "A", "--direction", "cw", "--started",
                                  "2026-03-11T10:00:00Z", "--with-overshoot"});
  ASSERT_EQ(outcome.code, 0) << outcome.err << outcome.out;
  const json original = show("before-mastering:A-1#1"), imported = runs().back();
  EXPECT_EQ(imported["angle_source"], "time");
  EXPECT_EQ(imported["status"], "ok") << imported["message"];
  EXPECT_NEAR(imported["ovality_um"], original["ovality_um"].get<double>(), 1.0);
  EXPECT_NEAR(imported["mean_radius_deviation_um"], original["mean_radius_deviation_um"].get<double>(), 1.0);
}

TEST_F(ToolImport, AnInterferometersCsvComesInByItsColumns) {
  std::string text = "Report\nTarget mm;Fehler um;n\n";
  for (int i = 0; i <= 50; ++i)
    text +=
        std::to_string(i * 18) + "," + std::to_string(i * 8 % 10) + ";" + std::to_string(i % 3) + ",5;1\n";
  test::write_file(path("xl80.csv"), text);
  const Words common{path("xl80.csv"),
                     "--test",
                     "Y",
                     "--direction",
                     "forward",
                     "--skip",
                     "1",
                     "--decimal",
                     "comma",
                     "--columns",
                     "position_mm=1,deviation_um=Fehler um",
                     "--axis",
                     "Z",
                     "--started",
                     "2026-03-11 09:00:00+01:00"};
  const Outcome outcome = import(common);
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const json run = runs()[0];
  EXPECT_EQ(run["axis"], "Z");
  EXPECT_EQ(run["points"], 51);
  EXPECT_EQ(run["started_us"].get<std::int64_t>(), 1'773'216'000'000'000);
  EXPECT_NEAR(run["profile"][2]["deviation_um"], 2.5, 1e-9);
}

TEST_F(ToolImport, ABrokenFileIsOneErrorAndTheDatabaseStaysAsItWas) {
  ASSERT_EQ(import({path("good.b5r"), "--unit", "um"}).code, 0);
  const std::string before = test::read_file(db);
  test::write_file(path("new.b5r"), b5r("2023-01-01T00:00:00"));
  test::write_file(path("cut.b5r"), b5r("2023-01-02T00:00:00").substr(0, 5000));
  test::write_file(path("no_time.b5r"), b5r("11.10.2022 12:09"));
  std::string changed = b5r();
  changed.replace(changed.find("<READINGS>") + 10, 1, "9");
  test::write_file(path("changed.b5r"), changed);
  test::write_file(path("zx.b5r"), b5r().replace(b5r().find("\"XY\""), 4, "\"ZX\""));
  test::write_file(path("page.b5r"), "<html>Not found</html>");
  test::write_file(path("log.b5r"), test::read_file(test::kDemo).substr(0, 100'000));
  test::write_file(path("log.csv"), test::read_file(test::kDemo).substr(0, 100'000));
  test::write_file(path("empty.csv"), "");
  test::write_file(path("cut.csv"), "time_s,deviation_um\n0,1\n1,");
  test::write_file(path("nowhen.csv"), "time_s,deviation_um\n0,1\n1,2\n");
  fs::resize_file(path("empty.csv"), 0);
  test::write_file(path("huge.csv"), "deviation_um\n");
  fs::resize_file(path("huge.csv"), 3'000'000'000);  // a hole: takes no room
  struct Row {
    Words words;
    std::string says;
  };
  const Words csv{"--test", "A", "--direction", "ccw"};
  const auto with = [](Words words, const Words& more) {
    words.insert(words.end(), more.begin(), more.end());
    return words;
  };
  for (const Row& row : {
           Row{{path("good.b5r")}, "give --unit"},
           Row{{path("good.b5r"), "--unit", "feet"}, "'feet' is no unit of length"},
           Row{{path("good.b5r"), "--unit", "mm"}, "is the unit wrong?"},
           Row{{path("good.b5r"), "--unit", "um", "--direction", "cw"}, "leave out --direction"},
           Row{{path("good.b5r"), "--unit", "um", "--direction", "up"}, "--direction"},
           Row{{path("good.b5r"), "--unit", "um", "--test", "Y"}, "is of a circle, the test 'Y' is a line"},
           Row{{path("good.b5r"), "--unit", "um", "--test", "Q"}, "has no test 'Q'; give --test, one of 'A'"},
           Row{{path("good.b5r"), "--unit", "um", "--robot", "Q"},
               "no robot 'Q' is configured; there are 'lrmate-1'"},
           Row{{path("good.b5r"), "--unit", "um", "--series", "a\nb"}, "--series"},
           Row{{path("good.b5r"), path("new.b5r"), "--unit", "um", "--started", "2026-01-01T00:00:00"},
               "one by one"},
           Row{{path("good.b5r"), "--unit", "um", "--started", "noon"}, "--started: 'noon' is no time"},
           Row{{path("no_time.b5r"), "--unit", "um"}, "DATE_STARTED is '11.10.2022 12:09'"},
           Row{{path("new.b5r"), path("cut.b5r"), "--unit", "um"},
               path("cut.b5r") + ": line 3: is no whole XML"},
           Row{{path("zx.b5r"), "--unit", "um"}, "plane ZX"},
           Row{{path("page.b5r"), "--unit", "um"}, "holds no READINGS"},
           Row{{path("log.b5r"), "--unit", "um"}, "is no whole XML"},
           Row{{path("new.b5r"), path("changed.b5r"), "--unit", "um"},
               "the stored run A+1#1, another recording"},
           Row{with({path("log.csv")}, csv), "binary"},
           Row{with({path("empty.csv")}, csv), "is empty"},
           Row{with({path("cut.csv")}, csv), "line 3: has no end"},
           Row{with({path("huge.csv")}, csv), "holds 3000 MB; a recording has at most 16"},
           Row{with({path("gone.csv")}, csv), "cannot be read"},
           Row{with({dir->path()}, csv), "is a folder"},
           Row{with({"/dev/zero"}, csv), "is no ordinary file"},
           Row{with({path("nowhen.csv")}, csv), "when was it recorded?"},
           Row{{path("nowhen.csv"), "--test", "A"}, "which way? give --direction ccw or cw"},
           Row{{path("nowhen.csv"), "--test", "A", "--direction", "forward"}, "give --direction ccw or cw"},
           Row{{path("nowhen.csv"), "--direction", "cw"}, "which test?"},
           Row{with({path("nowhen.csv"), "--columns", "deviation_um"}, csv),
               "--columns: 'deviation_um' is not"},
           Row{with({path("nowhen.csv"), "--started", "2026-01-01T00:00:00"}, csv), "the readings take 2 s"},
       })
    expect_error(words(row.words), 2, row.says);
  EXPECT_EQ(test::read_file(db), before) << "the same bytes";

  const std::string never = path("never_import.db");
  expect_error({"import", path("cut.b5r"), "--unit", "um", "--config", path("lrmate.toml"), "--db", never}, 2,
               "is no whole XML");
  EXPECT_FALSE(fs::exists(never)) << "bad input leaves no database behind";
}

TEST_F(ToolImport, TwoRecordingsOfOneTimeAreRefusedBeforeTheFirstIsStored) {
  test::write_file(path("late.b5r"), b5r("2022-10-11T12:19:24"));  // its first run begins with good's second
  expect_error(words({path("good.b5r"), path("late.b5r"), "--unit", "um"}), 2,
               path("late.b5r") + ": a run in " + path("good.b5r") + " of robot 'lrmate-1' begins at");
  EXPECT_FALSE(fs::exists(db));
}

TEST_F(ToolImport, WhatMayNotBeWrittenIsTheWorldsFailure) {
  expect_error(
      {"import", path("good.b5r"), "--unit", "um", "--config", path("lrmate.toml"), "--db", "/proc/x.db"}, 3,
      "/proc");
}

}  // namespace
}  // namespace ballbar
