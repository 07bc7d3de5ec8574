// Paths of a tool point, and which of them are a configured circle: every way a path may begin, turn, stop
// and end. The paths are drawn by school geometry; what must come out is written beside them.

#include "metrology/recogniser.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>
#include <string>

namespace ballbar {
namespace {

using Eigen::Isometry3d;
using Eigen::Vector3d;

constexpr std::int64_t kT0 = 1'700'000'000'000'000;

CircleToRecognise circle_of(double arc_start_deg = 0.0, double sweep_deg = 360.0, double overshoot_deg = 60.0,
                            double radius = 0.1) {
  CircleToRecognise test;
  test.circle.centre = {0.4, -0.3, 0.2};
  test.circle.radius = radius;
  test.circle.arc_start = arc_start_deg * kRadPerDeg;
  test.circle.arc_sweep = sweep_deg * kRadPerDeg;
  test.circle.overshoot = overshoot_deg * kRadPerDeg;
  return test;
}

/// A pen that draws at 125 Hz; positions in the frame of the circles' centre.
class Pen {
 public:
  explicit Pen(std::vector<CircleToRecognise> tests) : recogniser(std::move(tests)) {}

  void point(const Vector3d& p) {
    Isometry3d pose = Isometry3d::Identity();
    pose.linear() = tool;
    pose.translation() = Vector3d(0.4, -0.3, 0.2) + p + Vector3d(0.0, 0.0, noise ? noise() : 0.0);
    recogniser.take(now_us(), pose, found);
    time_s += step_s;
    here = p;
  }
  void arc(
      double from_deg, double to_deg, double feed = 0.05, double radius = 0.1,
      const std::function<Vector3d(double)>& off = [](double) { return Vector3d::Zero(); }) {
    const double from = from_deg * kRadPerDeg;
    const double sweep = (to_deg - from_deg) * kRadPerDeg;
    const int steps = std::max(1, static_cast<int>(std::ceil(std::abs(sweep) * radius / feed / step_s)));
    for (int i = 0; i <= steps; ++i) {
      const double a = from + sweep * i / steps;
      const double r = radius + (noise ? noise() : 0.0);
      point(Vector3d(r * std::cos(a), r * std::sin(a), 0.0) + off(a));
    }
  }
  void to(const Vector3d& end, double feed = 0.05) {
    const Vector3d begin = here;
    const int steps = static_cast<int>(std::ceil((end - begin).norm() / feed / step_s));
    for (int i = 1; i <= steps; ++i) point(begin + (end - begin) * i / steps);
  }
  void rest(double seconds) {
    for (const double end = time_s + seconds; time_s < end;) point(here);
  }
  void silence(double seconds) { time_s += seconds; }
  void end() { recogniser.end_path(found); }

  std::int64_t now_us() const { return kT0 + std::llround(time_s * 1e6); }
  static double seconds(std::int64_t time_us) { return static_cast<double>(time_us - kT0) * 1e-6; }

  CircleRecogniser recogniser;
  std::vector<RecognisedCircle> found;
  Eigen::Matrix3d tool = Eigen::Matrix3d::Identity();
  std::function<double()> noise;
  double time_s = 0.0;
  double step_s = 0.008;
  Vector3d here = Vector3d::Zero();
};

constexpr double kDegPerS = 0.05 / 0.1 / kRadPerDeg;  // at 50 mm/s on 100 mm

TEST(Recogniser, FindsACircleBothWays) {
  for (const int direction : {1, -1}) {
    Pen pen({circle_of()});
    pen.arc(direction > 0 ? -60.0 : 420.0, direction > 0 ? 420.0 : -60.0);
    const double driven = pen.time_s - pen.step_s;
    ASSERT_EQ(pen.found.size(), 1u) << "over as soon as the overshoot is, direction " << direction;
    EXPECT_EQ(pen.found[0].direction, direction);
    EXPECT_NEAR(Pen::seconds(pen.found[0].begin_us), 0.0, 1e-6);
    EXPECT_NEAR(Pen::seconds(pen.found[0].end_us), driven, 1e-6);
    EXPECT_NEAR(pen.found[0].feed, 0.05, 2e-5);
    EXPECT_TRUE(pen.recogniser.needed_since_us()) << "another lap may have begun in this overshoot";
    pen.to({0.0, 0.0, 0.0});
    EXPECT_FALSE(pen.recogniser.needed_since_us()) << "nothing more to keep";
  }
}

struct Story {
  const char* name;
  std::function<void(Pen&)> drive;
  std::size_t circles;
  double begin_deg = -60.0;  // of the first one's samples, along the path
  double end_deg = 420.0;
};

// Clockwise mirrors counter-clockwise; that both are found is said above.
TEST(Recogniser, EveryWayAPathMayBeginAndEnd) {
  const Story stories[] = {
      {"begins on the circle before the overshoot", [](Pen& p) { p.arc(-200, 430); }, 1},
      {"begins within the overshoot", [](Pen& p) { p.arc(-20, 420); }, 1, -20.0},
      {"begins where the arc does, and goes no further", [](Pen& p) { p.arc(0, 360), p.rest(1); }, 1, 0.0,
       360.0},
      {"comes from outside, tangentially",
       [](Pen& p) {
         p.here = {0.0, -0.1, 0.0}, p.to({0.0, -0.101, 0.0}), p.arc(-90, 430);
       },
       1},
      {"stands still for a minute, then drives", [](Pen& p) { p.arc(-60, -60), p.rest(60), p.arc(-60, 420); },
       1},
      {"stops in the overshoot behind the arc", [](Pen& p) { p.arc(-60, 380), p.rest(2); }, 1, -60.0, 380.0},
      {"leaves the circle in the overshoot", [](Pen& p) { p.arc(-60, 380), p.to(2.0 * p.here); }, 1, -60.0,
       380.0},
      {"turns back in the overshoot", [](Pen& p) { p.arc(-60, 390), p.arc(390, 370); }, 1, -60.0, 390.0},
      {"falls silent in the overshoot", [](Pen& p) { p.arc(-60, 390), p.end(); }, 1, -60.0, 390.0},
      {"falls silent for a second, and comes again elsewhere",
       [](Pen& p) {
         p.arc(-60, 390), p.silence(1), p.point({1, 1, 1});
       },
       1, -60.0, 390.0},
      {"trembles by two degrees at the start",
       [](Pen& p) { p.arc(-60, -58), p.arc(-58, -60), p.arc(-60, 420); }, 1},
      {"goes back by four degrees in the middle",
       [](Pen& p) { p.arc(-60, 100), p.arc(100, 96), p.arc(96, 420); }, 1, -60.0, 428.0},
      {"goes back by six degrees in the middle",
       [](Pen& p) { p.arc(-60, 100), p.arc(100, 94), p.arc(94, 420); }, 0},
      {"stops in the middle", [](Pen& p) { p.arc(-60, 100), p.rest(2), p.arc(100, 420); }, 0},
      {"leaves the circle in the middle, and comes back",
       [](Pen& p) { p.arc(-60, 100), p.to(1.05 * p.here), p.to(p.here / 1.05), p.arc(100, 420); }, 0},
      {"loses 0.3 s in the middle", [](Pen& p) { p.arc(-60, 100), p.silence(0.3), p.arc(108, 420); }, 0},
      {"loses 0.1 s in the middle", [](Pen& p) { p.arc(-60, 100), p.silence(0.1), p.arc(103, 420); }, 1},
      {"jumps by ten degrees in the middle", [](Pen& p) { p.arc(-60, 100), p.arc(110, 420); }, 0},
      {"begins too late", [](Pen& p) { p.arc(2, 420), p.rest(1); }, 0},
      {"ends too early", [](Pen& p) { p.arc(-60, 358), p.rest(1); }, 0},
      {"stands still on it for an hour", [](Pen& p) { p.arc(10, 10), p.rest(3600); }, 0},
      {"swings to and fro over half of it",
       [](Pen& p) {
         for (int i = 0; i < 6; ++i) p.arc(0, 200), p.arc(200, 0);
       },
       0},
  };
  for (const Story& story : stories) {
    SCOPED_TRACE(story.name);
    Pen pen({circle_of()});
    story.drive(pen);
    ASSERT_EQ(pen.found.size(), story.circles);
    if (story.circles == 0) continue;
    const RecognisedCircle& circle = pen.found[0];
    EXPECT_EQ(circle.direction, 1);
    EXPECT_NEAR(Pen::seconds(circle.end_us - circle.begin_us + kT0) * kDegPerS,
                story.end_deg - story.begin_deg,
                4.6);  // within steps of 0.23 degrees; where it trembles, the way back and again
  }
}

TEST(Recogniser, WhatItFindsBeginsAndEndsWhereTheOvershootsDo) {
  Pen pen({circle_of(0, 360, 30)});
  pen.arc(-90, 450);
  ASSERT_EQ(pen.found.size(), 1u);
  EXPECT_NEAR(Pen::seconds(pen.found[0].begin_us) * kDegPerS, 60.0, 0.25);
  EXPECT_NEAR(Pen::seconds(pen.found[0].end_us) * kDegPerS, 480.0, 0.5);
}

TEST(Recogniser, PartialArcsWhereverTheyBegin) {
  for (const double start : {-170.0, -20.0, 0.0, 95.0, 300.0})
    for (const double sweep : {10.0, 90.0, 220.0, 360.0})
      for (const double overshoot : {0.0, 5.0, 40.0})
        for (const int direction : {1, -1}) {
          SCOPED_TRACE(std::to_string(start) + " " + std::to_string(sweep) + " " + std::to_string(overshoot) +
                       " " + std::to_string(direction));
          Pen pen({circle_of(start, sweep, overshoot)});
          const double from = direction > 0 ? start - overshoot : start + sweep + overshoot;
          pen.arc(from, from + direction * (sweep + 2 * overshoot));
          pen.rest(1.0);
          ASSERT_EQ(pen.found.size(), 1u);
          EXPECT_EQ(pen.found[0].direction, direction);
        }
}

TEST(Recogniser, EachLapIsACircle) {
  Pen pen({circle_of(0, 360, 60)});
  pen.arc(-60, 5 * 360 + 60);
  ASSERT_EQ(pen.found.size(), 5u);
  for (std::size_t i = 0; i < 5; ++i) {
    EXPECT_NEAR(Pen::seconds(pen.found[i].begin_us) * kDegPerS, 360.0 * static_cast<double>(i), 0.25);
    EXPECT_NEAR(Pen::seconds(pen.found[i].end_us) * kDegPerS, 360.0 * static_cast<double>(i) + 480.0, 0.5);
  }
}

TEST(Recogniser, ADayOfLapsNeedsNoMoreThanOneOfThem) {
  Pen pen({circle_of(0, 360, 60), circle_of(0, 180, 30), circle_of(90, 90, 0)});
  pen.step_s = 0.1;
  double longest = 0.0;
  for (int lap = 0; lap < 500; ++lap) {
    pen.arc(lap * 360.0, lap * 360.0 + 359.9, 0.08);
    if (const auto since = pen.recogniser.needed_since_us())
      longest = std::max(longest, Pen::seconds(pen.now_us()) - Pen::seconds(*since));
  }
  EXPECT_NEAR(static_cast<double>(pen.found.size()), 499.0, 1.0);
  EXPECT_LT(longest, 1.5 * 2 * kPi * 0.1 / 0.08 + 1.0);
}

TEST(Recogniser, StandingStillOnTheCircleNeedsNothingOld) {
  Pen pen({circle_of()});
  pen.step_s = 0.1;
  pen.arc(-60, 30);
  pen.rest(86400.0);
  const auto since = pen.recogniser.needed_since_us();
  EXPECT_TRUE(!since || *since > pen.now_us() - 1'000'000);
  EXPECT_TRUE(pen.found.empty());
}

TEST(Recogniser, APathThatIsNotTheConfiguredCircleIsNone) {
  const double full[] = {-60.0, 420.0};
  using Off = std::function<Vector3d(double)>;
  const auto radial = [](double r, double a) { return Vector3d(r * std::cos(a), r * std::sin(a), 0.0); };
  const std::pair<const char*, Off> paths[] = {
      {"higher by 4 mm", [](double) { return Vector3d(0, 0, 0.004); }},
      {"beside by 4 mm", [](double) { return Vector3d(0.004, 0, 0); }},
      {"wider by 4 mm", [&](double a) { return radial(0.004, a); }},
      {"an ellipse of 95 and 105 mm", [&](double a) { return radial(0.005 * std::cos(2 * a), a); }},
      {"a helix of 20 mm a turn", [](double a) { return Vector3d(0, 0, 0.02 * a / (2 * kPi)); }},
      {"tilted by 5 degrees", [](double a) { return Vector3d(0, 0, 0.1 * std::sin(a) * std::sin(0.087)); }},
      {"a spiral", [&](double a) { return radial(0.005 * a / (2 * kPi), a); }},
      {"a hexagon",
       [&](double a) {
         const double third = std::fmod(a + 4 * kPi, kPi / 3) - kPi / 6;
         return radial(0.1 * std::cos(kPi / 6) / std::cos(third) - 0.1, a);
       }},
  };
  for (const auto& [name, off] : paths) {
    Pen pen({circle_of()});
    pen.arc(full[0], full[1], 0.05, 0.1, off);
    pen.rest(1.0);
    EXPECT_TRUE(pen.found.empty()) << name;
  }
  // So small is what the same paths may be off: a tool length that is a little wrong, a robot that is oval.
  for (const auto& [name, off] : paths) {
    Pen pen({circle_of()});
    pen.arc(full[0], full[1], 0.05, 0.1, [&, o = off](double a) -> Vector3d { return 0.1 * o(a); });
    pen.rest(1.0);
    EXPECT_EQ(pen.found.size(), 1u) << name;
  }
}

// A quarter of a circle that is 8 mm larger stays within 1.2 mm of the configured one.
TEST(Recogniser, AShortArcOfAnotherRadiusIsNotTheConfiguredOne) {
  for (const double wider_mm : {-20.0, -8.0, -4.0, 0.0, 4.0, 8.0, 20.0}) {
    const double radius = 0.1 + wider_mm * 1e-3;
    const double apart = 0.1 - radius + 0.5 * (radius - 0.1) * (1.0 - std::cos(kPi / 4));
    Pen pen({circle_of(-45, 90, 0)});
    pen.arc(-60, 60, 0.05, radius, [&](double) { return Vector3d(apart, 0, 0); });
    pen.rest(1.0);
    EXPECT_EQ(pen.found.size(), wider_mm == 0.0 ? 1u : 0u) << wider_mm << " mm";
  }
}

TEST(Recogniser, ARandomWalkIsNoCircle) {
  const unsigned seed = 5;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  std::normal_distribution<double> step(0.0, 0.003);
  std::vector<CircleToRecognise> tests;
  for (const double sweep : {10.0, 40.0, 90.0, 220.0, 360.0})
    for (const double radius : {0.02, 0.05, 0.1}) tests.push_back(circle_of(0, sweep, 0, radius));
  Pen pen(tests);
  Vector3d at(0.1, 0, 0);
  for (int i = 0; i < 200'000; ++i) {
    at += Vector3d(step(random), step(random), 0.0);
    if (at.norm() > 0.15) at *= 0.15 / at.norm();
    pen.point(at);
  }
  EXPECT_TRUE(pen.found.empty());
}

TEST(Recogniser, NoiseOfTheJointsDoesNotHideACircle) {
  const unsigned seed = 7;
  SCOPED_TRACE("seed " + std::to_string(seed));
  std::mt19937_64 random(seed);
  std::normal_distribution<double> white(0.0, 30e-6);
  Pen pen({circle_of()});
  pen.noise = [&] { return white(random); };
  pen.arc(-60, 420, 0.005);
  pen.rest(1.0);
  ASSERT_EQ(pen.found.size(), 1u);
}

TEST(Recogniser, TheToolMustPointAsConfigured) {
  for (const double off_deg : {0.0, 1.5, 3.0, 90.0}) {
    CircleToRecognise test = circle_of();
    test.tool = Eigen::AngleAxisd(kPi, Vector3d::UnitX()).toRotationMatrix();
    Pen pen({test});
    pen.tool = *test.tool * Eigen::AngleAxisd(off_deg * kRadPerDeg, Vector3d(1, 2, 3).normalized()).matrix();
    pen.arc(-60, 420);
    EXPECT_EQ(pen.found.size(), off_deg < 2.0 ? 1u : 0u) << off_deg;
  }
}

// Which of several tests that one path fits.
TEST(Recogniser, OfSeveralTestsTheNearestCounts) {
  const auto with = [](CircleToRecognise test, double feed, bool tool) {
    test.feed = feed;
    if (tool) test.tool = Eigen::Matrix3d::Identity();
    return test;
  };
  CircleToRecognise upside_down = circle_of();
  upside_down.tool = Eigen::AngleAxisd(kPi, Vector3d::UnitX()).toRotationMatrix();
  const CircleToRecognise full = circle_of();
  const CircleToRecognise part = circle_of(90, 220, 10);
  struct Case {
    const char* name;
    std::vector<CircleToRecognise> tests;
    int expected;  // -1: none
  };
  const Case cases[] = {
      {"alike: the first", {full, full}, 0},
      {"feed", {with(full, 0.1, false), with(full, 0.05, false), with(full, 0.2, false)}, 1},
      {"a feed a little off", {with(full, 0.1, false), with(full, 0.045, false)}, 1},
      {"no feed fits", {with(full, 0.1, false), with(full, 0.03, false)}, -1},
      {"no feed fits, but one test has none", {with(full, 0.1, false), full, with(full, 0.03, false)}, 1},
      {"one test alone may run at any feed", {with(full, 0.1, false)}, 0},
      {"tool", {with(full, 0.05, false), with(full, 0.2, true)}, 1},
      {"tool that does not fit", {upside_down, with(full, 0.2, false)}, 1},
      {"the longer arc", {part, full}, 1},
      {"the longer arc, configured first", {full, part}, 0},
  };
  for (const Case& c : cases) {
    SCOPED_TRACE(c.name);
    Pen pen(c.tests);
    pen.arc(-60, 420);
    pen.rest(1.0);
    ASSERT_EQ(pen.found.size(), c.expected < 0 ? 0u : 1u);
    if (c.expected >= 0) {
      EXPECT_EQ(pen.found[0].test, static_cast<std::size_t>(c.expected));
    }
  }
  Pen pen({full, part});  // the part alone is the part
  pen.arc(75, 325);
  pen.rest(1.0);
  ASSERT_EQ(pen.found.size(), 1u);
  EXPECT_EQ(pen.found[0].test, 1u);
}

TEST(Recogniser, TwoHalvesOneAfterAnotherAreTwoCircles) {
  Pen pen({circle_of(0, 180, 20), circle_of(180, 180, 20)});
  pen.arc(-20, 380);
  pen.rest(1.0);
  ASSERT_EQ(pen.found.size(), 2u);
  EXPECT_EQ(pen.found[0].test, 0u);
  EXPECT_EQ(pen.found[1].test, 1u);
}

TEST(Recogniser, ResetForgetsTheBeginning) {
  Pen pen({circle_of()});
  pen.arc(-60, 100);
  pen.recogniser.reset();
  EXPECT_FALSE(pen.recogniser.needed_since_us());
  pen.arc(100, 420);
  pen.rest(1.0);
  EXPECT_TRUE(pen.found.empty());
}

TEST(Recogniser, NothingDrivesThatFast) {
  Pen pen({circle_of()});
  pen.step_s = 1e-5;
  pen.arc(-60, 420, 20.0);
  EXPECT_TRUE(pen.found.empty());
}

}  // namespace
}  // namespace ballbar
