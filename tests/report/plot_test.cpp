#include "report/plot.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>
#include <stdexcept>

#include "core/error.hpp"

namespace ballbar {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

PolarTrace ellipse(const std::string& label, int direction, double amplitude_um) {
  PolarTrace trace{label, direction, {}, {}};
  for (int i = 0; i < 72; ++i) {
    const double angle = 2.0 * std::numbers::pi * i / 72.0;
    trace.angle_rad.push_back(angle);
    trace.deviation_um.push_back(amplitude_um * std::cos(2.0 * angle));
  }
  return trace;
}

std::size_t count_of(const std::string& text, const std::string& word) {
  std::size_t hits = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + word.size()))
    ++hits;
  return hits;
}

bool svg_holds(const std::string& text, const std::string& word) {
  return text.find(word) != std::string::npos;
}

TEST(Scale, IsTheSmallestOneTwoFiveStepThatHoldsTheLargestDeviation) {
  struct Row {
    double largest_um, scale;
  };
  for (const Row& row :
       {Row{0.0, 0.1}, Row{0.4, 0.1}, Row{0.41, 0.2}, Row{0.9, 0.5}, Row{3.9, 1}, Row{4.0, 1}, Row{4.1, 2},
        Row{8.1, 5}, Row{20.1, 10}, Row{63.0, 20}, Row{199.0, 50}, Row{1500.0, 500}})
    EXPECT_DOUBLE_EQ(scale_um_per_division(row.largest_um, 4), row.scale)
        << "largest " << row.largest_um << " um";
}

TEST(Scale, RefusesWhatIsNotASize) {
  EXPECT_THROW(scale_um_per_division(kNan, 4), std::invalid_argument);
  EXPECT_THROW(scale_um_per_division(-1.0, 4), std::invalid_argument);
  EXPECT_THROW(scale_um_per_division(1.0, 0), std::invalid_argument);
}

TEST(PolarScript, SaysScaleTitleDirectionsAndAngles) {
  const PlotScript script = polar_script({.title = "lrmate-1   test A",
                                          .subtitle = "before   2026-03-11",
                                          .traces = {ellipse("A+1#1", 1, 31), ellipse("A-1#1", -1, 29)},
                                          .notes = {"ovality 62.0 µm"}});
  for (const char* word :
       {"lrmate-1   test A", "before   2026-03-11", "'10 µm/div'", "'A+1#1   counter-clockwise'",
        "'A-1#1   clockwise'", "'0°'", "'330°'", "'+40'", "'−40'", "'ovality 62.0 µm'"})
    EXPECT_TRUE(svg_holds(script.text, word)) << word;
  EXPECT_GT(script.width, 0);
  EXPECT_GT(script.height, script.width) << "legend and notes stand below a square drawing";
}

TEST(PolarScript, DrawsADeviationOutsideTheNominalCircleAtItsAngle) {
  // 4 um at 90 degrees is 1 um/div: four divisions above the nominal circle, which is drawn at six.
  const PlotScript script = polar_script(
      {.traces = {
           {.label = "t", .direction = 1, .angle_rad = {std::numbers::pi / 2}, .deviation_um = {4.0}}}});
  EXPECT_TRUE(svg_holds(script.text, "$trace0 << EOD\n0 10\nEOD\n")) << script.text;
}

TEST(PolarScript, TellsTheDirectionsApartByColourAndByDash) {
  const std::string text = polar_script({.traces = {ellipse("a", 1, 5), ellipse("b", -1, 5)}}).text;
  EXPECT_TRUE(svg_holds(text, "rgb '#0072B2' linewidth 1.8 dashtype solid title 'a "));
  EXPECT_TRUE(svg_holds(text, "rgb '#D55E00' linewidth 1.8 dashtype (14,5) title 'b "));
}

TEST(PolarScript, ListsABundleOnce) {
  PolarPlot plot;
  for (int i = 0; i < 5; ++i) plot.traces.push_back(ellipse("A+1#" + std::to_string(i), 1, 5));
  const std::string text = polar_script(plot).text;
  EXPECT_EQ(count_of(text, "'counter-clockwise (5 runs)'"), 1U);
  EXPECT_EQ(count_of(text, "notitle"), 4U);
  EXPECT_FALSE(svg_holds(text, "A+1#"));
}

TEST(PolarScript, InterruptsTheLineWhereASampleIsNotFinite) {
  const PlotScript script = polar_script({.traces = {{.label = "t",
                                                      .direction = 1,
                                                      .angle_rad = {0.0, 0.1, kNan, 0.0},
                                                      .deviation_um = {0.0, kNan, 1.0, 0.1}}}});
  EXPECT_TRUE(svg_holds(script.text, "EOD\n6 0\n\n\n7 0\nEOD\n")) << script.text;
}

TEST(PolarScript, LeavesOutATraceWithoutAnyAngle) {
  PolarTrace blind = ellipse("blind", -1, 5);
  for (double& angle : blind.angle_rad) angle = kNan;
  const std::string text = polar_script({.traces = {blind, ellipse("seen", 1, 5)}}).text;
  EXPECT_FALSE(svg_holds(text, "blind"));
  EXPECT_TRUE(svg_holds(text, "seen"));
  EXPECT_THROW(polar_script({.traces = {blind}}), Error);
  EXPECT_THROW(polar_script({}), Error);
}

TEST(PolarScript, RefusesATraceWithoutOneDeviationPerAngle) {
  PolarTrace trace = ellipse("t", 1, 5);
  trace.deviation_um.pop_back();
  EXPECT_THROW(polar_script({.traces = {trace}}), std::invalid_argument);
}

TEST(PolarScript, WritesLongWordsSmallerSoThatTheyFit) {
  const auto title_line = [](std::size_t length) {
    const std::string text =
        polar_script({.title = std::string(length, 'x'), .traces = {ellipse("a", 1, 5)}}).text;
    const std::size_t begin = text.find("'x");
    return text.substr(begin, text.find('\n', begin) - begin);
  };
  EXPECT_TRUE(svg_holds(title_line(20), "font ',22'"));
  EXPECT_TRUE(svg_holds(title_line(80), "font ',17'"));
  EXPECT_TRUE(svg_holds(title_line(150), "font ',9'"));
}

TEST(LineScript, ShowsDeviationOverPositionForwardAndBackward) {
  const PlotScript script = line_script(
      {.title = "lrmate-1   test Y",
       .axis = "X",
       .traces = {{.label = "Y+1#1", .direction = 1, .position_mm = {0, 18.8}, .deviation_um = {1.5, -2.25}},
                  {.label = "Y-1#1", .direction = -1, .position_mm = {0, 18.8}, .deviation_um = {0, kNan}}}});
  for (const char* word :
       {"$trace0 << EOD\n0 1.5\n18.8 -2.25\nEOD\n", "$trace1 << EOD\n0 0\n\nEOD\n", "'X deviation [µm]'",
        "'position along the line [mm]'", "'Y+1#1   forward'", "'Y-1#1   backward'",
        "pointtype 7 linecolor rgb '#0072B2'", "pointtype 4 linecolor rgb '#D55E00'"})
    EXPECT_TRUE(svg_holds(script.text, word)) << word;
}

TEST(LineScript, RefusesWhatHoldsNoReadings) {
  EXPECT_THROW(line_script({}), Error);
  EXPECT_THROW(
      line_script({.traces = {{.label = "t", .direction = 1, .position_mm = {1.0}, .deviation_um = {}}}}),
      std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
