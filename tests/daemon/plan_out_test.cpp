// What is proposed as text for the configuration is read back as it was.

#include "daemon/plan_out.hpp"

#include <gtest/gtest.h>

#include "core/units.hpp"
#include "daemon/config.hpp"
#include "support/process.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

TestSpec read_back(const TestSpec& test) {
  const test::TempDir dir;
  const std::string path = dir.path() + "/ballbard.toml";
  test::write_file(dir.path() + "/r.urdf", "<robot/>");
  test::write_file(path, "[[robot]]\nname = \"r\"\nurdf = \"r.urdf\"\n\n" + test_table(test));
  return load_config(path).robots.at(0).tests.at(0);
}

void expect_near(const Vec3& a, const Vec3& b, double tolerance) {
  for (std::size_t i = 0; i < 3; ++i) EXPECT_NEAR(a[i], b[i], tolerance);
}

void expect_common(const TestSpec& read, const TestSpec& written) {
  EXPECT_EQ(read.name, written.name);
  EXPECT_EQ(read.kind, written.kind);
  EXPECT_NEAR(read.feed, written.feed, 1e-12);
  ASSERT_EQ(read.tool_rpy.has_value(), written.tool_rpy.has_value());
  if (read.tool_rpy) expect_near(*read.tool_rpy, *written.tool_rpy, 1e-10);
  EXPECT_EQ(read.payload, written.payload);
  ASSERT_EQ(read.posture.size(), written.posture.size());
  for (std::size_t i = 0; i < read.posture.size(); ++i)
    EXPECT_NEAR(read.posture[i], written.posture[i], 1e-9);  // nine digits of degrees
}

TEST(PlanOut, ALineIsReadBackAsItWas) {
  TestSpec line;
  line.name = "Y-3";
  line.kind = TestKind::kLine;
  line.line = {{0.38, -0.333333333333, -0.251}, {0.1, 0.2 / 3.0, 0.0}, 41};
  line.feed = 0.05533;
  line.tool_rpy = Vec3{150.0 * kRadPerDeg, 0.1, -0.2};
  line.payload = 2.44;
  const TestSpec read = read_back(line);
  expect_common(read, line);
  expect_near(read.line.start, line.line.start, 1e-9);
  expect_near(read.line.end, line.line.end, 1e-9);
  EXPECT_EQ(read.line.points, 41);
}

TEST(PlanOut, ALineThatIsHeldAsItsPostureSaysKeepsThat) {
  TestSpec line;
  line.name = "far";
  line.kind = TestKind::kLine;
  line.line = {{0.4, 0.0, 0.1}, {0.4, 0.0, 0.4}, 21};
  line.feed = 0.02;
  line.posture = {0.0, 0.3, -0.2, 0.0, 1.0 / 3.0, 0.0};
  expect_common(read_back(line), line);
}

TEST(PlanOut, ACircleIsReadBackAsItWas) {
  TestSpec circle;
  circle.name = "A-2";
  circle.circle.centre = {0.38, -0.32, -0.251};
  circle.circle.normal = {0.0, 0.5, 0.75};
  circle.circle.arc_sweep = kTurn;
  circle.circle.overshoot = kTurn / 6.0;
  circle.circle.radius = 0.05;
  circle.feed = 0.11;
  circle.tool_rpy = Vec3{kPi, 0.0, 0.0};
  const TestSpec read = read_back(circle);
  expect_common(read, circle);
  expect_near(read.circle.centre, circle.circle.centre, 1e-9);
  EXPECT_NEAR(read.circle.normal[1] / read.circle.normal[2], 2.0 / 3.0, 1e-9);
  EXPECT_NEAR(read.circle.arc_sweep, kTurn, 1e-9);
  EXPECT_NEAR(read.circle.overshoot, kTurn / 6.0, 1e-9);
  EXPECT_NEAR(read.circle.radius, 0.05, 1e-12);
}

TEST(PlanOut, TheSentenceOfALineSaysWhatToDrive) {
  RankedTest best;
  best.proposed.test.kind = TestKind::kLine;
  best.proposed.test.feed = 0.05;
  best.proposed.differs = "line along X, 470 mm long, through the middle of Y, read at 51 stops";
  best.noise = 12.0;
  best.sure = 11.0;
  EXPECT_EQ(
      sentence_of(best, {1.0, 1.0}),
      "drive a line along X, 470 mm long, through the middle of Y, read at 51 stops, at 50 mm/s, both ways, "
      "twice: it takes them from 1 to 12 standard deviations of noise apart");
}

}  // namespace
}  // namespace ballbar
