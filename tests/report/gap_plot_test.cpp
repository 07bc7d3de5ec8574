// A diagnosis in pictures: what stands in which panel, and that gnuplot draws it.

#include "report/gap_plot.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/error.hpp"

namespace ballbar {
namespace {

GapTrace trace(const std::string& label, int direction, double before) {
  GapTrace one{label, direction, {}, {}, {}, {}};
  for (int i = 0; i < 360; ++i) {
    const double angle = direction > 0 ? i : 359 - i;
    one.place.push_back(angle);
    one.measured_um.push_back(30.0 * std::sin(2 * std::numbers::pi * angle / 180.0));
    one.before_um.push_back(one.measured_um.back() - before);
    one.after_um.push_back(one.measured_um.back() - 0.5);
  }
  return one;
}

std::size_t count(const std::string& text, const std::string& word) {
  std::size_t found = 0;
  for (std::size_t at = text.find(word); at != std::string::npos; at = text.find(word, at + 1)) ++found;
  return found;
}

TEST(GapPictures, MapHasARowPerCircleInTheColoursOfTheLargestGap) {
  const GapPlot plot{"robot", "series", {trace("A+1", 1, 20.0), trace("B'-1\n", -1, -8.0)}, {"note"}};
  const std::string text = gap_map_script(plot).text;
  EXPECT_NE(text.find("set cbrange [-20:20]"), std::string::npos) << "one scale, before and after";
  std::string row;
  for (int i = 0; i < 72; ++i) row += "20 ";
  EXPECT_EQ(count(text, row + "\n"), 1u) << "5 degrees each, mean of what lies there";
  row.clear();
  for (int i = 0; i < 72; ++i) row += "0.5 ";
  EXPECT_EQ(count(text, row + "\n"), 2u) << "after: both circles";
  const std::string svg = svg_of(gap_map_script(plot));
  EXPECT_NE(svg.find("with what was left out"), std::string::npos);
}

TEST(GapPictures, MapLeavesOpenWhatAPartialArcDoesNotCover) {
  GapTrace half = trace("A+1", 1, 20.0);
  for (auto* values : {&half.place, &half.measured_um, &half.before_um, &half.after_um}) values->resize(180);
  EXPECT_EQ(count(gap_map_script({"r", "", {half}, {}}).text, "NaN"), 72u) << "36 bins, before and after";
}

TEST(GapPictures, TracesShareOneScaleAndAllAreDrawn) {
  const GapPlot plot{"robot", "A", {trace("A+1", 1, 20.0), trace("A-1", -1, 20.0)}, {}};
  const PlotScript script = gap_traces_script(plot);
  EXPECT_EQ(count(script.text, "set yrange"), 1u);
  const std::string svg = svg_of(script);
  for (const char* word : {"A+1", "A-1", "measured", "predicted by the model as configured"})
    EXPECT_NE(svg.find(word), std::string::npos) << word;
}

TEST(GapPictures, SharesStandInPercentBesideTheirNames) {
  const std::string svg = svg_of(
      gap_shares_script("r", "s", {{"joint_lost_motion J2", 0.83, 18.0}, {"servo_lag J3", 0.17, 8.0}}));
  for (const char* word : {"joint_lost_motion J2", "83 %", "18.0 µm", "17 %"})
    EXPECT_NE(svg.find(word), std::string::npos) << word;
}

TEST(GapPictures, OfNothingAreRefused) {
  EXPECT_THROW(gap_map_script({"r", "", {}, {}}), Error);
  EXPECT_THROW(gap_traces_script({"r", "", {}, {}}), Error);
  EXPECT_THROW(gap_shares_script("r", "", {}), Error);
  GapTrace bad = trace("A+1", 1, 1.0);
  bad.after_um.pop_back();
  EXPECT_THROW(gap_map_script({"r", "", {bad}, {}}), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
