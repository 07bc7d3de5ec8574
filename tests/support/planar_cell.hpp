#pragma once
/// A planar arm of two links whose inverse kinematics is school geometry, a circle it drives and a ball where
/// one likes: recordings with a known answer that share no code with the library.

#include <cmath>
#include <functional>
#include <string>

#include "core/run.hpp"
#include "core/spec.hpp"

namespace ballbar::test {

inline const std::string kPlanarUrdf = R"(<robot name="planar">
  <link name="base"/><link name="upper"/><link name="fore"/><link name="tcp"/>
  <joint name="j1" type="revolute"><parent link="base"/><child link="upper"/><axis xyz="0 0 1"/>
    <limit lower="-3.2" upper="3.2" velocity="3" effort="1"/></joint>
  <joint name="j2" type="revolute"><origin xyz="0.4 0 0"/><parent link="upper"/><child link="fore"/><axis xyz="0 0 1"/>
    <limit lower="-3.2" upper="3.2" velocity="3" effort="1"/></joint>
  <joint name="j3" type="fixed"><origin xyz="0.3 0 0"/><parent link="fore"/><child link="tcp"/></joint>
</robot>)";

struct PlanarCircle {
  double radius = 0.1;  ///< [m]
  double arc_start_deg = 0.0;
  double arc_sweep_deg = 360.0;
  double overshoot_deg = 60.0;
  int direction = 1;
  double feed = 0.05;   ///< [m/s]
  double ball_x = 0.0;  ///< [m] of the ball from the programmed centre
  double ball_y = 0.0;
  double bar_period = 0.004;    ///< [s]
  double joint_period = 0.008;  ///< [s]
  std::function<double(double)> shape = [](double) {
    return 0.0;
  };                                                           ///< [m] of the path's radius, by angle [rad]
  std::function<double(int)> noise = [](int) { return 0.0; };  ///< [m] by sample number
};

inline TestSpec planar_test(const PlanarCircle& c) {
  const double rad_per_deg = 3.14159265358979323846 / 180.0;
  TestSpec test;
  test.name = "A";
  test.circle.centre = {0.45, 0.1, 0.0};
  test.circle.radius = c.radius;
  test.circle.arc_start = c.arc_start_deg * rad_per_deg;
  test.circle.arc_sweep = c.arc_sweep_deg * rad_per_deg;
  test.circle.overshoot = c.overshoot_deg * rad_per_deg;
  test.feed = c.feed;
  return test;
}

/// What the instruments would have recorded: the joints know the programmed circle, the bar sees the true
/// one.
inline Run planar_run(const PlanarCircle& c) {
  const double rad_per_deg = 3.14159265358979323846 / 180.0;
  const TestSpec test = planar_test(c);
  Run run;
  run.robot = "planar";
  run.test = "A";
  run.direction = c.direction;
  run.repetition = 1;
  run.started_us = 1'700'000'000'000'000;
  run.feed = c.feed;
  run.joints = 2;
  const double turn = (c.arc_sweep_deg + 2.0 * c.overshoot_deg) * rad_per_deg;
  const double from = (c.direction > 0 ? c.arc_start_deg - c.overshoot_deg
                                       : c.arc_start_deg + c.arc_sweep_deg + c.overshoot_deg) *
                      rad_per_deg;
  const double rate = c.feed / c.radius;
  const double margin = 0.02;  // the marks lie so far outside the motion
  const double duration = turn / rate;
  run.ended_us = run.started_us + std::llround((duration + 2 * margin) * 1e6);
  for (double t = 0.0; t < duration; t += c.joint_period) {
    const double angle = from + c.direction * rate * t;
    const double x = test.circle.centre[0] + c.radius * std::cos(angle);
    const double y = test.circle.centre[1] + c.radius * std::sin(angle);
    const double elbow = std::acos((x * x + y * y - 0.4 * 0.4 - 0.3 * 0.3) / (2 * 0.4 * 0.3));
    const double shoulder = std::atan2(y, x) - std::atan2(0.3 * std::sin(elbow), 0.4 + 0.3 * std::cos(elbow));
    run.joint_time.push_back(margin + t);
    run.joint_position.insert(run.joint_position.end(), {shoulder, elbow});
  }
  int i = 0;
  for (double t = 0.0; t < duration; t += c.bar_period, ++i) {
    const double angle = from + c.direction * rate * t;
    const double rho = c.radius + c.shape(angle);
    const double length = std::hypot(rho * std::cos(angle) - c.ball_x, rho * std::sin(angle) - c.ball_y);
    run.bar_time.push_back(margin + t);
    run.bar_deviation.push_back(length - c.radius + c.noise(i));
  }
  return run;
}

}  // namespace ballbar::test
