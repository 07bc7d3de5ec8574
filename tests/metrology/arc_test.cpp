#include "metrology/arc.hpp"

#include <gtest/gtest.h>

#include <Eigen/Geometry>

#include <cmath>
#include <limits>

#include "core/units.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

CircleSpec circle(double start_deg, double sweep_deg, double overshoot_deg) {
  CircleSpec spec;
  spec.centre = {0.38, -0.32, -0.251};
  spec.arc_start = start_deg * kRadPerDeg;
  spec.arc_sweep = sweep_deg * kRadPerDeg;
  spec.overshoot = overshoot_deg * kRadPerDeg;
  return spec;
}

/// n angles at even steps [deg -> rad], ends included.
VectorXd driven(double from_deg, double to_deg, int n) {
  return VectorXd::LinSpaced(n, from_deg, to_deg) * kRadPerDeg;
}

TEST(CalculatedFeed, IsTheArcOverTheTimeBetweenItsEnds) {
  // 90 deg of R = 100 mm in 3 s, slowly at first: 157.08 mm / 3 s.
  VectorXd angle(6), time(6);
  angle << kNan, 0.0, 10.0, 40.0, 90.0, kNan;
  angle *= kRadPerDeg;
  time << 0.0, 1.0, 2.0, 3.0, 4.0, 5.0;
  EXPECT_NEAR(*calculated_feed(angle, time, 0.1), 0.1570796326794897 / 3.0, 1e-15);
  EXPECT_NEAR(*calculated_feed(-angle, time, 0.1), 0.1570796326794897 / 3.0, 1e-15) << "either way round";
  EXPECT_FALSE(calculated_feed(angle.head(2), time.head(2), 0.1)) << "one angle is known";
  EXPECT_FALSE(calculated_feed(VectorXd(), VectorXd(), 0.1));
  EXPECT_FALSE(calculated_feed(angle, VectorXd::Constant(6, 1.0), 0.1)) << "no time passes";
  EXPECT_THROW(calculated_feed(angle, time.head(3), 0.1), std::invalid_argument);
}

TEST(CirclePlane, HasTheNameThatIsoGivesIt) {
  struct Row {
    Vec3 normal, first_axis;
    const char* name;
  };
  for (const Row& row :
       {Row{{0, 0, 1}, {1, 0, 0}, "XY"}, Row{{1, 0, 0}, {0, 1, 0}, "YZ"}, Row{{0, 1, 0}, {0, 0, 1}, "ZX"},
        Row{{0, 0, 2}, {1, 0, 5}, "XY"}, Row{{0, 0, -1}, {1, 0, 0}, "XY, normal -Z, angle 0 on X"},
        Row{{0, 1, 0}, {1, 0, 0}, "ZX, normal Y, angle 0 on X"},
        Row{{0, 0, 1}, {-1, 1, 0}, "XY, normal Z, angle 0 on (-0.707, 0.707, 0)"},
        Row{{0.6, 0, 0.8}, {0, 1, 0}, "normal (0.6, 0, 0.8), angle 0 on Y"}}) {
    CircleSpec spec;
    spec.normal = row.normal;
    spec.first_axis = row.first_axis;
    EXPECT_EQ(plane_name(spec), row.name);
  }
}

TEST(CirclePlane, IsRightHandedAndTakesTheFirstAxisIntoThePlane) {
  CircleSpec spec;
  spec.normal = {0.0, 0.6, 0.8};
  spec.first_axis = {0.3, 1.0, 0.1};  // neither unit nor in the plane
  const CirclePlane plane = plane_of(spec);
  EXPECT_NEAR(plane.e1.norm(), 1.0, 1e-15);
  EXPECT_NEAR(plane.e1.dot(plane.normal), 0.0, 1e-15);
  EXPECT_LT((plane.e1.cross(plane.e2) - plane.normal).norm(), 1e-15);
  EXPECT_GT(plane.e1.dot(Vector3d(0.3, 1.0, 0.1)), 0.0);
}

TEST(CirclePlane, RefusesAxesThatSpanNoPlane) {
  CircleSpec spec;
  spec.first_axis = {0.0, 0.0, 2.0};
  EXPECT_THROW(plane_of(spec), std::invalid_argument);
  spec.normal = {0.0, 0.0, 0.0};
  EXPECT_THROW(plane_of(spec), std::invalid_argument);
}

TEST(AnglesOnCircle, RunOnWithoutJumpsOverSeveralTurnsInEitherDirection) {
  const CircleSpec spec = circle(0, 360, 180);
  for (const double sign : {1.0, -1.0}) {
    const VectorXd truth = sign * driven(-179, 1000, 400);
    Matrix3Xd points(3, truth.size());
    for (Index i = 0; i < truth.size(); ++i)
      points.col(i) << 0.38 + 0.1 * std::cos(truth[i]), -0.32 + 0.1 * std::sin(truth[i]),
          -0.2;  // above the plane
    EXPECT_LT((angles_on_circle(points, spec) - truth).cwiseAbs().maxCoeff(), 1e-12);
  }
}

TEST(AnglesOnCircle, TurnCounterClockwiseAboutTheNormalFromTheFirstAxis) {
  CircleSpec spec;
  spec.normal = {0, 0, -1};  // seen from below: e2 = -y
  Matrix3Xd points(3, 3);
  points << 1, 0, -1,  //
      0, -1, 0,        //
      0, 0, 0;
  const VectorXd angle = angles_on_circle(points, spec);
  EXPECT_NEAR(angle[0], 0.0, 1e-15);
  EXPECT_NEAR(angle[1], kPi / 2, 1e-15);
  EXPECT_NEAR(angle[2], kPi, 1e-15);
}

TEST(AnglesOnCircle, OfPointsNotKnownAreNotKnownAndTheRestGoesOn) {
  Matrix3Xd points = Matrix3Xd::Zero(3, 4);
  points.col(0).setConstant(kNan);
  points.col(1) << 0.38 - 0.1, -0.32 + 0.01, 0;  // just below half a turn
  points.col(2).setConstant(kNan);
  points.col(3) << 0.38 - 0.1, -0.32 - 0.01, 0;  // just above
  const VectorXd angle = angles_on_circle(points, circle(0, 360, 0));
  EXPECT_TRUE(std::isnan(angle[0]));
  EXPECT_TRUE(std::isnan(angle[2]));
  EXPECT_NEAR(angle[3] - angle[1], 2.0 * std::atan(0.1), 1e-12);
}

TEST(AnglesAtConstantFeed, PutTheMiddleOfTheRunOnTheMiddleOfTheArc) {
  const CircleSpec spec = circle(90, 180, 45);  // 270 deg driven, middle at 180
  const double feed = 0.05;
  const double duration = 270.0 * kRadPerDeg * spec.radius / feed;
  VectorXd time(3);
  time << 10.0, 10.0 + duration / 2, 10.0 + duration;
  for (const int direction : {1, -1}) {
    // Marks 20 ms outside the motion on both sides change nothing.
    const VectorXd angle = angles_at_constant_feed(time, 9.98, 10.02 + duration, spec, direction, feed);
    EXPECT_NEAR(angle[0], (180.0 - direction * 135.0) * kRadPerDeg, 1e-12);
    EXPECT_NEAR(angle[1], kPi, 1e-12);
    EXPECT_NEAR(angle[2], (180.0 + direction * 135.0) * kRadPerDeg, 1e-12);
  }
}

TEST(AnglesAtConstantFeed, TrustTheDurationWhereTheFeedIsMissingOrContradictsIt) {
  const CircleSpec spec = circle(0, 360, 90);  // 540 deg driven
  const Eigen::Vector2d time(0.0, 20.0);
  const double by_duration = 540.0 * kRadPerDeg / 20.0;
  const auto rate = [&](double feed) {
    const VectorXd angle = angles_at_constant_feed(time, 0.0, 20.0, spec, 1, feed);
    return (angle[1] - angle[0]) / 20.0;
  };
  const double feed = by_duration * spec.radius;
  EXPECT_NEAR(rate(0.0), by_duration, 1e-12);
  EXPECT_NEAR(rate(feed / 1.11), by_duration, 1e-12);         // would need 11 % more time
  EXPECT_NEAR(rate(feed / 0.89), by_duration, 1e-12);         // 11 % less
  EXPECT_NEAR(rate(feed / 1.09), by_duration / 1.09, 1e-12);  // believed
  EXPECT_NEAR(rate(feed / 0.91), by_duration / 0.91, 1e-12);
}

TEST(AnglesAtConstantFeed, AreNotKnownWithoutADirectionOrADuration) {
  const CircleSpec spec = circle(0, 360, 0);
  EXPECT_TRUE(angles_at_constant_feed(VectorXd::Zero(3), 0.0, 5.0, spec, 0, 0.05).array().isNaN().all());
  EXPECT_TRUE(angles_at_constant_feed(VectorXd::Zero(3), 5.0, 5.0, spec, 1, 0.05).array().isNaN().all());
}

struct ArcCase {
  const char* name;
  double start, sweep, overshoot;  // deg
  double from, to;                 // deg, as the angles arrive
  int samples;
  double first, last;  // deg, of the samples that must be chosen
};

void PrintTo(const ArcCase& c, std::ostream* out) { *out << c.name; }

class FindArc : public testing::TestWithParam<ArcCase> {};

TEST_P(FindArc, TakesTheSamplesOfTheArcAndShiftsTheirAnglesOntoIt) {
  const ArcCase& c = GetParam();
  VectorXd angle(c.samples + 6);
  angle << VectorXd::Constant(3, kNan), driven(c.from, c.to, c.samples), VectorXd::Constant(3, kNan);
  const Arc arc = find_arc(angle, circle(c.start, c.sweep, c.overshoot));
  ASSERT_LT(arc.begin, arc.end);
  EXPECT_NEAR(to_deg(angle[static_cast<Index>(arc.begin)]), c.first, 1e-9);
  EXPECT_NEAR(to_deg(angle[static_cast<Index>(arc.end) - 1]), c.last, 1e-9);
  EXPECT_EQ(arc.coverage, 1.0);
  EXPECT_NEAR(to_deg(arc.largest_hole), std::abs(c.to - c.from) / (c.samples - 1), 1e-9);
  EXPECT_TRUE(std::isnan(angle[0]));
}

INSTANTIATE_TEST_SUITE_P(
    Cases, FindArc,
    testing::Values(ArcCase{"counter_clockwise", 0, 360, 60, -60, 420, 481, 0, 359},
                    ArcCase{"clockwise", 0, 360, 60, 420, -60, 481, 359, 0},
                    ArcCase{"a_turn_too_high", 0, 360, 60, 300, 780, 481, 0, 359},
                    ArcCase{"two_turns_too_low", 0, 360, 60, -780, -300, 481, 0, 359},
                    ArcCase{"clockwise_a_turn_too_low", 0, 360, 60, 60, -420, 481, 359, 0},
                    ArcCase{"quarter", 30, 90, 10, 20, 130, 111, 30, 119},
                    ArcCase{"across_half_a_turn", 150, 60, 10, -220, -140, 81, 150, 209},
                    ArcCase{"clockwise_across_zero", -45, 90, 20, 425, 295, 131, 44, -45},
                    ArcCase{"overshoot_of_half_a_turn", 0, 360, 180, -180, 540, 721, 0, 359},
                    ArcCase{"no_overshoot", 0, 360, 0, 0, 360, 361, 0, 359}),
    [](const auto& param) { return param.param.name; });

TEST(FindArc, SaysHowMuchOfTheArcIsMissingAndWhere) {
  const CircleSpec spec = circle(0, 360, 60);
  VectorXd stopped_early = driven(-60, 270, 331);
  const Arc three_quarters = find_arc(stopped_early, spec);
  EXPECT_NEAR(three_quarters.coverage, 0.75, 1e-9);
  EXPECT_NEAR(to_deg(three_quarters.largest_hole), 90.0, 1e-9);

  VectorXd with_hole(101 + 201);
  with_hole << driven(-60, 40, 101), driven(220, 420, 201);
  const Arc half = find_arc(with_hole, spec);
  EXPECT_NEAR(half.coverage, 0.5, 1e-9);
  EXPECT_NEAR(to_deg(half.largest_hole), 180.0, 1e-9);
}

TEST(FindArc, DoesNotCallSparseSamplesHoles) {
  VectorXd angle = driven(-60, 420, 41);  // every 12 deg
  const Arc arc = find_arc(angle, circle(0, 360, 60));
  EXPECT_EQ(arc.end - arc.begin, 30U);
  EXPECT_EQ(arc.coverage, 1.0);
  EXPECT_NEAR(to_deg(arc.largest_hole), 12.0, 1e-9);
}

TEST(FindArc, TakesOneOfTwoSamplesATurnApartWhateverTheRounding) {
  for (const double shift : {-3e-7, 0.0, 3e-7})
    for (const double sign : {1.0, -1.0}) {
      VectorXd angle = sign * driven(-60, 420, 481).array() + shift;
      const Arc arc = find_arc(angle, circle(0, 360, 60));
      EXPECT_EQ(arc.end - arc.begin, 360U) << shift << " " << sign;
    }
}

TEST(FindArc, FindsNothingWhereNothingIsKnown) {
  const CircleSpec spec = circle(0, 360, 60);
  VectorXd nothing(0);
  VectorXd unknown = VectorXd::Constant(9, kNan);
  for (VectorXd* angle : {&nothing, &unknown}) {
    const Arc arc = find_arc(*angle, spec);
    EXPECT_EQ(arc.begin, arc.end);
    EXPECT_EQ(arc.coverage, 0.0);
    EXPECT_DOUBLE_EQ(arc.largest_hole, 2.0 * kPi);
  }
}

}  // namespace
}  // namespace ballbar
