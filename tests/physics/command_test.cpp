// servo_lag and path_smoothing against closed forms.

#include <gtest/gtest.h>

#include <complex>

#include "physics/physics_test.hpp"

namespace ballbar {
namespace {

using test::arm_with;
using test::effect;

Motion followed(const EffectSpec& spec, const Motion& command) {
  return arm_with({spec}).follow(command, {});
}

TEST(ServoLag, AnswersARampAsAFirstOrderSystem) {
  // y = v (t - T + T exp(-t/T)) from rest.
  const double v = 0.7, T = 0.008;
  Motion ramp = test::single(60, 250, [&](double t) { return v * t; });
  ramp.time(30) += 0.001;  // the grid may be uneven
  ramp.q(0, 30) = v * ramp.time(30);
  const Motion motor = followed(effect("servo_lag", 1, {{"lag_ms", 8}}), ramp);
  for (int k = 0; k < 60; ++k) {
    const double t = ramp.time(k);
    EXPECT_NEAR(motor.q(0, k), v * (t - T + T * std::exp(-t / T)), 1e-14) << k;
  }
  EXPECT_EQ(motor.time, ramp.time);
}

TEST(ServoLag, AnswersASineWithGainAndPhase) {
  // After the start, y = Im[exp(i w t) / (1 + i w T)]; straight lines between samples cost (w dt)^2 / 12.
  const double T = 0.005;
  for (const double w : {0.5, 5.0, 20.0}) {
    const Motion sine = test::single(2000, 1000, [&](double t) { return 0.4 * std::sin(w * t); });
    const Motion motor = followed(effect("servo_lag", 1, {{"lag_ms", 5}}), sine);
    const std::complex<double> gain = 1.0 / std::complex<double>(1.0, w * T);
    for (int k = 200; k < 2000; ++k) {
      const double want = 0.4 * (gain * std::polar(1.0, w * k / 1000.0)).imag();
      EXPECT_NEAR(motor.q(0, k), want, 0.4 * w * w * 1e-6 / 12 + 1e-13) << "w " << w;
    }
  }
}

TEST(ServoLag, TouchesItsOwnJointOnly) {
  const Motion command = test::swing(100, 50);
  const Motion motor = test::lrmate_with({effect("servo_lag", 3, {{"lag_ms", 4}})}).follow(command, {});
  for (int j = 0; j < 6; ++j)
    EXPECT_EQ((motor.q.row(j) - command.q.row(j)).norm() > 0.0, j == 2) << "joint " << j + 1;
}

TEST(ServoLag, OfACoarseRecordingIsThatOfTheMotionBehindIt) {
  // T y' + y = sin(wt), steady: (sin(wt) - wT cos(wt)) / (1 + (wT)^2).
  const double w = 2.0, lag = 3e-3;
  const Motion command = test::single(400, 62, [&](double t) { return std::sin(w * t); });
  const Motion motor = followed(effect("servo_lag", 1, {{"lag_ms", lag * 1e3}}), command);
  const Eigen::ArrayXd t = command.time.array();
  const Eigen::ArrayXd exact = ((w * t).sin() - w * lag * (w * t).cos()) / (1.0 + w * w * lag * lag);
  EXPECT_LT((motor.q.row(0).transpose().array() - exact).segment(10, 380).abs().maxCoeff(), 1e-6);
}

TEST(PathSmoothing, ShrinksACircleByTheClosedForm) {
  // Two joints as x and y: a circle of 100 mm keeps R exp(-w^2 s^2 / 2).
  const std::string urdf = R"(<robot name="two"><link name="base"/><link name="l1"/><link name="tcp"/>
    <joint name="j1" type="continuous"><parent link="base"/><child link="l1"/><axis xyz="0 0 1"/></joint>
    <joint name="j2" type="continuous"><parent link="l1"/><child link="tcp"/><axis xyz="1 0 0"/></joint></robot>)";
  for (const double w : {0.55, 3.0, 8.0}) {
    for (const double sigma : {0.008, 0.028}) {
      const AsBuilt robot(RobotModel(urdf, "base", "tcp", JointConvention::kSerial),
                          test::with_effects({effect("path_smoothing", 0, {{"time_ms", sigma * 1e3}})}));
      Motion circle{Eigen::VectorXd::LinSpaced(1001, 0.0, 4.0), Eigen::MatrixXd(2, 1001)};
      for (int k = 0; k <= 1000; ++k)
        circle.q.col(k) << 0.1 * std::cos(w * circle.time(k)), 0.1 * std::sin(w * circle.time(k));
      const Motion motor = robot.follow(circle, {});
      const double want = 0.1 * std::exp(-w * w * sigma * sigma / 2);
      for (int k = 100; k <= 900; ++k) {
        EXPECT_NEAR(motor.q.col(k).norm(), want, 5e-5 * (0.1 - want) + 1e-11) << "w " << w << " s " << sigma;
        EXPECT_NEAR(motor.q.col(k).normalized().dot(circle.q.col(k).normalized()), 1.0, 1e-12)
            << "zero phase";
      }
    }
  }
}

TEST(PathSmoothing, LeavesStraightMotionsOnUnevenGridsAndAtTheEnds) {
  Motion line = test::single(200, 250, [](double) { return 0.0; });
  for (int k = 1; k < 200; k += 3) line.time(k) += 0.0013;
  line.q.row(0) = (0.2 + 0.9 * line.time.array()).transpose();
  const Motion motor = followed(effect("path_smoothing", 0, {{"time_ms", 20}}), line);
  EXPECT_LT((motor.q - line.q).cwiseAbs().maxCoeff(), 1e-13);
}

TEST(PathSmoothing, OfACoarseRecordingIsThatOfTheMotionBehindIt) {
  // A Gaussian leaves exp(-(w sigma)^2 / 2) of a sine. At 36 samples a second no sample lies within sigma.
  for (const double sigma : {0.5e-3, 10e-3, 20e-3}) {
    const Motion command = test::single(400, 36, [](double t) { return std::sin(2 * t); });
    const Motion motor = followed(effect("path_smoothing", 0, {{"time_ms", sigma * 1e3}}), command);
    const Eigen::RowVectorXd exact = std::exp(-2.0 * sigma * sigma) * command.q.row(0);
    EXPECT_LT((motor.q.row(0) - exact).segment(10, 380).cwiseAbs().maxCoeff(), 2e-6) << sigma;
  }
}

}  // namespace
}  // namespace ballbar
