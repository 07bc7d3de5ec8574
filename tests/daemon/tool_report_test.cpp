// Pictures of every kind, the report as a browser shows and prints it, and two series side by side.

#include <gtest/gtest.h>

#include <cmath>
#include <regex>

#include "support/browser.hpp"
#include "support/lcm_log.hpp"
#include "support/tool_test.hpp"

namespace ballbar {
namespace {

using nlohmann::json;
using test::ballbar;
using test::kDemo;
using test::Outcome;
using test::read_file;
using test::Words;

bool holds(const std::string& text, const std::string& word) { return text.find(word) != std::string::npos; }

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t hits = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + word.size()))
    ++hits;
  return hits;
}

class ToolReport : public test::ToolTest {
 protected:
  static std::string svg(Words words) {
    words.insert(words.begin(), "plot");
    words.insert(words.end(), {"-o", path("p.svg"), "--db", path("a.db")});
    const Outcome outcome = ballbar(words);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.err, "");
    return outcome.code == 0 ? read_file(path("p.svg")) : "";
  }
  static std::string page(Words words, const std::string& db = "a.db") {
    words.insert(words.end(), {"-o", path("p.html"), "--db", path(db)});
    const Outcome outcome = ballbar(words);
    EXPECT_EQ(outcome.code, 0) << outcome.err;
    EXPECT_EQ(outcome.out + outcome.err, "");
    return outcome.code == 0 ? read_file(path("p.html")) : "";
  }
};

TEST_F(ToolReport, EveryKindOfPictureSaysWhatItShows) {
  struct Row {
    Words words;
    Words says;
  };
  for (const Row& row : {
           Row{{"--kind", "polar", "--series", "production"}, {"counter-clockwise (8 runs)", "µm/div"}},
           Row{{"--test", "A"}, {"before-mastering", "after-mastering   clockwise", "production"}},
           Row{{"--kind", "line"}, {"position along the line [mm]", "X deviation [µm]", "minimum zone"}},
           Row{{"--kind", "harmonics", "--test", "A"}, {"order of the harmonic", "amplitude [µm]"}},
           Row{{"--kind", "ovality", "--test", "A"}, {"ovality vector, cosine part [µm]", "95 %"}},
           Row{{"--kind", "trend", "--test", "A"}, {"ovality [µm]", "begin of the run (UTC)", "production"}},
           Row{{"--kind", "trend", "--quantity", "harmonic3_um", "--by-run", "--limit-um", "20", "35"},
               {"harmonic3 [µm]", "run, in sequence", "limit 20", "limit 35"}},
           Row{{"--kind", "trend", "--test", "A", "--config", path("lrmate.toml")},
               {"limit 150", "limit 150: rule ovality_high"}},
           Row{{"--kind", "trend", "--test", "Y", "--config", path("lrmate.toml")},
               {"limit 600: rule straightness_high"}},
           Row{{"--kind", "trend", "--quantity", "temperature_c", "--limit", "4"}, {"temperature [°C]"}},
           Row{{"--kind", "trend", "--quantity", "slope_um_per_m"}, {"slope [µm/m]", "X   forward"}},
       }) {
    std::string command;
    for (const std::string& word : row.words) command += word + " ";
    SCOPED_TRACE(command);
    const std::string picture = svg(row.words);
    for (const std::string& word : row.says) EXPECT_TRUE(holds(picture, word)) << word;
  }
}

TEST_F(ToolReport, PicturesThatCannotBeAreRefused) {
  const std::string db = path("a.db");
  const std::string out = path("no.svg");
  expect_error({"plot", "-o", out, "--db", db}, 2, "circles and lines");
  expect_error({"plot", "--kind", "line", "--test", "A", "-o", out, "--db", db}, 2,
               "no line among these runs");
  expect_error({"plot", "--kind", "trend", "--quantity", "beauty_um", "-o", out, "--db", db}, 2,
               "'beauty_um'");
  expect_error(
      {"plot", "--kind", "trend", "--quantity", "ovality_axis_deg", "--limit-um", "4", "-o", out, "--db", db},
      2, "--limit-um");
  expect_error(
      {"plot", "--kind", "trend", "--quantity", "reversal_max_um", "--test", "A", "-o", out, "--db", db}, 2,
      "none of these runs gives reversal_max_um");
  expect_error({"plot", "--test", "A", "--limit-um", "4", "-o", out, "--db", db}, 2, "--kind trend");
  expect_error({"plot", "--test", "A", "--axis", "X", "-o", out, "--db", db}, 2, "--axis is for lines");
  expect_error({"report", "--series", "nobody", "-o", path("no.html"), "--db", db}, 2, "nothing to report");
  expect_error(
      {"report", "--series", "production", "--baseline", "nobody", "-o", path("no.html"), "--db", db}, 2,
      "baseline 'nobody'");
  expect_error({"report", "--series", "production", "-o", path("no.pdf"), "--db", db}, 2, ".html");
  expect_error({"report", "--series", "production", "-o", path("no/where.html"), "--db", db}, 3,
               "cannot be written");
  expect_error({"compare", "--series", "production", "--db", db}, 2, "two series");
  expect_error({"compare", "--series", "production", "--series", "production", "--db", db}, 2, "two series");
  expect_error({"compare", "--series", "production", "--series", "nobody", "--db", db}, 2, "'nobody'");
  EXPECT_FALSE(std::filesystem::exists(out));
}

TEST_F(ToolReport, TheReportHoldsConditionsFiguresPicturesChangesAndAlarms) {
  const std::string report = page({"report", "--series", "production"});
  for (const char* word :
       {"At a glance", "Alarms", "Pictures", "What changed against the baseline", "Figures",
        "Measured against predicted", "Conditions", "before: series before-mastering", "ovality_drift",
        "firing", "smallest distance of two concentric circles", "55.33", ">XY</td>",
        "path repeatability RT µm", "covariance over the runs"})
    EXPECT_TRUE(holds(report, word)) << word;
  EXPECT_FALSE(holds(report, "not causes")) << "this series was driven one way only";
  const std::string both = page({"report", "--series", "after-mastering"});
  for (const char* word : {"shapes, not causes", "along the radius from the base&#39;s axis", "squareness",
                           "pose repeatability RP, largest µm", "circular error without it µm"})
    EXPECT_TRUE(holds(both, word)) << word;
  EXPECT_EQ(count(report, "<figure>"), count(report, "</svg>"));
  EXPECT_GE(count(report, "<figure>"), 5U);
  for (const char* word : {"<script", "http-equiv=\"refresh\"", "@import", "src="})
    EXPECT_FALSE(holds(report, word)) << word;
  std::string rest = report;  // the only addresses are the names of SVG's own namespaces
  for (const char* known : {"http://www.w3.org/2000/svg", "http://www.w3.org/1999/xlink"})
    for (std::size_t at = rest.find(known); at != std::string::npos; at = rest.find(known))
      rest.erase(at, std::string(known).size());
  EXPECT_FALSE(holds(rest, "://"));

  std::map<std::string, int> ids;
  const std::regex id(" id=['\"]([^'\"]*)['\"]");
  for (std::sregex_iterator it(report.begin(), report.end(), id), end; it != end; ++it) ++ids[(*it)[1]];
  EXPECT_GT(ids.size(), 50U);
  for (const auto& [name, times] : ids) EXPECT_EQ(times, 1) << name << " must be one thing in the page";
}

TEST_F(ToolReport, RunsWithoutFiguresAreNamedWithTheReason) {
  test::copy_log(kDemo, path("short.lcm"), [&](test_mark_t& mark) {
    if (mark.mark == 2 && mark.repetition == 1) mark.mark = 3;
    return true;
  });
  ASSERT_EQ(
      ballbar({"replay", path("short.lcm"), "--config", path("lrmate.toml"), "--db", path("short.db")}).code,
      0);
  const std::string report = page({"report"}, "short.db");
  EXPECT_TRUE(holds(report, "Runs that give no figures"));
  EXPECT_TRUE(holds(report, "<td>aborted</td>"));
  EXPECT_TRUE(holds(report, "<td>A+1#1</td>"));
}

TEST_F(ToolReport, CirclesOfBarAndOfJointsAreNotMixed) {
  // The bar comes with the fifth circle of the series "production".
  lcm::LogFile in(kDemo, "r");
  {
    lcm::LogFile out(path("both.lcm"), "w");
    bool bar = true;
    while (const lcm::LogEvent* event = in.readNextEvent()) {
      if (event->channel == "TEST_MARK") {
        test_mark_t mark;
        ASSERT_GE(mark.decode(event->data, 0, event->datalen), 0);
        bar = mark.series != "production" || mark.repetition > 4;
      }
      lcm::LogEvent copy = *event;
      if (bar || event->channel != "BALLBAR") out.writeEvent(&copy);
    }
  }
  ASSERT_EQ(
      ballbar({"replay", path("both.lcm"), "--config", path("lrmate.toml"), "--db", path("both.db")}).code,
      0);
  const Outcome outcome = ballbar({"compare", "--series", "before-mastering", "--series", "production",
                                   "--json", "--db", path("both.db")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const json circles = json::parse(outcome.out)["circles"];
  ASSERT_EQ(circles.size(), 1U) << "before mastering there were no circles of joints";
  EXPECT_EQ(circles[0]["source"], "bar");
  EXPECT_EQ(circles[0]["runs_after"], 4);
  const std::string report = page({"report", "--series", "production"}, "both.db");
  for (const char* word : {"series production   from joints", "from bar   counter-clockwise (4 runs)",
                           "from joints   counter-clockwise (4 runs)"})
    EXPECT_TRUE(holds(report, word)) << word;
}

TEST_F(ToolReport, NamesFromOutsideStayText) {
  const std::string label = "</title><script>alert(1)</script><img src=x onerror='alert(2)'> & \"q\" ]]>";
  test::copy_log(kDemo, path("hostile.lcm"), [&](test_mark_t& mark) {
    mark.series = mark.series == "production" ? label : "first";
    return true;
  });
  ASSERT_EQ(
      ballbar({"replay", path("hostile.lcm"), "--config", path("lrmate.toml"), "--db", path("hostile.db")})
          .code,
      0);
  for (const Words& words : {Words{"report"}, Words{"compare", "--series", "first", "--series", label}}) {
    SCOPED_TRACE(words[0]);
    const std::string text = page(words, "hostile.db");
    EXPECT_FALSE(holds(text, "<script"));
    EXPECT_FALSE(holds(text, "<img"));
    EXPECT_TRUE(holds(text, "&lt;script&gt;alert(1)&lt;/script&gt;"));
  }
}

TEST_F(ToolReport, TheComparisonIsOfMeansOverTheRuns) {
  const Outcome outcome = ballbar(
      {"compare", "--series", "before-mastering", "--series", "production", "--json", "--db", path("a.db")});
  ASSERT_EQ(outcome.code, 0) << outcome.err;
  const json comparison = json::parse(outcome.out);
  ASSERT_EQ(comparison["circles"].size(), 1U) << "production ran A counter-clockwise only";
  const json& circle = comparison["circles"][0];
  EXPECT_EQ(circle["test"], "A");
  EXPECT_EQ(circle["direction"], 1);
  // By hand, from the runs as exported.
  for (const char* side : {"before", "after"}) {
    const std::string series = std::string(side) == "before" ? "before-mastering" : "production";
    std::vector<json> runs;
    for (const json& run : exported["runs"])
      if (run["series"] == series && run["test"] == "A" && run["direction"] == 1) runs.push_back(run);
    ASSERT_EQ(circle[std::string("runs_") + side], runs.size());
    for (const json& h : circle["harmonics"]) {
      double cos = 0, sin = 0, amplitude = 0;
      for (const json& run : runs) {
        const json& one = run["harmonics"][h["order"].get<std::size_t>() - 1];
        cos += one["cos_um"].get<double>() / runs.size();
        sin += one["sin_um"].get<double>() / runs.size();
        amplitude += one["amplitude_um"].get<double>() / runs.size();
      }
      EXPECT_NEAR(h[std::string(side) + "_vector_um"][0], cos, 1e-9);
      EXPECT_NEAR(h[std::string(side) + "_vector_um"][1], sin, 1e-9);
      EXPECT_NEAR(h[std::string(side) + "_mean_amplitude_um"], amplitude, 1e-9);
      EXPECT_NEAR(h["moved_um"],
                  std::hypot(h["after_vector_um"][0].get<double>() - h["before_vector_um"][0].get<double>(),
                             h["after_vector_um"][1].get<double>() - h["before_vector_um"][1].get<double>()),
                  1e-9);
    }
    for (const json& figure : circle["figures"]) {
      double mean = 0;
      for (const json& run : runs)
        mean += run[figure["quantity"].get<std::string>()].get<double>() / runs.size();
      EXPECT_NEAR(figure[side], mean, 1e-9) << figure["quantity"];
    }
  }
  EXPECT_EQ(circle["harmonics"].size(), 10U);
  EXPECT_GE(circle["figures"].size(), 10U);

  const Outcome text = ballbar(
      {"compare", "--series", "before-mastering", "--series", "after-mastering", "--db", path("a.db")});
  EXPECT_EQ(text.code, 0);
  for (const char* word :
       {"before: before-mastering   after: after-mastering", "test A   counter-clockwise", "moved vector µm",
        "circular deviation [µm]", "test Y   deviation along X", "straightness mz [µm]"})
    EXPECT_TRUE(holds(text.out, word)) << word << " in\n" << text.out;
}

TEST_F(ToolReport, ABrowserShowsAndPrintsTheReport) {
  if (!test::has_program("chromium") || !test::has_program("pdftotext"))
    GTEST_SKIP() << "chromium and poppler-utils are not installed: scripts/setup";
  page({"report", "--series", "production"});
  const Outcome shown = test::chromium({"--dump-dom"}, path("p.html"));
  ASSERT_EQ(shown.code, 0) << shown.err;
  for (const char* word :
       {"<title>lrmate-1   production</title>", "Measured against predicted", "</svg>", "</html>"})
    EXPECT_TRUE(holds(shown.out, word)) << word;
  EXPECT_FALSE(holds(shown.err, "CONSOLE")) << "the page has something to complain about:\n" << shown.err;

  const Outcome printed =
      test::chromium({"--no-pdf-header-footer", "--print-to-pdf=" + path("p.pdf")}, path("p.html"));
  ASSERT_EQ(printed.code, 0) << printed.err;
  const Outcome text = test::run({"pdftotext", "-layout", path("p.pdf"), "-"});
  ASSERT_EQ(text.code, 0) << text.err;
  for (const char* word :
       {"At a glance", "ovality_drift", "µm/div", "order of the harmonic", "run, in sequence", "Conditions"})
    EXPECT_TRUE(holds(text.out, word)) << word << " in\n" << text.out;
}

}  // namespace
}  // namespace ballbar
