#pragma once
/// An LR Mate 200iC by school geometry that drives circles and lines, with errors of its joints that only the
/// instruments see: shares no code with lib/physics, lib/kinematics or `ballbar simulate`.

#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <vector>

#include "gap/observation.hpp"
#include "gap/paper_robot.hpp"

namespace ballbar::test {

using ArmAngles = Eigen::Matrix<double, 6, 1>;

/// Chain angles (J3 relative to the upper arm) to the tool point [m]: the maker's dimensions, turn by turn.
inline Eigen::Vector3d tool_point(const ArmAngles& q) {
  using Eigen::Vector3d;
  const Vector3d axis[] = {{0, 0, 1}, {0, 1, 0}, {0, -1, 0}, {-1, 0, 0}, {0, -1, 0}, {-1, 0, 0}};
  const Vector3d through[] = {{0, 0, 0},         {0.075, 0, 0},     {0.075, 0, 0.300},
                              {0.075, 0, 0.375}, {0.395, 0, 0.375}, {0.395, 0, 0.375}};
  Vector3d point(0.54965, 0.0, 0.375);
  for (int j = 5; j >= 0; --j) point = through[j] + Eigen::AngleAxisd(q[j], axis[j]) * (point - through[j]);
  return point;
}

/// Chain angles with the tool straight down at a place: two triangles.
inline ArmAngles tool_down_at(const Eigen::Vector3d& place) {
  const double upper = 0.300, fore = std::hypot(0.320, 0.075), up = std::atan2(0.075, 0.320);
  const double out = std::hypot(place.x(), place.y()) - 0.075, high = place.z() + 0.15465;
  const double far = std::hypot(out, high);
  const double arm =
      std::atan2(high, out) + std::acos((upper * upper + far * far - fore * fore) / (2.0 * upper * far));
  const double pitch = std::atan2(high - upper * std::sin(arm), out - upper * std::cos(arm)) - up;
  ArmAngles q;
  q << std::atan2(place.y(), place.x()), std::numbers::pi / 2.0 - arm, 0.0, 0.0,
      -std::numbers::pi / 2.0 - pitch, 0.0;
  q[2] = pitch + q[1];
  q[5] = -q[0];
  return q;
}

/// The measured robot: what its links have beside its motors [rad], given the motors' angles and the sign of
/// each motor's last movement.
using JointErrors = std::function<ArmAngles(const ArmAngles& motor, const ArmAngles& came)>;

struct MeasuredArm {
  JointErrors errors = [](const ArmAngles&, const ArmAngles&) -> ArmAngles { return ArmAngles::Zero(); };
  double noise = 0.3e-6;         ///< [m] of a reading
  double offset = 0.0;           ///< [m] of the optics
  double slope = 0.0;            ///< [m/m]
  bool stops = true;             ///< of lines; false: read at 100 Hz while they are driven
  std::mt19937_64 random{4711};  ///< printed by the tests that fail
  std::int64_t now_us = 1'767'225'600'000'000;

  MeasuredRun circle(const TestSpec& test, int direction, int repetition);
  MeasuredRun line(const TestSpec& test, int direction, int repetition);

  /// Both ways, twice.
  void drive(const TestSpec& test, std::vector<MeasuredRun>& runs) {
    for (const int repetition : {1, 2})
      for (const int direction : {1, -1})
        runs.push_back(test.kind == TestKind::kCircle ? circle(test, direction, repetition)
                                                      : line(test, direction, repetition));
  }

 private:
  double noisy() { return noise * std::normal_distribution<double>()(random); }

  Run begin(const TestSpec& test, int direction, int repetition) const {
    Run run;
    run.robot = "lrmate-1";
    run.test = test.name;
    run.kind = test.kind;
    run.series = "s";
    run.direction = direction;
    run.repetition = repetition;
    run.feed = test.feed;
    run.payload = 0.5;
    run.joints = 6;
    run.started_us = now_us;
    return run;
  }

  /// The next sample of the joints, as the controller shows them. @return true tool point
  Eigen::Vector3d at(double time, const ArmAngles& motor, Run& run) {
    for (int j = 0; j < 6; ++j)
      if (!run.joint_time.empty() && motor[j] != before_[j]) came_[j] = motor[j] > before_[j] ? 1.0 : -1.0;
    before_ = motor;
    run.joint_time.push_back(time);
    for (int j = 0; j < 6; ++j) run.joint_position.push_back(j == 2 ? motor[2] - motor[1] : motor[j]);
    return tool_point(motor + errors(motor, came_));
  }

  void end(Run& run) {
    run.ended_us = now_us + static_cast<std::int64_t>(run.joint_time.back() * 1e6);
    now_us = run.ended_us + 4'000'000;
  }

  ArmAngles before_ = ArmAngles::Zero(), came_ = ArmAngles::Ones();
};

inline MeasuredRun MeasuredArm::circle(const TestSpec& test, int direction, int repetition) {
  constexpr double kTurn = 2.0 * std::numbers::pi, kRate = 100.0, kLead = 1.05;  // [rad]
  const Eigen::Vector3d centre(test.circle.centre[0], test.circle.centre[1], test.circle.centre[2]);
  const Eigen::Vector3d ball = centre + Eigen::Vector3d(30e-6, -20e-6, 10e-6);
  MeasuredRun measured;
  Run& run = measured.run = begin(test, direction, repetition);
  const double speed = test.feed / test.circle.radius, duration = (kTurn + 2.0 * kLead) / speed;
  for (int k = 0; k <= static_cast<int>(duration * kRate); ++k) {
    const double time = k / kRate, way = time * speed - kLead;
    const double angle = direction > 0 ? way : kTurn - way;
    const Eigen::Vector3d tool =
        at(time,
           tool_down_at(centre + test.circle.radius * Eigen::Vector3d(std::cos(angle), std::sin(angle), 0.0)),
           run);
    run.bar_time.push_back(time);
    run.bar_deviation.push_back((tool - ball).norm() - test.circle.radius + noisy());
    measured.angle.push_back(angle);
    if (way < 0.0) measured.arc_begin = measured.angle.size();
    if (way <= kTurn) measured.arc_end = measured.angle.size();
  }
  end(run);
  return measured;
}

/// From 20 mm before the line; on a line of stops half a second in each, a third from one to the next.
inline MeasuredRun MeasuredArm::line(const TestSpec& test, int direction, int repetition) {
  constexpr double kRate = 100.0, kLead = 0.020, kDwell = 0.5, kMove = 0.34;
  const Eigen::Vector3d from(test.line.start[0], test.line.start[1], test.line.start[2]);
  const Eigen::Vector3d to(test.line.end[0], test.line.end[1], test.line.end[2]);
  const double length = (to - from).norm();
  const Eigen::Vector3d along = (to - from) / length;
  MeasuredRun measured;
  Run& run = measured.run = begin(test, direction, repetition);
  const double step = length / (test.line.points - 1);
  const double cycle = kDwell + kMove;
  const double duration = stops ? test.line.points * cycle : (length + 2.0 * kLead) / test.feed;
  for (int k = 0; k <= static_cast<int>(duration * kRate); ++k) {
    const double time = k / kRate;
    double way = time * test.feed - kLead;
    bool read = way >= 0.0 && way <= length;
    if (stops) {
      const int stop = static_cast<int>(time / cycle + 1e-9);
      const double moved = std::min(1.0, (time - stop * cycle) / kMove);
      const double done = 0.5 * (1.0 - std::cos(std::numbers::pi * moved));
      way = stop == 0 ? -kLead * (1.0 - done) : std::min((stop - 1 + done) * step, length);
      read = k % 84 == 59;  // a quarter of a second after it has come to rest
    }
    const double position = direction > 0 ? way : length - way;
    const Eigen::Vector3d tool = at(time, tool_down_at(from + position * along), run);
    if (!read) continue;
    for (const char axis : {'X', 'Z'}) {
      const double across = axis == 'X' ? (tool - from).x() : (tool - from).z();
      run.readings.push_back({axis, time, position, across + offset + slope * position + noisy()});
    }
  }
  end(run);
  return measured;
}

/// The paper's line, or one like it at another height.
inline TestSpec line_at(const std::string& name, double z, int points = 51) {
  TestSpec test = paper_line();
  test.name = name;
  test.line = {{0.380, -0.400, z}, {0.380, 0.400, z}, points};
  return test;
}

inline TestSpec circle_at(const std::string& name, const Vec3& centre) {
  TestSpec test = paper_circle(name);
  test.circle.centre = centre;
  return test;
}

}  // namespace ballbar::test
