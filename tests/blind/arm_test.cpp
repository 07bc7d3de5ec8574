// The generator's own arm against figures that neither it nor lib/ has computed: ../shared/metrology.md,
// sections 3 and 4.

#include <gtest/gtest.h>

#include <cmath>

#include "blind/generator/arm.hpp"
#include "blind/generator/plan.hpp"
#include "blind/generator/truth.hpp"

namespace blind {
namespace {

/// Angles in degrees as on the teach pendant, where J3 counts from level.
Joints pendant(double j1, double j2, double j3, double j4, double j5, double j6) {
  return {j1 * kRad, j2 * kRad, (j3 + j2) * kRad, j4 * kRad, j5 * kRad, j6 * kRad};
}

struct Place {
  Joints q;
  Vector3d mm;
};

TEST(Arm, ToolPointOfPendantAngles) {
  for (const Place& place : {Place{pendant(0, 0, 0, 0, 0, 0), {549.65, 0, 375}},
                             Place{pendant(0, 0, 0, 0, -90, 0), {395, 0, 220.35}},
                             Place{pendant(30, 20, -10, 40, -50, 60), {547.2167, 228.0050, 193.5655}},
                             Place{pendant(-40.1, 50, -70, 0, -20, 40.1), {370.7855, -312.2304, -236.8638}}})
    EXPECT_LT((1e3 * tool_point(place.q, {}) - place.mm).norm(), 1e-4)
        << (1e3 * tool_point(place.q, {})).transpose();
}

TEST(Arm, PendantAnglesOfToolPoint) {
  Eigen::Matrix3d down;
  down << 1, 0, 0, 0, -1, 0, 0, 0, -1;
  for (const Place& place :
       {Place{pendant(-33.6901, 63.3312, -57.8450, 0, -32.1550, 33.6901), {480, -320, -251}},
        Place{pendant(-48.8141, 46.8933, -79.6671, 0, -10.3329, 48.8141), {280, -320, -251}},
        Place{pendant(47.8624, 61.8613, -59.5446, 0, -30.4554, -47.8624), {380, 420, -251}}}) {
    const Joints q = inverse(1e-3 * place.mm, down, {});
    for (std::size_t j = 0; j < 6; ++j)
      EXPECT_NEAR(q[j] / kRad, place.q[j] / kRad, 1e-4) << "joint " << j + 1;
  }
}

TEST(Arm, ReachesEveryCircleOfEveryPlan) {
  for (const char* const name : {"PM", "P0", "P3"})
    for (const blind::Test& test : plan(name).tests) {
      SCOPED_TRACE(std::string(name) + " " + test.name);
      const Sampling s = sampling(test);
      const auto way = command(test, 1, 0.0, s.bar_period, static_cast<std::size_t>(s.bar_count()));
      const Vector3d centre = 1e-3 * test.centre_mm;
      for (std::size_t k = 0; k < way.size(); k += 50) {
        EXPECT_NEAR((tool_point(way[k], {}) - centre).norm(), 1e-3 * test.radius_mm, 1e-12);
        for (std::size_t j = 0; k > 0 && j < 6; ++j) {
          EXPECT_LT(std::abs(way[k][j] - way[k - 50][j]), 1.0) << "joint " << j + 1 << " flips";
        }
      }
    }
}

TEST(Arm, HoldsItsOwnWeight) {
  // Upper arm up, forearm level, at rest: levers about joint 2 are 80, 350 (wrist 320 + 30) and 450 mm;
  // gravity 9.80665.
  const Masses as_assumed;
  const auto torque = torques(std::vector<Joints>(3, Joints{}), 1.0, 3.0, as_assumed)[1];
  const double about_2 = -9.80665 * (6.0 * 0.080 + 1.2 * 0.350 + 3.0 * 0.450);
  EXPECT_NEAR(torque[1], about_2, 1e-9);
  EXPECT_NEAR(torque[2], -about_2, 1e-9);  // the same levers, turned the other way round
  EXPECT_NEAR(torque[0], 0.0, 1e-9);
  EXPECT_NEAR(torque[4], 9.80665 * (1.2 * 0.030 + 3.0 * 0.130), 1e-9);
}

TEST(Arm, AcceleratesItsMasses) {
  // Joint 1 with 1 rad/s^2: the sum of m r^2, radii about its axis.
  std::vector<Joints> q(3, Joints{});
  const double step = 1e-3;
  q[0][0] = q[2][0] = 0.5 * step * step;
  const double inertia =
      5.5 * 0.075 * 0.075 + 6.0 * 0.155 * 0.155 + 1.2 * 0.425 * 0.425 + 3.0 * 0.525 * 0.525;
  EXPECT_NEAR(torques(q, step, 3.0, {})[1][0], inertia, 1e-6);
}

/// Bar of a circle with and without something at joint 3, [m].
double largest_change(const Physics& physics) {
  const blind::Test test = plan("PM").tests[2];
  const Way with = way(physics, test, 1, 0.0), without = way({}, test, 1, 0.0);
  double most = 0.0;
  for (std::size_t k = 0; k < with.link.size(); ++k)
    most = std::max(most, std::abs(with.link[k][2] - without.link[k][2]));
  return most;
}

TEST(Truth, WindupIsAsWideAsItSays) {
  Physics p;
  p.windup_half[2] = 50e-6;
  EXPECT_NEAR(largest_change(p), 50e-6, 1e-12);
}

TEST(Truth, LagIsSpeedTimesItsTime) {
  Physics p;
  p.lag[2] = 4e-3;
  const blind::Test test = plan("PM").tests[2];
  const Way with = way(p, test, 1, 0.0), without = way({}, test, 1, 0.0), later = way({}, test, 1, -4e-3);
  for (std::size_t k = 0; k < with.link.size(); k += 100) {
    const double lag = with.link[k][2] - without.link[k][2], delay = later.link[k][2] - without.link[k][2];
    EXPECT_NEAR(lag, delay, 4e-6) << k;  // they differ by T^2 q'' / 2
  }
}

TEST(Truth, ASpringHardensAboutItsCompliance) {
  EXPECT_NEAR(deflection(1e-5, 0.01, 1) / 0.01, 1.07e-5, 1e-8);
  EXPECT_NEAR(deflection(1e-5, 1e4, 1) / 1e4, 0.93e-5, 1e-8);
  EXPECT_EQ(deflection(1e-5, -20, 1), -deflection(1e-5, 20, 1));
}

}  // namespace
}  // namespace blind
