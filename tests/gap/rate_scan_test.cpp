// A ripple put by hand into the readings of two circles, its rate found again.

#include "gap/rate_scan.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "gap/paper_robot.hpp"
#include "gap/proposed_tests.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

constexpr int kRippleJoint = 3;

/// Circles A and B of a robot whose other gears are known, both ways, with the noise of good laps expected
/// but none there.
class RateScanTest : public testing::Test {
 protected:
  RateScanTest()
      : spec_(test::paper_robot({test::paper_circle("A"), test::paper_circle("B")}, {})),
        model_(AsBuilt(test::lrmate(), spec_), with_gears(spec_)) {
    for (const TestSpec& circle : spec_.tests)
      for (Observation& seen : as_observed(model_, circle, circle.name == "A" ? 0 : 1, lap_noise_of({})))
        seen_.push_back(std::move(seen));
  }
  static RobotSpec& with_gears(RobotSpec& spec) {
    spec.gear_ratio = {120, 121, 100, 80, 80, 50};
    spec.gear_ratio[kRippleJoint - 1] = 0.0;
    return spec;
  }

  /// Tool point at angles of the chain, from the centre of the observed circle.
  Eigen::Vector3d arm(const Observation& seen, const VectorXd& q) const {
    const Vec3& centre = spec_.find_test(seen.test)->circle.centre;
    return model_.model().chain().forward({q.data(), 6}).translation() -
           Eigen::Vector3d(centre[0], centre[1], centre[2]);
  }

  /// The joints where the tool passes evenly spaced angles of the circle, the first half a step inside it.
  std::vector<VectorXd> joints_on_arc(const Observation& seen) const {
    const Eigen::MatrixXd& said = seen.said.q;
    std::vector<double> way;  // [turns] of the circle, rising
    for (Index i = 0; i < said.cols(); ++i) {
      const Eigen::Vector3d point = arm(seen, said.col(i));
      const double turns = seen.direction * std::atan2(point.y(), point.x()) / (2.0 * std::numbers::pi);
      way.push_back(turns - (way.empty() ? 1.0 : std::round(turns - way.back())));
    }
    // The overshoot before it is a sixth of a turn.
    const double begin = std::round(way.front() + 1.0 / 6.0);
    std::vector<VectorXd> joints;
    std::size_t after = 1;
    for (Index k = 0; k < seen.places(); ++k) {
      const double wanted = begin + (static_cast<double>(k) + 0.5) / static_cast<double>(seen.places());
      while (way[after] < wanted) ++after;
      const double share = (wanted - way[after - 1]) / (way[after] - way[after - 1]);
      const auto column = static_cast<Index>(after);
      joints.emplace_back((1.0 - share) * said.col(column - 1) + share * said.col(column));
    }
    return joints;
  }

  void put_ripple(double cycles, double amplitude) {
    for (Observation& seen : seen_) {
      VectorXd values(seen.places());
      Index k = 0;
      for (VectorXd q : joints_on_arc(seen)) {
        const double length = arm(seen, q).norm();
        q[kRippleJoint - 1] += amplitude * std::sin(cycles * q[kRippleJoint - 1] + 0.4);
        values[k++] = arm(seen, q).norm() - length;
      }
      seen.measured += seen.transform(values);
    }
  }

  /// Rates that are proposed for what no fit has touched.
  std::vector<Candidate> proposed() const {
    const GapFitter fitter(model_, seen_);
    GapFit none;
    none.state = model_.start(seen_);
    std::vector<Candidate> candidates;
    const bool added = add_ripples_of_unknown_rate(fitter, none, candidates);
    EXPECT_EQ(added, !candidates.empty());
    EXPECT_FALSE(add_ripples_of_unknown_rate(fitter, none, candidates)) << "what is proposed is not again";
    return candidates;
  }

  RobotSpec spec_;
  GapModel model_;
  std::vector<Observation> seen_;
};

TEST_F(RateScanTest, ARippleIsProposedAtItsRateForItsJoint) {
  for (const double cycles : {31.5, 73.25, 160.0}) {
    SCOPED_TRACE(std::to_string(cycles) + " cycles per turn");
    for (Observation& seen : seen_) seen.measured.setZero();
    put_ripple(cycles, 0.5 * test::kArcmin);
    const std::vector<Candidate> found = proposed();
    ASSERT_EQ(found.size(), 1u);
    EXPECT_EQ(found[0].effect.joint, kRippleJoint);
    EXPECT_EQ(found[0].effect.kind->name, "transmission_error");
    EXPECT_NEAR(found[0].effect.values[0], cycles, 0.05);
    EXPECT_GT(found[0].rate_sd, 0.0);
    EXPECT_LT(found[0].rate_sd, 0.05);
  }
}

TEST_F(RateScanTest, NothingIsProposedWhereNothingIsOrTheGearIsKnown) {
  EXPECT_TRUE(proposed().empty());
  put_ripple(73.25, 0.5 * test::kArcmin);
  spec_.gear_ratio[kRippleJoint - 1] = 100.0;
  model_ = GapModel(AsBuilt(test::lrmate(), spec_), spec_);
  EXPECT_TRUE(proposed().empty());
}

}  // namespace
}  // namespace ballbar
