// The plot of the joints' motion: every joint told apart, and nothing to plot is an error.

#include "report/motion_plot.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <set>
#include <stdexcept>

#include "core/error.hpp"

namespace ballbar {
namespace {

MotionPlot six_joints() {
  MotionPlot plot{"lrmate-1   test A", "commanded", "angle on the circle [deg]", {}};
  for (int j = 1; j <= 6; ++j) {
    JointTrace& trace = plot.joints.emplace_back();
    trace.label = "J" + std::to_string(j);
    for (int i = 0; i < 5; ++i) {
      trace.place.push_back(90.0 * i);
      trace.angle_deg.push_back(10.0 * j + i);
    }
  }
  return plot;
}

TEST(MotionPlot, EveryJointHasAColourAndALegendOfItsOwn) {
  const std::string text = motion_script(six_joints()).text;
  std::set<std::string> styles;
  for (int j = 1; j <= 6; ++j) {
    const std::size_t title = text.find("title 'J" + std::to_string(j) + "'");
    ASSERT_NE(title, std::string::npos) << text;
    const std::size_t style = text.rfind("linecolor", title);
    styles.insert(text.substr(style, title - style));
  }
  EXPECT_EQ(styles.size(), 6u);
  EXPECT_NE(text.find("set xlabel 'angle on the circle [deg]'"), std::string::npos);
  EXPECT_NE(text.find("\n90 31\n"), std::string::npos) << "the second sample of J3";
}

TEST(MotionPlot, SamplesThatAreNotFiniteInterruptTheLine) {
  MotionPlot plot = six_joints();
  plot.joints[0].angle_deg[2] = std::numeric_limits<double>::quiet_NaN();
  EXPECT_NE(motion_script(plot).text.find("\n90 11\n\n270 13\n"), std::string::npos);
}

TEST(MotionPlot, NothingToPlotIsAnErrorAndSoAreUnequalLengths) {
  EXPECT_THROW(motion_script({}), Error);
  MotionPlot plot = six_joints();
  plot.joints[3].place.pop_back();
  EXPECT_THROW(motion_script(plot), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
