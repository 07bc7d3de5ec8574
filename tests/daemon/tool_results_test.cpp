// What the tool gives of stored runs: JSON by the contract, CSV, pictures, lists, alarms.

#include <gtest/gtest.h>

#include <cmath>
#include <map>

#include "support/csv.hpp"
#include "support/lcm_log.hpp"
#include "support/tool_test.hpp"

namespace ballbar {
namespace {

using nlohmann::json;
using test::ballbar;
using test::kDemo;
using test::Outcome;
using test::Words;

class ToolResults : public test::ToolTest {};

// The contract: other people's scripts read these names.
TEST_F(ToolResults, TheJsonOfACircleHasEveryName) {
  const json circle = first_of_kind("circle");
  for (const char* name : {"run", "robot", "test", "series", "status", "angle_source"})
    EXPECT_TRUE(circle.contains(name) && circle[name].is_string()) << name;
  for (const char* name : {"direction", "repetition", "started_us", "samples", "lost_messages"})
    EXPECT_TRUE(circle.contains(name) && circle[name].is_number_integer()) << name;
  for (const char* name :
       {"mean_radius_deviation_um", "eccentricity_um", "eccentricity_deg", "ovality_um", "ovality_axis_deg",
        "circular_deviation_um", "radial_max_um", "radial_min_um", "noise_um"})
    EXPECT_TRUE(circle.contains(name) && circle[name].is_number()) << name;
  EXPECT_EQ(circle["run"], "A+1#1");
  EXPECT_EQ(circle["robot"], "lrmate-1");
  EXPECT_EQ(circle["series"], "before-mastering");
  EXPECT_EQ(circle["angle_source"], "joints");
  EXPECT_EQ(circle["plane"], "XY");
  ASSERT_EQ(circle["harmonics"].size(), 30u);
  for (std::size_t k = 0; k < 30; ++k) {
    const json& harmonic = circle["harmonics"][k];
    EXPECT_EQ(harmonic["order"], k + 1);
    for (const char* name : {"cos_um", "sin_um", "amplitude_um", "sd_um"})
      EXPECT_TRUE(harmonic.at(name).is_number()) << name;
    EXPECT_NEAR(harmonic["amplitude_um"],
                std::hypot(harmonic["cos_um"].get<double>(), harmonic["sin_um"].get<double>()), 1e-9);
  }
  // The motion that leaves no first harmonic, and the least-squares centre: the same but for ovality's share.
  EXPECT_NEAR(circle["harmonics"][0]["amplitude_um"], circle["eccentricity_um"], 0.02)
      << "order 1 holds the eccentricity";
  EXPECT_NEAR(circle["harmonics"][1]["amplitude_um"], circle["ovality_um"], 1e-9);
  EXPECT_NEAR(circle["radial_max_um"].get<double>() - circle["radial_min_um"].get<double>(),
              circle["circular_deviation_um"], 1e-9);
}

TEST_F(ToolResults, TheJsonOfALineHasEveryName) {
  const json line = first_of_kind("line");
  for (const char* name : {"run", "robot", "test", "series", "status", "axis"})
    EXPECT_TRUE(line.contains(name) && line[name].is_string()) << name;
  for (const char* name : {"direction", "repetition", "started_us", "samples", "lost_messages", "points"})
    EXPECT_TRUE(line.contains(name) && line[name].is_number_integer()) << name;
  for (const char* name : {"straightness_mz_um", "straightness_ls_um", "straightness_ep_um"})
    EXPECT_TRUE(line.contains(name) && line[name].is_number()) << name;
  EXPECT_TRUE(line.contains("reversal_max_um") && line["reversal_max_um"].is_null())
      << "the first line has no run the other way yet";
  const json backward = show("before-mastering:Y-1#1");
  EXPECT_TRUE(backward["reversal_max_um"].is_number());
  EXPECT_EQ(line["run"], "Y+1#1");
  EXPECT_EQ(line["axis"], "X");
  EXPECT_EQ(line["points"], 51);
  EXPECT_FALSE(line.contains("ovality_um"));
}

TEST_F(ToolResults, ShowIsTheEntryOfTheExport) {
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

TEST_F(ToolResults, RunsAreChosenByLabelAndByNumber) {
  const auto starts = [](const Words& words) {
    std::vector<std::int64_t> all;
    const json found = json::parse(ballbar(words).out);
    for (const json& run : found["runs"]) all.push_back(run["started_us"]);
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
    EXPECT_EQ(starts({verb, "--json", "--db", db, "--limit", "3"}), std::vector(all.end() - 3, all.end()))
        << "the latest, oldest first";
    EXPECT_EQ(starts({verb, "--json", "--db", db, "--limit", "0"}), all);
    EXPECT_EQ(starts({verb, "--json", "--db", db, "--robot", "nobody"}).size(), 0u);
    EXPECT_EQ(starts({verb, "--json", "--db", db, "--test", "Y"}).size(), 4u);
  }
  const Outcome table = ballbar({"list", "--db", db});
  EXPECT_EQ(std::count(table.out.begin(), table.out.end(), '\n'), 17) << "a heading and one line per run\n"
                                                                      << table.out;
}

TEST_F(ToolResults, TheCsvHasTheFiguresOfTheJson) {
  const Outcome outcome = ballbar({"export", "--csv", "--db", path("a.db")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const std::vector<test::CsvRow> rows = test::parse_csv(outcome.out);
  ASSERT_EQ(rows.size(), 16u) << "one line per circle and per axis";
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const json& run = exported["runs"][i];
    SCOPED_TRACE("row " + std::to_string(i));
    EXPECT_EQ(rows[i].at("run"), run["run"]);
    EXPECT_EQ(rows[i].at("series"), run["series"]);
    EXPECT_EQ(rows[i].at("plane"), run.value("plane", ""));
    EXPECT_EQ(rows[i].at("started_us"), std::to_string(run["started_us"].get<std::int64_t>()));
    for (const char* name :
         {"ovality_um", "circular_deviation_um", "straightness_mz_um", "reversal_max_um"}) {
      if (run.value(name, json()).is_null())
        EXPECT_EQ(rows[i].at(name), "") << name;
      else
        EXPECT_EQ(std::stod(rows[i].at(name)), run[name].get<double>()) << name;
    }
  }
}

TEST_F(ToolResults, LabelsFromTheWireMayHoldAnything) {
  const std::string label = "hot, \"after\" <b>:1\n2\xff";
  test::copy_log(kDemo, path("label.lcm"), [&](test_mark_t& mark) {
    mark.series = label;
    return mark.repetition == 1 && mark.test != "B";
  });
  ASSERT_EQ(
      ballbar({"replay", path("label.lcm"), "--config", path("lrmate.toml"), "--db", path("label.db")}).code,
      0);
  const std::string shown = "hot, \"after\" <b>:1?2?";  // what is no printable UTF-8 becomes '?'
  const Outcome outcome = ballbar({"export", "--db", path("label.db")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const json runs = json::parse(outcome.out)["runs"];
  ASSERT_GT(runs.size(), 0u);
  for (const json& run : runs) EXPECT_EQ(run["series"], shown);
  const std::vector<test::CsvRow> rows =
      test::parse_csv(ballbar({"export", "--csv", "--db", path("label.db")}).out);
  ASSERT_EQ(rows.size(), runs.size());
  for (const test::CsvRow& row : rows) EXPECT_EQ(row.at("series"), shown);
  for (const char* verb : {"list", "summary", "alarms"})
    EXPECT_EQ(ballbar({verb, "--db", path("label.db")}).code, 0) << verb;
  EXPECT_EQ(ballbar({"summary", "--json", "--db", path("label.db")}).code, 0);
  EXPECT_EQ(ballbar({"show", shown + ":A+1#1", "--json", "--db", path("label.db")}).code, 0)
      << "a series with a colon";
  EXPECT_EQ(ballbar({"plot", "A+1#1", "-o", path("label.svg"), "--db", path("label.db")}).code, 0);
}

TEST_F(ToolResults, TheRecordingComesOutAsCsv) {
  const json circle = show("before-mastering:A-1#1");
  const std::vector<test::CsvRow> bar =
      test::parse_csv(ballbar({"export", "--trace", "before-mastering:A-1#1", "--db", path("a.db")}).out);
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
  const std::vector<test::CsvRow> readings =
      test::parse_csv(ballbar({"export", "--trace", "before-mastering:Y+1#1", "--db", path("a.db")}).out);
  EXPECT_EQ(readings.size(), line["samples"].get<std::size_t>());
  for (const test::CsvRow& row : readings) EXPECT_EQ(row.at("axis"), "X");
}

TEST_F(ToolResults, RecordingsComeOutAsALogWhereALogCanHoldThem) {
  const Outcome outcome = ballbar({"export", "--lcm", path("out.lcm"), "--db", path("a.db")});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("out.lcm: 16 runs, "), std::string::npos) << outcome.out;
  expect_error({"export", "--lcm", path("none.lcm"), "--series", "Z", "--db", path("a.db")}, 2,
               "no run that ended with a mark fits");
  EXPECT_FALSE(std::filesystem::exists(path("none.lcm")));
  expect_error({"export", "--lcm", path("none/x.lcm"), "--db", path("a.db")}, 3, path("none/x.lcm"));
  expect_error({"export", "--lcm", path("x.lcm"), "--csv", "--db", path("a.db")}, 2, "excludes");
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

TEST_F(ToolResults, PlotDrawsSvgAndPng) {
  const std::string db = path("a.db");
  for (const Words& runs : {Words{"before-mastering:A+1#1", "before-mastering:A-1#1"},
                            Words{"Y+1#1", "Y-1#1"}, Words{"--test", "A"}}) {
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

TEST_F(ToolResults, AlarmsOfTheRecordingAreShown) {
  const Outcome outcome = ballbar({"alarms", "--db", path("a.db")});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  const std::size_t at = outcome.out.find("ovality_drift");
  ASSERT_NE(at, std::string::npos) << outcome.out;
  const std::size_t begin = outcome.out.rfind('\n', at) + 1;
  const std::string line = outcome.out.substr(begin, outcome.out.find('\n', at) - begin);
  for (const char* word : {"firing", "warning", "lrmate-1", "A+1", "moved"})
    EXPECT_NE(line.find(word), std::string::npos) << word << ": " << line;
}

TEST_F(ToolResults, AnAlarmExplainsItself) {
  const nlohmann::json listed =
      nlohmann::json::parse(ballbar({"alarms", "--json", "--db", path("a.db")}).out);
  const auto drift =
      std::find_if(listed["alarms"].begin(), listed["alarms"].end(), [](const nlohmann::json& alarm) {
        return alarm["rule"] == "ovality_drift" && alarm["state"] == "firing";
      });
  ASSERT_NE(drift, listed["alarms"].end()) << listed;
  const std::string id = std::to_string((*drift)["id"].get<int>());
  const Outcome outcome = ballbar({"alarms", "show", id, "-o", path("alarm.svg"), "--db", path("a.db")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  for (const char* says : {"ovality_drift lrmate-1 A+1", "firing (warning) since", "drift_um", "limit_um",
                           "set in the rule", "pending -> firing", "A+1#8 production"})
    EXPECT_NE(outcome.out.find(says), std::string::npos) << says << " is not in\n" << outcome.out;

  // The numbers are those of the last bad run, and the runs are there.
  const auto& begins = (*drift)["run_started_us"];
  EXPECT_EQ(begins.size(), (*drift)["bad_runs"]);
  const auto last =
      std::find_if(exported["runs"].begin(), exported["runs"].end(),
                   [&](const nlohmann::json& run) { return run["started_us"] == begins.back(); });
  ASSERT_NE(last, exported["runs"].end());
  int compared = 0;
  for (const nlohmann::json& number : (*drift)["numbers"]) {
    const std::string name = number["name"];
    if (!last->contains(name)) continue;
    EXPECT_NEAR(number["value"].get<double>(), (*last)[name].get<double>(), 1e-9) << name;
    ++compared;
  }
  EXPECT_EQ(compared, 3) << "ovality, its cosine and its sine";
  const std::string svg = test::read_file(path("alarm.svg"));
  EXPECT_TRUE(well_formed(svg));
  EXPECT_NE(svg.find("ovality cos"), std::string::npos)
      << "the recording drifts along the cosine, not in length";
  EXPECT_NE(svg.find("runs that raised the alarm"), std::string::npos);
  expect_error({"alarms", "show", "99", "--db", path("a.db")}, 2, "no alarm 99");
}

}  // namespace
}  // namespace ballbar
