#include "metrology/line.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>

namespace ballbar {
namespace {

std::vector<InterferometerReading> readings(double step, const std::vector<double>& deviation_um) {
  std::vector<InterferometerReading> run;
  for (std::size_t i = 0; i < deviation_um.size(); ++i)
    run.push_back({'X', 0.1 * static_cast<double>(i), step * static_cast<double>(i), deviation_um[i] * 1e-6});
  return run;
}

TEST(Line, HasTheFiguresOfTheManualOfTheHp5528aForItsFirstAxis) {
  // metrology.md 1.3: positions in steps of 0.1 m.
  const auto line = analyse_line(readings(0.1, {-0.3, 0.9, 1.5, 2.5, 2.9, 3.6, 4.2, 5.1, 5.9, 7.2}));
  ASSERT_TRUE(line);
  EXPECT_NEAR(line->slope_ls * 1e6, 7.6545, 0.00005);
  EXPECT_NEAR(line->straightness_ls * 1e6, 0.7036, 0.00005);
  EXPECT_NEAR(line->straightness_ep * 1e6, 0.8667, 0.00005);
  EXPECT_NEAR(line->straightness_mz * 1e6, 0.6500, 0.00005);
}

TEST(Line, HasTheFiguresOfTheManualOfTheHp5528aForItsSecondAxis) {
  const auto line =
      analyse_line(readings(0.05, {-0.5, -1.2, -2.5, -3.8, -4.0, -4.8, -5.9, -6.2, -7.4, -8.8}));
  ASSERT_TRUE(line);
  EXPECT_NEAR(line->slope_ls * 1e6, -17.4182, 0.00005);
  EXPECT_NEAR(line->straightness_ls * 1e6, 1.0836, 0.00005);
  EXPECT_NEAR(line->straightness_ep * 1e6, 1.2889, 0.00005);
  EXPECT_NEAR(line->straightness_mz * 1e6, 0.9333, 0.00005);
}

TEST(Line, TakesTheMeanOfTheReadingsAtAPositionInAnySequence) {
  std::vector<InterferometerReading> run = readings(0.1, {0, 1, 2, 0});
  run.push_back({'X', 9.0, 0.1 + 0.5e-6, 5e-6});  // half a micrometre off: the same point
  run.push_back({'X', 9.1, 0.2 + 2e-6, 7e-6});    // two: another one
  std::reverse(run.begin(), run.end());
  const auto line = analyse_line(run);
  ASSERT_TRUE(line);
  EXPECT_EQ(line->axis, 'X');
  ASSERT_EQ(line->points.size(), 5U);
  EXPECT_NEAR(line->points[1].deviation, 3e-6, 1e-18);
  EXPECT_NEAR(line->points[2].deviation, 2e-6, 1e-18);
  EXPECT_NEAR(line->points[3].deviation, 7e-6, 1e-18);
  for (std::size_t i = 1; i < 5; ++i) EXPECT_LT(line->points[i - 1].position, line->points[i].position);
}

TEST(Line, IsNotFoundWithFewerThanThreePositions) {
  EXPECT_FALSE(analyse_line({}));
  EXPECT_FALSE(analyse_line(readings(0.1, {1, 2})));
  EXPECT_FALSE(analyse_line(readings(1e-8, {1, 2, 3, 4}))) << "all at one place";
  EXPECT_TRUE(analyse_line(readings(0.1, {1, 2, 1})));
}

TEST(Line, RefusesMixedAxesAndReadingsThatAreNotFinite) {
  std::vector<InterferometerReading> run = readings(0.1, {1, 2, 3});
  run[1].axis = 'Z';
  EXPECT_THROW(analyse_line(run), std::invalid_argument);
  run[1].axis = 'X';
  run[2].deviation = std::numeric_limits<double>::quiet_NaN();
  EXPECT_THROW(analyse_line(run), std::invalid_argument);
}

TEST(Reversal, IsForwardMinusBackwardFromWhicheverSideItIsAsked) {
  LineResult forward = *analyse_line(readings(0.1, {10, 20, 30, 40}));
  LineResult backward = *analyse_line(readings(0.1, {11, 17, 39, 40}));
  add_reversal(forward, 1, backward.points);
  add_reversal(backward, -1, forward.points);
  for (const LineResult* line : {&forward, &backward}) {
    EXPECT_NEAR(line->points[0].reversal.value(), -1e-6, 1e-18);
    EXPECT_NEAR(line->points[1].reversal.value(), 3e-6, 1e-18);
    EXPECT_NEAR(line->reversal_max.value(), -9e-6, 1e-18) << "the largest by size keeps its sign";
    EXPECT_NEAR(line->reversal_mean.value(), -7e-6 / 4, 1e-18);
  }
}

TEST(Reversal, IsGivenOnlyWhereBothWaysHaveAReading) {
  LineResult line = *analyse_line(readings(0.1, {1, 2, 3, 4}));
  std::vector<LinePoint> other = {
      {0.0 + 0.9e-6, 0.0, {}}, {0.15, 9e-6, {}}, {0.2 + 3e-6, 0.0, {}}, {0.3, 0.0, {}}};
  add_reversal(line, 1, other);
  EXPECT_TRUE(line.points[0].reversal);
  EXPECT_FALSE(line.points[1].reversal);
  EXPECT_FALSE(line.points[2].reversal);
  EXPECT_TRUE(line.points[3].reversal);
  EXPECT_NEAR(line.reversal_mean.value(), 2.5e-6, 1e-18);
}

TEST(Reversal, IsAbsentWithoutADirectionOrAPartner) {
  LineResult line = *analyse_line(readings(0.1, {1, 2, 3}));
  const LineResult partner = line;
  add_reversal(line, 0, partner.points);
  EXPECT_FALSE(line.reversal_max);
  add_reversal(line, 1, {});
  EXPECT_FALSE(line.reversal_max);
  EXPECT_FALSE(line.reversal_mean);
}

TEST(LineBundle, OfOneWayOnlyHasNoReversal) {
  const LineResult run = *analyse_line(readings(0.1, {1, 2, 1, 3}));
  const LineBundle bundle = analyse_line_bundle({run.points, run.points}, {});
  ASSERT_TRUE(bundle.all_runs && bundle.forward);
  EXPECT_NEAR(bundle.all_runs->mz, run.straightness_mz, 1e-18);
  EXPECT_FALSE(bundle.backward);
  EXPECT_FALSE(bundle.reversal_max);
}

}  // namespace
}  // namespace ballbar
