#include "truth.hpp"

#include <algorithm>
#include <cmath>
#include <functional>

namespace blind {
namespace {

constexpr int kFiner = 2;          // steps of the simulation between bar samples
constexpr double kLeadDeg = 40.0;  // driven before the recording begins: the filters have settled
constexpr double kWindowSigmas = 5.0;
constexpr double kSecondHarmonic = 0.06;  // of an eccentricity
constexpr double kOvertone = 0.10;        // of a ripple at twice the motor's rate, at four times
constexpr double kOvertonePhase = 1.1;
constexpr double kFlank = 0.02;         // [Nm] over which the load takes a gap from flank to flank
constexpr double kGearStiffness = 2e7;  // [Nm/rad] of a gear with a gap, else rigid
constexpr double kSecondPlay = 0.3;     // width of the second play element of a wind-up
constexpr double kSecondShare = 0.1;    // and its share

using Series = std::vector<double>;

Series take(const std::vector<Joints>& q, std::size_t joint) {
  Series s(q.size());
  for (std::size_t k = 0; k < q.size(); ++k) s[k] = q[k][joint];
  return s;
}

/// Zero phase: the controller knows the way ahead. `pad` samples at either end are lost.
Series smoothed(const Series& s, double sigma_steps, int pad) {
  Series weight(static_cast<std::size_t>(2 * pad + 1));
  double sum = 0.0;
  for (int i = -pad; i <= pad; ++i)
    sum += weight[static_cast<std::size_t>(i + pad)] = std::exp(-0.5 * i * i / (sigma_steps * sigma_steps));
  Series out = s;
  for (std::size_t k = static_cast<std::size_t>(pad); k + static_cast<std::size_t>(pad) < s.size(); ++k) {
    double mean = 0.0;
    for (std::size_t i = 0; i < weight.size(); ++i)
      mean += weight[i] * s[k + i - static_cast<std::size_t>(pad)];
    out[k] = mean / sum;
  }
  return out;
}

/// T y' + y = x, exact where x runs straight from step to step; settled at the begin.
void follow(Series& s, double time_constant, double step) {
  const double fade = std::exp(-step / time_constant);
  double y = s[0] - time_constant * (s[1] - s[0]) / step, before = s[0];
  for (std::size_t k = 0; k < s.size(); ++k) {
    const double slope = k == 0 ? 0.0 : (s[k] - before) / step;
    if (k > 0) {
      const double settled_before = before - time_constant * slope, settled = s[k] - time_constant * slope;
      y = settled + (y - settled_before) * fade;
    }
    before = s[k];
    s[k] = y;
  }
}

/// Play between a moving pair of stops: how far the link is behind the motor.
Series play(const Series& motor, const std::function<std::pair<double, double>(std::size_t)>& stops) {
  Series behind(motor.size());
  const auto [low0, high0] = stops(0);
  double e = 0.5 * (low0 + high0);
  for (std::size_t k = 0; k < motor.size(); ++k) {
    const auto [low, high] = stops(k);
    e = std::clamp(e + (k == 0 ? 0.0 : motor[k] - motor[k - 1]), low, high);
    behind[k] = e;
  }
  return behind;
}

void add(Series& to, double factor, const Series& s) {
  for (std::size_t k = 0; k < to.size(); ++k) to[k] += factor * s[k];
}

/// All losses of motion between motor and link of one joint.
Series lost(const Physics& p, std::size_t j, const Series& motor, const Series& torque) {
  Series sum(motor.size(), 0.0);
  if (const double h = p.windup_half[j]; h > 0.0) {
    // Two elements: motion is not lost all at once. Together as wide as one of half width h.
    const double first = h * (1.0 - kSecondShare * kSecondPlay) / (1.0 - kSecondShare),
                 second = h * kSecondPlay;
    add(sum, 1.0 - kSecondShare, play(motor, [&](std::size_t) { return std::pair{-first, first}; }));
    add(sum, kSecondShare, play(motor, [&](std::size_t) { return std::pair{-second, second}; }));
  }
  if (const double h = p.load_half[j]; h > 0.0)
    add(sum, 1.0, play(motor, [&](std::size_t k) {
          return std::pair{-h * std::abs(torque[k]), h * std::abs(torque[k])};
        }));
  if (const double b = p.gap_half[j]; b > 0.0) {
    const auto flank = [&](double load) { return b * std::tanh(load / kFlank) + load / kGearStiffness; };
    const double f = p.gap_friction[j];
    add(sum, 1.0, play(motor, [&](std::size_t k) {
          return std::pair{flank(torque[k] - f), flank(torque[k] + f)};
        }));
  }
  return sum;
}

double strange_error(const Strange& s, double q, double speed, double torque) {
  switch (s.shape) {
    case Strange::Shape::kBump:
      return s.amplitude * std::exp(-0.5 * (q - s.at) * (q - s.at) / (s.width * s.width));
    case Strange::Shape::kRipple:
      return s.amplitude * std::sin(s.width * q + s.at);
    case Strange::Shape::kSpeed:
      return s.amplitude * std::abs(speed);
    case Strange::Shape::kTorqueSquared:
      return s.amplitude * torque * torque;
  }
  return 0.0;
}

bool loaded(const Physics& p) {
  for (std::size_t j = 0; j < 6; ++j)
    if (p.compliance[j] != 0.0 || p.load_half[j] > 0.0 || p.gap_half[j] > 0.0) return true;
  for (const Strange& s : p.strange)
    if (s.shape == Strange::Shape::kTorqueSquared) return true;
  return false;
}

Joints elastic(const Physics& p, Joints q, const Joints& torque) {
  for (std::size_t j = 0; j < 6; ++j) {
    if (p.compliance[j] != 0.0) q[j] -= deflection(p.compliance[j], torque[j], static_cast<int>(j));
    q[j] += p.zero_offset[j];
  }
  return q;
}

double eccentric(const Ripple& r, double q) {
  return r.amplitude * (std::sin(q + r.phase) + kSecondHarmonic * std::sin(2.0 * q + 2.0 * r.phase));
}

double rippled(const Ripple& r, double q, bool overtone) {
  const double angle = r.cycles * q + r.phase;
  return r.amplitude *
         (std::sin(angle) + (overtone ? kOvertone * std::sin(2.0 * angle + kOvertonePhase) : 0.0));
}

}  // namespace

double half_hardening_nm(int joint) { return joint < 3 ? 15.0 : 1.5; }

double deflection(double compliance, double torque_nm, int joint) {
  const double load = std::abs(torque_nm);
  return compliance * torque_nm * (1.07 - 0.14 * load / (load + half_hardening_nm(joint)));
}

Way way(const Physics& p, const Test& test, int direction, double clock_s) {
  const Sampling s = sampling(test);
  const double step = s.bar_period / kFiner;
  const double sigma = p.smoothing / step;
  const int pad = p.smoothing > 0.0 ? static_cast<int>(std::ceil(kWindowSigmas * sigma)) : 0;
  const double turn = 2.0 * std::numbers::pi * test.radius_mm / test.feed_mm_s;
  const int lead = static_cast<int>(kLeadDeg / 360.0 * turn / step) + pad;
  const std::size_t count = static_cast<std::size_t>(lead + kFiner * (s.bar_count() - 1) + 2 + pad);
  const std::vector<Joints> asked = command(test, direction, clock_s - lead * step, step, count);
  const std::vector<Joints> torque =
      loaded(p) ? torques(asked, step, test.payload_kg, p.masses) : std::vector<Joints>(count);

  std::vector<Joints> link = asked;
  for (std::size_t j = 0; j < 6; ++j) {
    Series motor = take(asked, j);
    if (pad > 0) motor = smoothed(motor, sigma, pad);
    if (p.lag[j] > 0.0) follow(motor, p.lag[j], step);
    Series angle = motor;
    add(angle, -1.0, lost(p, j, motor, take(torque, j)));
    for (std::size_t k = 0; k < count; ++k) {
      for (const Ripple& r : p.ripples)
        if (r.joint == static_cast<int>(j)) angle[k] += rippled(r, motor[k], r.cycles >= 150.0);
      for (const Ripple& r : p.eccentricities)
        if (r.joint == static_cast<int>(j)) angle[k] += eccentric(r, motor[k]);
      for (const Strange& one : p.strange)
        if (one.joint == static_cast<int>(j)) {
          const std::size_t next = std::min(k + 1, count - 1), last = next - std::min<std::size_t>(next, 2);
          const double speed = (motor[next] - motor[last]) / (static_cast<double>(next - last) * step);
          angle[k] += strange_error(one, motor[k], speed, torque[k][j]);
        }
      link[k][j] = angle[k];
    }
  }
  Way result;
  for (int i = 0; i < s.bar_count(); ++i) {
    const std::size_t k = static_cast<std::size_t>(lead + kFiner * i);
    result.asked.push_back(asked[k]);
    result.torque.push_back(torque[k]);
    result.link.push_back(elastic(p, link[k], torque[k]));
  }
  return result;
}

Vector3d ball_place(const Physics& p, const Test& first, const Vector3d& beside) {
  Joints q = at_centre(first);
  const Joints torque = torques(std::vector<Joints>(3, q), 1.0, first.payload_kg, p.masses)[1];
  for (const Ripple& r : p.ripples)
    q[static_cast<std::size_t>(r.joint)] += rippled(r, q[static_cast<std::size_t>(r.joint)], false);
  for (const Ripple& r : p.eccentricities)
    q[static_cast<std::size_t>(r.joint)] += eccentric(r, q[static_cast<std::size_t>(r.joint)]);
  return tool_point(elastic(p, q, torque), p.geometry) + beside;
}

std::vector<double> bar(const Physics& p, const Way& way, const Plan& plan, const Recording& recording,
                        const Vector3d& ball, double vibration_phase) {
  const Test& test = plan.tests[static_cast<std::size_t>(recording.test)];
  const double period = sampling(test).bar_period;
  const bool slips_here = test.centre_mm == plan.tests.front().centre_mm;
  std::vector<double> length(way.link.size());
  Deviations geometry = p.geometry;
  for (std::size_t i = 0; i < length.size(); ++i) {
    const double time = 60.0 * recording.minute + period * static_cast<double>(i);
    if (!p.warmings.empty()) {
      geometry = p.geometry;
      for (const Warming& w : p.warmings) {
        const double strain = w.strain * (1.0 - std::exp(-time / w.time_constant));
        geometry.a[static_cast<std::size_t>(w.row)] += strain * (w.row == 2 ? 0.300 : 0.075);
        if (w.row == 3) geometry.d[3] += strain * 0.320;
      }
    }
    Vector3d centre = ball;
    double more = 0.0;
    for (const Slip& slip : p.slips)
      if (time >= slip.series_time) {
        if (slips_here) centre += slip.ball;
        more += slip.gauge;
      }
    for (const Vibration& v : p.vibrations)
      more +=
          v.amplitude * std::sin(2.0 * std::numbers::pi * v.frequency_hz * period * static_cast<double>(i) +
                                 vibration_phase);
    length[i] = (tool_point(way.link[i], geometry) - centre).norm() - 1e-3 * test.radius_mm + more;
  }
  return length;
}

}  // namespace blind
