#include "files/recording.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/error.hpp"
#include "core/units.hpp"

namespace ballbar {
namespace {

/// Radius 100 mm, 360 degrees, 60 of overshoot, 50 mm/s: arc 4 pi s, each overshoot 2/3 pi s.
TestSpec circle() {
  TestSpec test;
  test.name = "A";
  test.circle.radius = 0.1;
  test.circle.arc_sweep = 2 * kPi;
  test.circle.overshoot = kPi / 3;
  test.feed = 0.05;
  return test;
}

/// 940 mm along Y.
TestSpec line() {
  TestSpec test;
  test.name = "Y";
  test.kind = TestKind::kLine;
  test.line = {{0.38, -0.47, 0}, {0.38, 0.47, 0}, 3};
  return test;
}

RecordingFacts facts(int direction = 1) {
  RecordingFacts facts;
  facts.robot = "r";
  facts.series = "s";
  facts.direction = direction;
  facts.repetition = 4;
  facts.started_us = 1'000'000;
  facts.payload = 0.4;
  facts.temperature = 21.0;
  return facts;
}

CsvReadings wave(std::size_t count, double amplitude = 10e-6) {
  CsvReadings readings;
  for (std::size_t i = 0; i < count; ++i)
    readings.deviation.push_back(amplitude * std::cos(static_cast<double>(i)));
  return readings;
}

std::string why(const std::function<void()>& action) {
  try {
    action();
  } catch (const Error& error) {
    EXPECT_EQ(error.cause(), Cause::kInput);
    return error.what();
  }
  return "nothing was wrong";
}

TEST(CircleFromFile, CarriesItsLabels) {
  const ballbar::Run run = circle_from(wave(10), circle(), facts(-1));
  EXPECT_EQ(run.robot, "r");
  EXPECT_EQ(run.test, "A");
  EXPECT_EQ(run.series, "s");
  EXPECT_EQ(run.direction, -1);
  EXPECT_EQ(run.repetition, 4);
  EXPECT_EQ(run.started_us, 1'000'000);
  EXPECT_EQ(run.end, RunEnd::kMark);
  EXPECT_EQ(run.feed, 0.05);
  EXPECT_EQ(run.payload, 0.4);
  EXPECT_EQ(run.temperature, 21.0);
  EXPECT_EQ(run.bar_deviation, wave(10).deviation);
}

TEST(CircleFromFile, WithoutTimesIsSpreadEvenlyOverTheArcOrOverAllThatWasDriven) {
  const double arc = 4 * kPi, overshoot = 2 * kPi / 3;
  for (const bool with : {false, true}) {
    RecordingFacts f = facts();
    f.with_overshoot = with;
    const ballbar::Run run = circle_from(wave(100), circle(), f);
    EXPECT_NEAR(static_cast<double>(run.ended_us - run.started_us) * 1e-6, arc + 2 * overshoot, 1e-6);
    const double step = (with ? arc + 2 * overshoot : arc) / 100;
    ASSERT_EQ(run.bar_time.size(), 100U);
    EXPECT_NEAR(run.bar_time.front(), (with ? 0 : overshoot) + step / 2, 1e-12);
    EXPECT_NEAR(run.bar_time[1] - run.bar_time[0], step, 1e-12);
    EXPECT_NEAR(run.bar_time.front() + run.bar_time.back(), arc + 2 * overshoot, 1e-12) << "in the middle";
  }
}

TEST(CircleFromFile, KeepsItsTimesAndAddsTheOvershootsThatItDoesNotHold) {
  CsvReadings readings = wave(1000);
  for (int i = 0; i < 1000; ++i) readings.time.push_back(77.0 + i * 4 * kPi / 1000);
  const ballbar::Run run = circle_from(readings, circle(), facts());
  const double whole = 4 * kPi + 4 * kPi / 3;
  EXPECT_NEAR(static_cast<double>(run.ended_us - run.started_us) * 1e-6, whole, 1e-6);
  EXPECT_NEAR(run.bar_time.front() + run.bar_time.back(), whole, 1e-9);
  for (std::size_t i = 1; i < 1000; ++i)
    EXPECT_NEAR(run.bar_time[i] - run.bar_time[i - 1], readings.time[i] - readings.time[i - 1], 1e-12);
  RecordingFacts f = facts();
  f.with_overshoot = true;
  EXPECT_NE(why([&] { circle_from(readings, circle(), f); }).find("--with-overshoot"), std::string::npos)
      << "the arc alone does not last as long as arc and overshoots";
  TestSpec no_feed = circle();
  no_feed.feed = 0.0;
  EXPECT_NEAR(circle_from(readings, no_feed, facts()).bar_time.front() + run.bar_time.back(), whole, 1e-9)
      << "no speed is needed where there are times";
}

TEST(CircleFromFile, SaysWhatIsWrong) {
  TestSpec no_feed = circle();
  no_feed.feed = 0.0;
  CsvReadings back = wave(3);
  back.time = {0, 2, 1};
  CsvReadings lengths;
  lengths.deviation = {0.1001, 0.0999, 0.1};
  struct Row {
    CsvReadings readings;
    TestSpec test;
    const char* says;
  };
  for (const Row& row :
       {Row{wave(10), no_feed, "give --feed-mm-s"}, Row{back, circle(), "do not rise at reading 3"},
        Row{lengths, circle(), "are these lengths, or is the unit wrong?"},
        Row{wave(10, 1e-8), circle(), "is the unit wrong?"}, Row{wave(1), circle(), "no circle"}}) {
    const std::string said = why([&] { circle_from(row.readings, row.test, facts()); });
    EXPECT_NE(said.find(row.says), std::string::npos) << said;
  }
}

TEST(LineFromFile, HasTheReadingsOfTheFile) {
  CsvReadings readings;
  readings.position = {0.94, 0.47, 0.0};
  readings.deviation = {1e-6, 2e-6, 3e-6};
  readings.time = {100, 101, 103};
  const ballbar::Run run = line_from(readings, line(), facts(-1), 'Z');
  ASSERT_EQ(run.readings.size(), 3U);
  EXPECT_EQ(run.kind, TestKind::kLine);
  EXPECT_EQ(run.readings[1].axis, 'Z');
  EXPECT_EQ(run.readings[1].time, 1.0);
  EXPECT_EQ(run.readings[1].position, 0.47);
  EXPECT_EQ(run.readings[1].deviation, 2e-6);
  EXPECT_EQ(run.ended_us, run.started_us + 3'000'000);
  readings.axis = {'X', 'X', 'Y'};
  EXPECT_EQ(line_from(readings, line(), facts(-1), 'Z').readings[2].axis, 'Y') << "the file knows better";
}

TEST(LineFromFile, SaysWhatIsWrong) {
  CsvReadings good;
  good.position = {0.0, 0.47, 0.94};
  good.deviation = {1e-6, 2e-6, 3e-6};
  CsvReadings nowhere = good, in_metres = good, falls = good;
  nowhere.position.clear();
  for (double& p : in_metres.position) p *= 1e-3;
  falls.time = {0, 2, 1};
  EXPECT_NE(why([&] { line_from(nowhere, line(), facts(), 'X'); }).find("positions are not known"),
            std::string::npos);
  EXPECT_NE(why([&] { line_from(good, line(), facts(), '\0'); }).find("give --axis"), std::string::npos);
  EXPECT_NE(why([&] { line_from(in_metres, line(), facts(), 'X'); }).find("span 0.94 mm"), std::string::npos);
  EXPECT_NE(why([&] { line_from(good, line(), facts(-1), 'X'); }).find("rise, but the direction is backward"),
            std::string::npos);
  EXPECT_NE(why([&] { line_from(falls, line(), facts(), 'X'); }).find("times fall at reading 3"),
            std::string::npos);
}

TEST(PlaneOfAFile, TurnsAsTheNormalOfTheCircle) {
  CircleSpec spec;
  spec.normal = {0, 0, 1};
  EXPECT_EQ(sense_of("XY", spec), 1);
  spec.normal = {0, 0, -1};
  EXPECT_EQ(sense_of("XY", spec), -1);
  spec.normal = {1, 0, 0};
  EXPECT_EQ(sense_of("YZ", spec), 1);
  spec.normal = {0, 1, 0};
  EXPECT_EQ(sense_of("ZX", spec), 1);
  EXPECT_NE(why([&] { sense_of("XY", spec); }).find("lies in another"), std::string::npos);
  EXPECT_NE(why([&] { sense_of("UV", spec); }).find("neither XY, YZ nor ZX"), std::string::npos);
}

}  // namespace
}  // namespace ballbar
