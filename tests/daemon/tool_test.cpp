// The tool as its users see it: real processes, the shipped recording, files, exit codes and what is printed.

#include <gtest/gtest.h>

#include <algorithm>
#include <cctype>
#include <cmath>
#include <filesystem>
#include <nlohmann/json.hpp>

#include "support/csv.hpp"
#include "support/lcm_log.hpp"
#include "support/process.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

namespace fs = std::filesystem;
using nlohmann::json;
using test::Outcome;
using Words = std::vector<std::string>;

const std::string kScripts = BALLBAR_SOURCE_DIR "/scripts";
const std::string kDemo = kScripts + "/demo.lcm";

Outcome ballbar(Words words) {
  words.insert(words.begin(), test::kBallbar);
  return test::run(std::move(words));
}

/// A folder with a configuration for `robot` and an empty rules.d, and the shipped recording in a.db.
class Tool : public testing::Test {
 protected:
  static void SetUpTestSuite() {
    dir = std::make_unique<test::TempDir>();
    fs::create_directory(dir->path() + "/rules.d");
    for (const std::string rule : {"/ovality_drift.lua", "/ovality_high.lua", "/straightness_high.lua"})
      fs::copy(kScripts + "/rules" + rule, dir->path() + "/rules.d" + rule);
    write_config("lrmate.toml", "lrmate-1");
    replayed = ballbar({"replay", kDemo, "--config", path("lrmate.toml"), "--db", path("a.db")});
    exported = json::parse(ballbar({"export", "--json", "--db", path("a.db")}).out);
  }
  static void TearDownTestSuite() { dir.reset(); }

  static std::string path(const std::string& name) { return dir->path() + "/" + name; }
  static void write_config(const std::string& name, const std::string& robot) {
    std::string text = test::read_file(kScripts + "/robots/lrmate200ic.toml");
    const auto replace = [&text](const std::string& from, const std::string& to) { text.replace(text.find(from), from.size(), to); };
    replace("\"lrmate200ic.urdf\"", "\"" + kScripts + "/robots/lrmate200ic.urdf\"");
    replace("\"lrmate-1\"", "\"" + robot + "\"");
    test::write_file(path(name), "[store]\npath = \"configured.db\"\n[rules]\ndirectory = \"rules.d\"\n" + text);
  }
  static json show(const std::string& run) {
    const Outcome outcome = ballbar({"show", run, "--json", "--db", path("a.db")});
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    return outcome.code == 0 ? json::parse(outcome.out) : json();
  }
  static json first_of_kind(const std::string& kind) {
    for (const json& run : exported["runs"])
      if (run["kind"] == kind) return run;
    return {};
  }
  /// An exit code, nothing on standard output, and one line on standard error that says what is wrong.
  static void expect_error(const Words& words, int code, const std::string& says) {
    const Outcome outcome = ballbar(words);
    std::string command = "ballbar";
    for (const std::string& word : words) command += " " + word;
    SCOPED_TRACE(command + "\n" + outcome.err);
    EXPECT_EQ(outcome.code, code);
    EXPECT_EQ(outcome.out, "");
    EXPECT_TRUE(outcome.err.starts_with("ballbar: "));
    EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << "an error is one line";
    EXPECT_NE(outcome.err.find(says), std::string::npos) << "does not say: " << says;
  }

  static inline std::unique_ptr<test::TempDir> dir;
  static inline Outcome replayed;
  static inline json exported;
};

TEST_F(Tool, BadUseAndBadInputAreOneLineAndTwo) {
  const std::string db = path("a.db"), config = path("lrmate.toml");
  test::write_file(path("text.lcm"), "This is no recording, but a letter.\n");
  test::write_file(path("empty.lcm"), "");
  test::write_file(path("bad.toml"), "[store]\npath = \"x.db\"\n[rulez]\n");
  test::write_file(path("no_urdf.toml"), "[[robot]]\nname = \"r\"\nurdf = \"gone.urdf\"\n");
  test::write_file(path("bad.urdf"), "<robot");
  test::write_file(path("bad_urdf.toml"), "[[robot]]\nname = \"r\"\nurdf = \"bad.urdf\"\n");

  expect_error({}, 2, "subcommand is required");
  expect_error({"fly"}, 2, "'fly'");
  expect_error({"rules"}, 2, "subcommand is required");
  expect_error({"rules", "obey"}, 2, "'obey'");
  expect_error({"config"}, 2, "subcommand is required");
  expect_error({"list", "--fast", "--db", db}, 2, "--fast");
  expect_error({"list", "--limit", "few", "--db", db}, 2, "'few' is no number of runs");
  expect_error({"list", "--limit", "-1", "--db", db}, 2, "--limit");
  expect_error({"list", "--db"}, 2, "--db");
  expect_error({"show", "--db", db}, 2, "RUN is required");
  expect_error({"replay", "--config", config}, 2, "LOG is required");
  expect_error({"plot", "A+1#1", "--db", db}, 2, "--output is required");
  expect_error({"export", "--json", "--csv", "--db", db}, 2, "--json excludes --csv");

  expect_error({"replay", path("gone.lcm"), "--config", config, "--db", path("never.db")}, 2, path("gone.lcm") + ": cannot be read");
  expect_error({"replay", path("text.lcm"), "--config", config, "--db", path("never.db")}, 2, path("text.lcm") + ": is not an LCM log");
  expect_error({"replay", path("empty.lcm"), "--config", config, "--db", path("never.db")}, 2, "is not an LCM log");
  expect_error({"replay", dir->path(), "--config", config, "--db", path("never.db")}, 2, "is a folder");
  expect_error({"replay", kDemo, path("gone.lcm"), "--config", config, "--db", path("never.db")}, 2, "gone.lcm");
  expect_error({"replay", kDemo, "--config", path("bad.toml"), "--db", path("never.db")}, 2, path("bad.toml") + ":3:2: unknown key 'rulez'");
  expect_error({"replay", kDemo, "--config", path("bad_urdf.toml"), "--db", path("never.db")}, 2, path("bad.urdf"));
  EXPECT_FALSE(fs::exists(path("never.db"))) << "bad input leaves no database behind";

  expect_error({"config", "check", path("bad.toml")}, 2, path("bad.toml") + ":3:2: unknown key 'rulez'");
  expect_error({"config", "check", path("no_urdf.toml")}, 2, path("no_urdf.toml") + ":3:8: no file " + path("gone.urdf"));
  expect_error({"config", "check", path("bad_urdf.toml")}, 2, "robot 'r': " + path("bad.urdf"));
  expect_error({"config", "check", path("gone.toml")}, 2, path("gone.toml") + ": cannot be read");
  expect_error({"list", "--config", path("bad.toml")}, 2, ":3:2: unknown key");
  expect_error({"show", "99999", "--db", db}, 2, "no run with id 99999 in " + db);
  for (const std::string name : {"Z+1#1", "A+1#77", "nowhere:A+1#1", "A", "", "+1#1", "#1", "99999999999999999999"})
    expect_error({"show", name, "--db", db}, 2, "no run '" + name + "' in " + db);
  expect_error({"export", "--trace", "A+1#77", "--db", db}, 2, "no run 'A+1#77'");
  expect_error({"plot", "A+1#1", "-o", path("x.pdf"), "--db", db}, 2, path("x.pdf") + ": a picture's name ends in .svg or .png");
  expect_error({"plot", "A+1#1", "Y+1#1", "-o", path("x.svg"), "--db", db}, 2, "do not go into one plot");
  expect_error({"plot", "--test", "Z", "-o", path("x.svg"), "--db", db}, 2, "nothing to plot");
  expect_error({"summary", "--series", "Z", "--db", db}, 2, "no run that is ok");
  expect_error({"rules", "check", path("gone")}, 2, path("gone"));
  expect_error({"rules", "test", path("gone")}, 2, path("gone"));
}

TEST_F(Tool, WhereTheWorldFailsItIsOneLineAndThree) {
  const std::string config = path("lrmate.toml");
  test::write_file(path("text.db"), std::string(5000, 'x'));
  for (const std::string verb : {"list", "export", "alarms", "summary"}) {
    expect_error({verb, "--db", path("gone.db")}, 3, path("gone.db") + ": there is no such database");
    expect_error({verb, "--db", path("text.db")}, 3, path("text.db"));
  }
  expect_error({"list", "--config", config}, 3, path("configured.db"));
  expect_error({"replay", kDemo, "--config", config, "--db", "/proc/ballbar.db"}, 3, "/proc/ballbar.db");  // also root may not
  expect_error({"replay", kDemo, "--config", config, "--db", path("none/x.db")}, 3, "there is no folder " + path("none"));
  expect_error({"replay", kDemo, "--config", config, "--db", path("text.db")}, 3, path("text.db"));
  expect_error({"plot", "A+1#1", "-o", path("none/x.svg"), "--db", path("a.db")}, 3, path("none"));
  EXPECT_EQ(test::read_file(path("text.db")), std::string(5000, 'x')) << "a file that is not ours stays as it is";

  const Outcome full = test::run({"sh", "-c", test::kBallbar + " export --db " + path("a.db") + " > /dev/full"});
  EXPECT_EQ(full.code, 3) << "what could not be written is not done";
  EXPECT_NE(full.err.find("standard output cannot be written"), std::string::npos) << full.err;
}

TEST_F(Tool, AFolderThatMayNotBeWrittenIsTheWorldsFailure) {
  if (geteuid() == 0) GTEST_SKIP() << "root may write everywhere";
  fs::create_directory(path("locked"));
  fs::permissions(path("locked"), fs::perms::owner_read | fs::perms::owner_exec);
  expect_error({"replay", kDemo, "--config", path("lrmate.toml"), "--db", path("locked/x.db")}, 3, path("locked"));
}

TEST_F(Tool, EveryVerbHasHelp) {
  const std::vector<std::pair<Words, Words>> table{
      {{}, {"replay", "list", "show", "export", "plot", "summary", "alarms", "rules", "config", "Exit codes"}},
      {{"replay"}, {"LOG", "--config", "--db", "--publish", "--quiet"}},
      {{"list"}, {"--config", "--db", "--robot", "--test", "--series", "--limit", "--json"}},
      {{"show"}, {"RUN", "--config", "--db", "--json"}},
      {{"export"}, {"--config", "--db", "--json", "--csv", "--trace", "--series"}},
      {{"summary"}, {"--config", "--db", "--json", "--series"}},
      {{"plot"}, {"RUN", "--output", "--config", "--db", "--series"}},
      {{"alarms"}, {"--config", "--db"}},
      {{"rules"}, {"check", "test"}},
      {{"rules", "check"}, {"DIRECTORY", "--config"}},
      {{"rules", "test"}, {"DIRECTORY", "--config"}},
      {{"config"}, {"check"}},
      {{"config", "check"}, {"FILE", "--config"}},
  };
  for (const auto& [verb, says] : table) {
    Words words = verb;
    words.push_back("--help");
    const Outcome outcome = ballbar(words);
    EXPECT_EQ(outcome.code, 0);
    EXPECT_EQ(outcome.err, "");
    for (const std::string& word : says) EXPECT_NE(outcome.out.find(word), std::string::npos) << word << " in\n" << outcome.out;
  }
  const Outcome version = ballbar({"--version"});
  EXPECT_EQ(version.code, 0);
  EXPECT_TRUE(!version.out.empty() && std::isdigit(static_cast<unsigned char>(version.out[0]))) << version.out;
}

TEST_F(Tool, ReplayStoresEveryRunOnceAndSaysSoWithoutProgressInAPipe) {
  EXPECT_EQ(replayed.code, 0) << replayed.err;
  EXPECT_EQ(replayed.err, "");
  EXPECT_NE(replayed.out.find("0 lost, 0 refused\n16 runs stored, 16 of them ok, 0 already known"), std::string::npos) << replayed.out;
  EXPECT_EQ(replayed.out.find_first_of("\r\033"), std::string::npos) << replayed.out;
  EXPECT_EQ(exported["runs"].size(), 16u);

  const Outcome again = ballbar({"replay", kDemo, "--config", path("lrmate.toml"), "--db", path("a.db"), "--quiet"});
  EXPECT_EQ(again.code, 0) << again.err;
  EXPECT_NE(again.out.find("0 runs stored, 0 of them ok, 16 already known"), std::string::npos) << again.out;
  EXPECT_EQ(std::count(again.out.begin(), again.out.end(), '\n'), 2) << "quiet: the log and the totals\n" << again.out;
  EXPECT_EQ(json::parse(ballbar({"export", "--json", "--db", path("a.db")}).out), exported);
}

TEST_F(Tool, TheConfiguredDatabaseIsTakenWhereNoneIsNamed) {
  write_config("own.toml", "lrmate-1");
  std::string text = test::read_file(path("own.toml"));
  text.replace(text.find("configured.db"), 13, "own.db");
  test::write_file(path("own.toml"), text);
  EXPECT_EQ(ballbar({"replay", kDemo, "--config", path("own.toml"), "--quiet"}).code, 0);
  EXPECT_EQ(json::parse(ballbar({"export", "--config", path("own.toml")}).out), exported);
}

TEST_F(Tool, MessagesOfRobotsThatAreNotConfiguredAreRefusedAndCounted) {
  write_config("other.toml", "somebody-else");
  const Outcome outcome = ballbar({"replay", kDemo, "--config", path("other.toml"), "--db", path("other.db")});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find(" 7380 refused (unknown_robot 7380)"), std::string::npos) << outcome.out;
  EXPECT_NE(outcome.out.find("0 runs stored"), std::string::npos) << outcome.out;
  EXPECT_EQ(json::parse(ballbar({"export", "--db", path("other.db")}).out), json::parse("{\"runs\": []}"));
}

TEST_F(Tool, ALogThatEndsInTheMiddleGivesWhatWasWhole) {
  const std::string log = test::read_file(kDemo);
  test::write_file(path("cut.lcm"), log.substr(0, log.size() / 2));
  const Outcome outcome = ballbar({"replay", path("cut.lcm"), "--config", path("lrmate.toml"), "--db", path("cut.db")});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const json runs = json::parse(ballbar({"export", "--db", path("cut.db")}).out)["runs"];
  ASSERT_GT(runs.size(), 2u);
  ASSERT_LT(runs.size(), 16u);
  for (std::size_t i = 0; i + 1 < runs.size(); ++i) EXPECT_EQ(runs[i], exported["runs"][i]) << "run " << i;
  EXPECT_NE(runs.back()["status"], "ok") << "the run in which the log ends is there, and says that it has no end";
}

// The contract: other people's scripts read these names.
TEST_F(Tool, TheJsonOfACircleHasEveryName) {
  const json circle = first_of_kind("circle");
  for (const char* name : {"run", "robot", "test", "series", "status", "angle_source"})
    EXPECT_TRUE(circle.contains(name) && circle[name].is_string()) << name;
  for (const char* name : {"direction", "repetition", "started_us", "samples", "lost_messages"})
    EXPECT_TRUE(circle.contains(name) && circle[name].is_number_integer()) << name;
  for (const char* name : {"mean_radius_deviation_um", "eccentricity_um", "eccentricity_deg", "ovality_um", "ovality_axis_deg",
                           "circular_deviation_um", "radial_max_um", "radial_min_um", "noise_um"})
    EXPECT_TRUE(circle.contains(name) && circle[name].is_number()) << name;
  EXPECT_EQ(circle["run"], "A+1#1");
  EXPECT_EQ(circle["robot"], "lrmate-1");
  EXPECT_EQ(circle["series"], "before-mastering");
  EXPECT_EQ(circle["angle_source"], "joints");
  ASSERT_EQ(circle["harmonics"].size(), 30u);
  for (std::size_t k = 0; k < 30; ++k) {
    const json& harmonic = circle["harmonics"][k];
    EXPECT_EQ(harmonic["order"], k + 1);
    for (const char* name : {"cos_um", "sin_um", "amplitude_um", "sd_um"}) EXPECT_TRUE(harmonic.at(name).is_number()) << name;
    EXPECT_NEAR(harmonic["amplitude_um"], std::hypot(harmonic["cos_um"].get<double>(), harmonic["sin_um"].get<double>()), 1e-9);
  }
  EXPECT_NEAR(circle["harmonics"][0]["amplitude_um"], circle["eccentricity_um"], 1e-9) << "order 1 holds the eccentricity";
  EXPECT_NEAR(circle["harmonics"][1]["amplitude_um"], circle["ovality_um"], 1e-9);
  EXPECT_NEAR(circle["radial_max_um"].get<double>() - circle["radial_min_um"].get<double>(), circle["circular_deviation_um"], 1e-9);
}

TEST_F(Tool, TheJsonOfALineHasEveryName) {
  const json line = first_of_kind("line");
  for (const char* name : {"run", "robot", "test", "series", "status", "axis"})
    EXPECT_TRUE(line.contains(name) && line[name].is_string()) << name;
  for (const char* name : {"direction", "repetition", "started_us", "samples", "lost_messages", "points"})
    EXPECT_TRUE(line.contains(name) && line[name].is_number_integer()) << name;
  for (const char* name : {"straightness_mz_um", "straightness_ls_um", "straightness_ep_um"})
    EXPECT_TRUE(line.contains(name) && line[name].is_number()) << name;
  EXPECT_TRUE(line.contains("reversal_max_um") && line["reversal_max_um"].is_null()) << "the first line has no run the other way yet";
  const json backward = show("before-mastering:Y-1#1");
  EXPECT_TRUE(backward["reversal_max_um"].is_number());
  EXPECT_EQ(line["run"], "Y+1#1");
  EXPECT_EQ(line["axis"], "X");
  EXPECT_EQ(line["points"], 51);
  EXPECT_FALSE(line.contains("ovality_um"));
}

TEST_F(Tool, ShowIsTheEntryOfTheExport) {
  for (const json& run : exported["runs"]) {
    EXPECT_EQ(show(std::to_string(run["id"].get<int>())), run);
    EXPECT_EQ(show(run["series"].get<std::string>() + ":" + run["run"].get<std::string>()), run);
  }
  EXPECT_EQ(json::parse(ballbar({"list", "--json", "--db", path("a.db")}).out), exported);
  EXPECT_EQ(show("A+1#1")["series"], "production") << "without a series the latest run of the name";

  const Outcome text = ballbar({"show", "A-1#1", "--db", path("a.db")});
  EXPECT_EQ(text.code, 0);
  for (const char* word : {"lrmate-1 A-1#1", "status ok", "angles from joints", "ovality_um", "harmonic"})
    EXPECT_NE(text.out.find(word), std::string::npos) << word << " in\n" << text.out;
}

TEST_F(Tool, RunsAreChosenByLabelAndByNumber) {
  const auto starts = [](const Words& words) {
    std::vector<std::int64_t> all;
    for (const json& run : json::parse(ballbar(words).out)["runs"]) all.push_back(run["started_us"]);
    return all;
  };
  std::vector<std::int64_t> all, production;
  for (const json& run : exported["runs"]) {
    all.push_back(run["started_us"]);
    if (run["series"] == "production") production.push_back(run["started_us"]);
  }
  ASSERT_TRUE(std::is_sorted(all.begin(), all.end()));
  const std::string db = path("a.db");
  for (const char* verb : {"list", "export"}) {
    SCOPED_TRACE(verb);
    EXPECT_EQ(starts({verb, "--json", "--db", db, "--series", "production"}), production);
    EXPECT_EQ(starts({verb, "--json", "--db", db, "--limit", "3"}), std::vector(all.end() - 3, all.end())) << "the latest, oldest first";
    EXPECT_EQ(starts({verb, "--json", "--db", db, "--limit", "0"}), all);
    EXPECT_EQ(starts({verb, "--json", "--db", db, "--robot", "nobody"}).size(), 0u);
    EXPECT_EQ(starts({verb, "--json", "--db", db, "--test", "Y"}).size(), 4u);
  }
  const Outcome table = ballbar({"list", "--db", db});
  EXPECT_EQ(std::count(table.out.begin(), table.out.end(), '\n'), 17) << "a heading and one line per run\n" << table.out;
}

TEST_F(Tool, TheCsvHasTheFiguresOfTheJson) {
  const Outcome outcome = ballbar({"export", "--csv", "--db", path("a.db")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::vector<test::CsvRow> rows = test::parse_csv(outcome.out);
  ASSERT_EQ(rows.size(), 16u) << "one line per circle and per axis";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const json& run = exported["runs"][i];
    SCOPED_TRACE("row " + std::to_string(i));
    EXPECT_EQ(rows[i].at("run"), run["run"]);
    EXPECT_EQ(rows[i].at("series"), run["series"]);
    EXPECT_EQ(rows[i].at("started_us"), std::to_string(run["started_us"].get<std::int64_t>()));
    for (const char* name : {"ovality_um", "circular_deviation_um", "straightness_mz_um", "reversal_max_um"}) {
      if (run.value(name, json()).is_null())
        EXPECT_EQ(rows[i].at(name), "") << name;
      else
        EXPECT_EQ(std::stod(rows[i].at(name)), run[name].get<double>()) << name;
    }
  }
}

TEST_F(Tool, LabelsFromTheWireMayHoldAnything) {
  const std::string label = "hot, \"after\" <b>:1\n2\xff";
  test::copy_log(kDemo, path("label.lcm"), [&](test_mark_t& mark) {
    mark.series = label;
    return mark.repetition == 1 && mark.test != "B";
  });
  ASSERT_EQ(ballbar({"replay", path("label.lcm"), "--config", path("lrmate.toml"), "--db", path("label.db")}).code, 0);
  const std::string shown = "hot, \"after\" <b>:1\n2\xEF\xBF\xBD";
  const Outcome outcome = ballbar({"export", "--db", path("label.db")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const json runs = json::parse(outcome.out)["runs"];
  ASSERT_GT(runs.size(), 0u);
  for (const json& run : runs) EXPECT_EQ(run["series"], shown);
  const std::vector<test::CsvRow> rows = test::parse_csv(ballbar({"export", "--csv", "--db", path("label.db")}).out);
  ASSERT_EQ(rows.size(), runs.size());
  for (const test::CsvRow& row : rows) EXPECT_EQ(row.at("series"), label);
  for (const char* verb : {"list", "summary", "alarms"}) EXPECT_EQ(ballbar({verb, "--db", path("label.db")}).code, 0) << verb;
  EXPECT_EQ(ballbar({"summary", "--json", "--db", path("label.db")}).code, 0);
  EXPECT_EQ(ballbar({"show", label + ":A+1#1", "--json", "--db", path("label.db")}).code, 0) << "a series with a colon";
  EXPECT_EQ(ballbar({"plot", "A+1#1", "-o", path("label.svg"), "--db", path("label.db")}).code, 0);
}

TEST_F(Tool, TheRecordingComesOutAsCsv) {
  const json circle = show("before-mastering:A-1#1");
  const std::vector<test::CsvRow> bar = test::parse_csv(ballbar({"export", "--trace", "before-mastering:A-1#1", "--db", path("a.db")}).out);
  std::int64_t measured = 0;
  double before = -1e9;
  for (const test::CsvRow& row : bar) {
    EXPECT_GT(std::stod(row.at("time_s")), before);
    before = std::stod(row.at("time_s"));
    if (row.at("in_measured_arc") != "1") continue;
    ++measured;
    EXPECT_LT(std::abs(std::stod(row.at("deviation_um"))), 1000.0);
    EXPECT_TRUE(std::isfinite(std::stod(row.at("angle_deg"))));
  }
  EXPECT_EQ(measured, circle["samples"].get<std::int64_t>());
  EXPECT_GT(bar.size(), static_cast<std::size_t>(measured)) << "with its overshoot";

  const json line = show("before-mastering:Y+1#1");
  const std::vector<test::CsvRow> readings = test::parse_csv(ballbar({"export", "--trace", "before-mastering:Y+1#1", "--db", path("a.db")}).out);
  EXPECT_EQ(readings.size(), line["samples"].get<std::size_t>());
  for (const test::CsvRow& row : readings) EXPECT_EQ(row.at("axis"), "X");
}

/// True if every element is closed in its place and there is one root.
bool well_formed(const std::string& xml) {
  Words open;
  int roots = 0;
  for (std::size_t at = xml.find('<'); at != std::string::npos; at = xml.find('<', at + 1)) {
    const bool comment = xml.compare(at, 4, "<!--") == 0;
    const std::size_t end = xml.find(comment ? "-->" : ">", at);
    if (end == std::string::npos) return false;
    if (comment || xml[at + 1] == '?' || xml[at + 1] == '!') {
      at = end;
      continue;
    }
    const bool closing = xml[at + 1] == '/';
    const std::size_t begin = at + (closing ? 2 : 1);
    const std::string name = xml.substr(begin, xml.find_first_of(" \t\n/>", begin) - begin);
    if (closing) {
      if (open.empty() || open.back() != name) return false;
      open.pop_back();
    } else {
      if (open.empty()) ++roots;
      if (xml[end - 1] != '/') open.push_back(name);
    }
    at = end;
  }
  return open.empty() && roots == 1;
}

TEST_F(Tool, PlotDrawsSvgAndPng) {
  const std::string db = path("a.db");
  for (const Words& runs : {Words{"before-mastering:A+1#1", "before-mastering:A-1#1"}, Words{"Y+1#1", "Y-1#1"}, Words{"--test", "A"}}) {
    SCOPED_TRACE(runs[0]);
    for (const std::string ending : {"svg", "png"}) {
      Words words{"plot", "-o", path("p." + ending), "--db", db};
      words.insert(words.begin() + 1, runs.begin(), runs.end());
      const Outcome outcome = ballbar(words);
      EXPECT_EQ(outcome.code, 0) << outcome.err;
      EXPECT_EQ(outcome.err, "");
    }
    const std::string svg = test::read_file(path("p.svg"));
    EXPECT_NE(svg.find("<svg"), std::string::npos);
    EXPECT_TRUE(well_formed(svg));
    EXPECT_NE(svg.find("lrmate-1"), std::string::npos) << "the heading names the robot";
    EXPECT_TRUE(test::read_file(path("p.png")).starts_with("\x89PNG\r\n\x1a\n"));
  }
}

TEST_F(Tool, AlarmsOfTheRecordingAreShown) {
  const Outcome outcome = ballbar({"alarms", "--db", path("a.db")});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const std::size_t at = outcome.out.find("ovality_drift");
  ASSERT_NE(at, std::string::npos) << outcome.out;
  const std::size_t begin = outcome.out.rfind('\n', at) + 1;
  const std::string line = outcome.out.substr(begin, outcome.out.find('\n', at) - begin);
  for (const char* word : {"firing", "warning", "lrmate-1", "A+1", "moved"}) EXPECT_NE(line.find(word), std::string::npos) << word << ": " << line;
}

TEST_F(Tool, RulesAreCheckedAndTested) {
  const Outcome check = ballbar({"rules", "check", kScripts + "/rules"});
  EXPECT_EQ(check.code, 0) << check.out << check.err;
  EXPECT_NE(check.out.find("3 rules good, 0 errors"), std::string::npos) << check.out;
  EXPECT_EQ(ballbar({"rules", "check", "--config", path("lrmate.toml")}).code, 0) << "the configured folder";
  const Outcome test = ballbar({"rules", "test", kScripts + "/rules"});
  EXPECT_EQ(test.code, 0) << test.out << test.err;
  EXPECT_NE(test.out.find("3 tables, 0 failures"), std::string::npos) << test.out;

  fs::create_directory(path("bad"));
  fs::copy(kScripts + "/rules/ovality_high.lua", path("bad/good.lua"));
  test::write_file(path("bad/bad.lua"), "return {\n  name = \"bad\",\n  on = = \"circle\",\n}\n");
  test::write_file(path("bad/good_test.lua"), "return { rule = \"good.lua\",\n  { ovality_um = 1.0, expect = \"firing\" },\n}\n");
  const Outcome bad = ballbar({"rules", "check", path("bad")});
  EXPECT_EQ(bad.code, 1) << "the answer is no";
  EXPECT_NE(bad.out.find(path("bad/bad.lua") + ":3: "), std::string::npos) << bad.out;
  EXPECT_NE(bad.out.find("1 rules good, 1 errors"), std::string::npos) << bad.out;
  const Outcome failing = ballbar({"rules", "test", path("bad")});
  EXPECT_EQ(failing.code, 1);
  EXPECT_NE(failing.out.find(path("bad/good_test.lua") + ":2: "), std::string::npos) << failing.out;
}

TEST_F(Tool, ARuleThatDoesNotLoadDoesNotStopAReplay) {
  fs::create_directory(path("half"));
  fs::copy(kScripts + "/rules/ovality_drift.lua", path("half/ovality_drift.lua"));
  test::write_file(path("half/bad.lua"), "return {\n");
  std::string text = test::read_file(path("lrmate.toml"));
  text.replace(text.find("rules.d"), 7, "half");
  test::write_file(path("half.toml"), text);
  const Outcome outcome = ballbar({"replay", kDemo, "--config", path("half.toml"), "--db", path("half.db"), "--quiet"});
  EXPECT_EQ(outcome.code, 0);
  EXPECT_TRUE(outcome.err.starts_with("ballbar: bad.lua:")) << outcome.err;
  EXPECT_EQ(std::count(outcome.err.begin(), outcome.err.end(), '\n'), 1) << outcome.err;
  EXPECT_NE(ballbar({"alarms", "--db", path("half.db")}).out.find("ovality_drift"), std::string::npos);
}

TEST_F(Tool, TheConfigurationIsChecked) {
  for (const Words& words : {Words{"config", "check", path("lrmate.toml")}, Words{"config", "check", "--config", path("lrmate.toml")}}) {
    const Outcome outcome = ballbar(words);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out, "robot lrmate-1: 3 tests, 6 joints from base to tcp\n" + path("lrmate.toml") + " is good\n");
  }
}

}  // namespace
}  // namespace ballbar
