// When a series is over: another begins, nothing more comes, or all was heard.

#include "daemon/series_watch.hpp"

#include <gtest/gtest.h>

namespace ballbar {
namespace {

constexpr std::int64_t kSecond = 1'000'000;

RobotSpec robot(const std::string& name = "r") {
  RobotSpec spec;
  spec.name = name;
  for (const char* test : {"A", "B"}) {
    spec.tests.emplace_back();
    spec.tests.back().name = test;
  }
  spec.tests.emplace_back();
  spec.tests.back().name = "Y";
  spec.tests.back().kind = TestKind::kLine;
  return spec;
}

/// "robot series" of all that is due.
std::vector<std::string> due(SeriesWatch& watch, std::int64_t now_us) {
  std::vector<std::string> all;
  while (const auto ended = watch.next(now_us)) all.push_back(ended->robot + " " + ended->series);
  return all;
}

using Words = std::vector<std::string>;

TEST(SeriesWatch, AnotherSeriesEndsTheOneBefore) {
  SeriesWatch watch(100 * kSecond);
  watch.heard(robot(), "before", "A", 1, 0);
  watch.heard(robot(), "before", "A", -1, 10 * kSecond);
  EXPECT_EQ(due(watch, 20 * kSecond), Words{});
  watch.heard(robot(), "after", "A", 1, 30 * kSecond);
  EXPECT_EQ(due(watch, 30 * kSecond), Words{"r before"});
  EXPECT_EQ(due(watch, 30 * kSecond), Words{}) << "told once";
}

TEST(SeriesWatch, HeldOutCirclesBelongToTheirSeries) {
  SeriesWatch watch(100 * kSecond);
  watch.heard(robot(), "s", "A", 1, 0);
  watch.heard(robot(), "s-held-out", "B", 1, kSecond);
  EXPECT_EQ(due(watch, 2 * kSecond), Words{});
  EXPECT_EQ(due(watch, 101 * kSecond), Words{"r s"}) << "a hundred seconds after the last";
}

TEST(SeriesWatch, SilenceEndsEachRobotsByItself) {
  SeriesWatch watch(100 * kSecond);
  watch.heard(robot("a"), "s", "A", 1, 0);
  watch.heard(robot("b"), "s", "A", 1, 60 * kSecond);
  EXPECT_EQ(due(watch, 99 * kSecond), Words{});
  EXPECT_EQ(due(watch, 100 * kSecond), Words{"a s"});
  EXPECT_EQ(due(watch, 200 * kSecond), Words{"b s"});
  EXPECT_EQ(due(watch, 1000 * kSecond), Words{});
  watch.heard(robot("a"), "s", "B", 1, 2000 * kSecond);
  EXPECT_EQ(due(watch, 2100 * kSecond), Words{"a s"}) << "more of it came";
}

TEST(SeriesWatch, IsOverWhenEveryCircleWasHeardBothWaysTwice) {
  SeriesWatch watch(100 * kSecond);
  std::int64_t now = 0;
  for (int lap = 0; lap < 2; ++lap)
    for (const char* test : {"A", "B"})
      for (const int direction : {1, -1}) {
        EXPECT_EQ(due(watch, now), Words{});
        watch.heard(robot(), "s", test, direction, now += kSecond);
      }
  EXPECT_EQ(due(watch, now), Words{"r s"}) << "lines are not waited for";
  EXPECT_EQ(due(watch, now + 200 * kSecond), Words{});
  watch.heard(robot(), "s", "A", 1, now + 210 * kSecond);
  EXPECT_EQ(due(watch, now + 400 * kSecond), Words{"r s"}) << "a fifth lap is looked at too";
}

TEST(SeriesWatch, OfARobotWithLinesOnlyIsOverWhenEachWasHeardBothWaysTwice) {
  SeriesWatch watch(100 * kSecond);
  RobotSpec lines = robot();
  for (TestSpec& test : lines.tests) test.kind = TestKind::kLine;
  std::int64_t now = 0;
  for (int lap = 0; lap < 2; ++lap)
    for (const char* test : {"A", "B", "Y"})
      for (const int direction : {1, -1}) {
        EXPECT_EQ(due(watch, now), Words{}) << test << direction;
        watch.heard(lines, "s", test, direction, now += kSecond);
      }
  const auto ended = watch.next(now);
  ASSERT_TRUE(ended.has_value());
  EXPECT_EQ(ended->series, "s");
  EXPECT_EQ(ended->why, "every line was heard both ways twice");
  EXPECT_EQ(due(watch, now + 200 * kSecond), Words{}) << "told once";
}

TEST(SeriesWatch, WhatWasDiagnosedBeforeARestartIsNotDueAgain) {
  SeriesWatch watch(100 * kSecond);
  for (int lap = 0; lap < 2; ++lap)
    for (const char* test : {"A", "B"})
      for (const int direction : {1, -1}) watch.heard(robot(), "s", test, direction, 0);
  watch.diagnosed("r");
  EXPECT_EQ(due(watch, 1000 * kSecond), Words{});
}

}  // namespace
}  // namespace ballbar
