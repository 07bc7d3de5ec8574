// The gap of lines that lie askew to the world's axes.

#include <gtest/gtest.h>

#include <Eigen/LU>
#include <cmath>

#include "core/units.hpp"
#include "gap/add_gap.hpp"
#include "support/planar_cell.hpp"

namespace ballbar {
namespace {

using Eigen::Vector2d;

const Vector2d kStart(0.30, 0.10);
const Vector2d kEnd(0.45, 0.30);
constexpr double kOffset = 0.4 * kRadPerDeg;  // of joint 2

/// School geometry: joints of the planar arm at a place, and where both links then point.
Vector2d joints_at(const Vector2d& place) {
  const double q2 = std::acos((place.squaredNorm() - 0.25) / 0.24);
  return {std::atan2(place.y(), place.x()) - std::atan2(0.3 * std::sin(q2), 0.4 + 0.3 * std::cos(q2)), q2};
}

Vector2d arm(const Vector2d& q) {
  return {0.4 * std::cos(q[0]) + 0.3 * std::cos(q[0] + q[1]),
          0.4 * std::sin(q[0]) + 0.3 * std::sin(q[0] + q[1])};
}

/// Signed distance of a point from the line through both ends, + = to the left of the way.
double left_of_line(const Vector2d& point) {
  Eigen::Matrix2d spanned;
  spanned << kEnd - kStart, point - kStart;
  return spanned.determinant() / (kEnd - kStart).norm();
}

/// A reading at rest in each of eleven points, with the joints before, at and after it.
struct ObliqueLine {
  TestSpec test;
  ballbar::Run run;
  RunResult result;

  ObliqueLine() {
    test.name = "oblique";
    test.kind = TestKind::kLine;
    test.line = {{kStart.x(), kStart.y(), 0.0}, {kEnd.x(), kEnd.y(), 0.0}, 11};
    run.kind = TestKind::kLine;
    run.joints = 2;
    result.direction = 1;
    for (int k = 0; k <= 10; ++k) {
      const Vector2d q = joints_at(kStart + 0.1 * k * (kEnd - kStart));
      for (const double rest : {-0.1, 0.0, 0.1}) {
        run.joint_time.push_back(k + rest);
        run.joint_position.insert(run.joint_position.end(), q.begin(), q.end());
      }
    }
  }

  void read(char axis, double sign) {
    LineResult line;
    line.axis = axis;
    for (int k = 0; k <= 10; ++k) {
      const Vector2d q = joints_at(kStart + 0.1 * k * (kEnd - kStart));
      const double deviation = sign * left_of_line(arm(q + Vector2d(0.0, kOffset)));
      run.readings.push_back({axis, static_cast<double>(k), 0.025 * k, deviation});
      line.points.push_back({0.025 * k, deviation, {}});
    }
    result.lines.push_back(line);
  }
};

AsBuilt planar(double offset_deg) {
  RobotSpec spec;
  spec.effects = {{"joint_zero_offset", 2, {{"offset_deg", offset_deg}}, {}}};
  return {RobotModel(test::kPlanarUrdf, "base", "tcp", JointConvention::kSerial), spec};
}

// Straightness optics measure across the beam (metrology.md 2): along X, that is the right of this line, and
// along Y its left. What the tool point lacks or has too much along the line is not seen.
TEST(LineGap, OfARobotThatIsWhollyKnownIsNothingAcrossAnObliqueLine) {
  ObliqueLine line;
  line.read('X', -1.0);
  line.read('Y', 1.0);
  RunResult nominal = line.result;
  add_gap(line.run, line.test, planar(0.0), nominal);
  add_gap(line.run, line.test, planar(0.4), line.result);
  EXPECT_EQ(line.result.predicted_from, "joints");
  for (std::size_t i = 0; i < 2; ++i) {
    SCOPED_TRACE(line.result.lines[i].axis);
    ASSERT_TRUE(line.result.lines[i].gap.has_value());
    EXPECT_LT(to_um(line.result.lines[i].gap->rms), 1e-3);
    EXPECT_GT(to_um(nominal.lines[i].gap->rms), 10.0) << "there was something to explain";
  }
}

// A reading along the beam is none of straightness optics; rounding must not make it one.
TEST(LineGap, AlongTheLineItselfNothingIsPredicted) {
  ObliqueLine line;
  line.test.line.end = {0.30, 0.35, 0.0};
  line.read('Y', 1.0);
  add_gap(line.run, line.test, planar(0.4), line.result);
  EXPECT_FALSE(line.result.lines[0].gap.has_value());
  EXPECT_EQ(line.result.predicted_from, "");
}

}  // namespace
}  // namespace ballbar
