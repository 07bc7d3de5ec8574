// Table 3 of the paper: mastering alone gives both directions the same ovality, the paper's robot does not
// have it; one effect that hangs on direction is enough. Its joint stays open. Amplitudes are the paper's,
// and the fit is the test's own; only what each error does to circle A and B comes from the simulation.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <array>

#include "gap/paper_robot.hpp"

namespace ballbar::test {
namespace {

using Complex = std::complex<double>;

/// In the sequence of the table: A CCW, A CW, B CCW, B CW [um].
using Four = std::array<double, 4>;
constexpr Four kBefore{181.2, 208.6, 185.8, 206.7}, kAfter{72.6, 50.4, 77.0, 57.1};

std::array<Complex, 4> ovality_by(const EffectSpec& effect) {
  std::array<Complex, 4> all;
  for (std::size_t i = 0; i < 4; ++i) {
    SimulateOptions options;
    options.directions = {i % 2 == 0 ? 1 : -1};
    options.ball = BallPlacement::kFitted;
    all[i] =
        1e6 *
        harmonic(simulated(paper_robot({paper_circle(i < 2 ? "A" : "B")}, {effect}), options).front(), 2);
  }
  return all;
}

/// Zero offsets before (4) and after (4), and the size of one effect, the same before and after.
double misfit(const std::vector<std::array<Complex, 4>>& zeros, const std::array<Complex, 4>& odd,
              const Eigen::VectorXd& x, Eigen::VectorXd* residual = nullptr) {
  Eigen::VectorXd r(8);
  for (std::size_t when = 0; when < 2; ++when)
    for (std::size_t i = 0; i < 4; ++i) {
      Complex sum = x[8] * odd[i];
      for (std::size_t j = 0; j < 4; ++j) sum += x[static_cast<Eigen::Index>(4 * when + j)] * zeros[j][i];
      r[static_cast<Eigen::Index>(4 * when + i)] = (when == 0 ? kBefore : kAfter)[i] - std::abs(sum);
    }
  if (residual) *residual = r;
  return std::sqrt(r.squaredNorm() / 8.0);
}

/// Least misfit over starts, by damped Gauss-Newton with differences.
double least_misfit(const std::vector<std::array<Complex, 4>>& zeros, const std::array<Complex, 4>& odd) {
  double least = 1e300;
  for (const double j4 : {-20.0, 20.0})
    for (const double later : {-1.0, 1.0}) {
      Eigen::VectorXd x = Eigen::VectorXd::Zero(9), r, moved;
      x << 2.0, 8.0, j4, 2.0, 1.0, 2.0, later * j4, 1.0, 0.5;
      for (int step = 0; step < 200; ++step) {
        misfit(zeros, odd, x, &r);
        Eigen::MatrixXd slope(8, 9);
        for (Eigen::Index k = 0; k < 9; ++k) {
          Eigen::VectorXd y = x;
          y[k] += 1e-4;
          misfit(zeros, odd, y, &moved);
          slope.col(k) = (moved - r) / 1e-4;
        }
        const Eigen::MatrixXd normal = slope.transpose() * slope + 1e-3 * Eigen::MatrixXd::Identity(9, 9);
        x -= 0.5 * normal.ldlt().solve(slope.transpose() * r);
      }
      least = std::min(least, misfit(zeros, odd, x));
    }
  return least;
}

std::vector<std::array<Complex, 4>> zeros() {
  std::vector<std::array<Complex, 4>> all;
  for (const int joint : {2, 3, 4, 5}) all.push_back(ovality_by(zero_offset(joint, 1.0 / 60.0)));
  return all;
}

TEST(Table3, MasteringAloneGivesBothDirectionsTheSameAndMissesTheTable) {
  for (const auto& column : zeros())
    for (const std::size_t place : {0u, 2u})
      EXPECT_NEAR(std::abs(column[place]), std::abs(column[place + 1]), 0.01) << "CW is CCW";
  EXPECT_GT(least_misfit(zeros(), {}), 11.0) << "the half differences of the table";
}

TEST(Table3, OneEffectOfDirectionIsEnoughAndItsJointStaysOpen) {
  const auto mastering = zeros();
  for (const int joint : {1, 3}) {
    const double lag = least_misfit(mastering, ovality_by({"servo_lag", joint, {{"lag_ms", 1.0}}, {}}));
    const double gap = least_misfit(
        zeros(),
        ovality_by(
            {"joint_lost_motion", joint, {{"width_deg", 60.0 / 3600.0}}, {{"kind", "friction_windup"}}}));
    EXPECT_LT(lag, 3.0) << "J" << joint;
    EXPECT_LT(gap, 3.0) << "J" << joint;
  }
}

}  // namespace
}  // namespace ballbar::test
