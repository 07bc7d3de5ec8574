#pragma once
/// What the robot and the bar truly do. SI and radians; angles of the URDF chain.

#include <map>
#include <string>
#include <vector>

#include "plan.hpp"

namespace blind {

struct Ripple {
  int joint = 0;  ///< from 0
  double cycles = 0.0, amplitude = 0.0, phase = 0.0;
};

/// First-order warming: the lengths of table row `row` (from 0) grow.
struct Warming {
  int row = 0;
  double strain = 0.0, time_constant = 0.0;
};

struct Slip {
  Vector3d ball = Vector3d::Zero();  ///< displacement of the ball of the first test's set-up
  double gauge = 0.0;                ///< or of the bar's zero
  double series_time = 0.0;
};

struct Vibration {
  double frequency_hz = 0.0, amplitude = 0.0;
};

/// Errors of a joint that no catalogue has, as a function of one driver.
struct Strange {
  enum class Shape { kBump, kRipple, kSpeed, kTorqueSquared } shape = Shape::kBump;
  int joint = 0;
  double amplitude = 0.0;  ///< rad; rad s/rad for kSpeed; rad/(Nm)^2 for kTorqueSquared
  double at = 0.0;         ///< angle of the bump, or phase
  double width = 0.0;      ///< sigma of the bump, or cycles
};

struct Physics {
  Joints zero_offset{};
  Deviations geometry;
  Masses masses;
  Joints lag{};
  Joints compliance{};   ///< see `deflection` in truth.cpp: the spring hardens
  Joints windup_half{};  ///< friction wind-up: half width
  Joints load_half{};    ///< half width per Nm of load
  Joints gap_half{}, gap_friction{};
  double smoothing = 0.0;       ///< sigma of the Gaussian
  std::vector<Ripple> ripples;  ///< at the motor's angle
  std::vector<Ripple> eccentricities;
  std::vector<Warming> warmings;
  std::vector<Slip> slips;
  std::vector<Vibration> vibrations;
  std::vector<Strange> strange;
};

/// Torque [Nm] at which the spring of a joint has lost half of what it loses.
double half_hardening_nm(int joint);
/// Deflection of a hardening spring [rad]: its compliance is 1.07 of `compliance` at rest and tends to 0.93.
double deflection(double compliance, double torque_nm, int joint);

/// One way (test, direction, clock) as the joints behind the gears take it, at the bar's samples.
struct Way {
  std::vector<Joints> asked;   ///< commanded
  std::vector<Joints> link;    ///< true angles behind the gears, zero offsets in them
  std::vector<Joints> torque;  ///< [Nm], about each joint
};
Way way(const Physics& physics, const Test& test, int direction, double clock_s);

/// Where the ball stands: at the true tool point at the programmed centre, and `beside` it.
Vector3d ball_place(const Physics& physics, const Test& first, const Vector3d& beside);

/// Bar length minus radius [m] at the bar's samples, before instrument errors. `vibration_phase`: of this
/// recording.
std::vector<double> bar(const Physics& physics, const Way& way, const Plan& plan, const Recording& recording,
                        const Vector3d& ball, double vibration_phase);

}  // namespace blind
