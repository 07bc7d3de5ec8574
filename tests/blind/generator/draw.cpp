#include "draw.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

namespace blind {
namespace {

constexpr std::array<double, 6> kGear = {120, 121, 100, 80, 80, 50};
constexpr double kMicro = 1e-6;
constexpr int kJoints = 5;  // the tool point lies on the axis of joint 6: nothing of that joint shows

ordered_json parameter(const char* name, double value) { return {{"name", name}, {"value", value}}; }

double turn(double phase) {
  const double deg = phase / kRad;
  return deg - 360.0 * std::floor(deg / 360.0);
}

Planted servo_lag(int j, double size, Random& random) {
  const double lag = size * random.uniform(1e-3, 8e-3);
  return {[=](Physics& p) { p.lag[static_cast<std::size_t>(j)] += lag; },
          {{"effect", "servo_lag"},
           {"joint", j + 1},
           {"parameters", ordered_json::array({parameter("lag_ms", 1e3 * lag)})}}};
}

Planted joint_compliance(int j, double size, Random& random) {
  const double c = size * (j < 3 ? random.log_uniform(1e-5, 8e-5) : random.log_uniform(1e-4, 4e-4));
  return {[=](Physics& p) { p.compliance[static_cast<std::size_t>(j)] += c; },
          {{"effect", "joint_compliance"},
           {"joint", j + 1},
           {"parameters", ordered_json::array({parameter("compliance_rad_per_nm", c)})},
           {"note",
            "the spring hardens: 1.07 of the drawn value at rest, 0.93 far beyond; the value given is the "
            "slope of the "
            "straight line through its deflections in the fitted runs"}}};
}

Planted backlash(int j, double size, Random& random) {
  const auto at = static_cast<std::size_t>(j);
  const double half = size * random.log_uniform(20 * kMicro, 150 * kMicro);
  const double friction = j < 3 ? random.log_uniform(0.5, 4.0) : random.log_uniform(0.1, 1.0);
  return {[=](Physics& p) {
            p.gap_half[at] += half;
            p.gap_friction[at] = friction;
          },
          {{"effect", "joint_lost_motion"},
           {"joint", j + 1},
           {"kind", "backlash"},
           {"parameters", ordered_json::array(
                              {parameter("width_deg", 2 * half / kRad), parameter("friction_nm", friction)})},
           {"accept_kind", {"backlash", "friction_windup", "unresolved"}}}};
}

Planted joint_lost_motion(int j, double size, Random& random) {
  const auto at = static_cast<std::size_t>(j);
  // The load of joints 2 and 3 never changes sign: a gap there stays closed, and is a zero offset.
  const int kind = j == 1 || j == 2 ? 2 * random.below(2) : random.below(3);
  if (kind == 1) return backlash(j, size, random);
  ordered_json answer = {{"effect", "joint_lost_motion"}, {"joint", j + 1}};
  const double half = size * random.log_uniform(20 * kMicro, 150 * kMicro);
  const double per_nm = size * (j < 3 ? random.log_uniform(1e-6, 5e-6) : random.log_uniform(1e-5, 6e-5));
  if (kind == 0) {
    answer["kind"] = "friction_windup";
    answer["parameters"] = ordered_json::array({parameter("width_deg", 2 * half / kRad)});
    answer["accept_kind"] = {"friction_windup", "backlash", "unresolved"};
    return {[=](Physics& p) { p.windup_half[at] += half; }, answer};
  }
  answer["kind"] = "load_friction";
  answer["parameters"] =
      ordered_json::array({parameter("width_deg", 2 * per_nm / kRad), parameter("friction_nm", 1.0)});
  answer["accept_kind"] = {"load_friction", "friction_windup", "unresolved"};
  answer["note"] = "width_deg is that at a load of friction_nm";
  return {[=](Physics& p) { p.load_half[at] += per_nm; }, answer};
}

Planted ripple(int j, int per_motor_turn, double size, Random& random) {
  const Ripple r = {
      .joint = j,
      .cycles = per_motor_turn * kGear[static_cast<std::size_t>(j)],
      .amplitude = size * random.log_uniform(15 * kMicro, (per_motor_turn == 2 ? 120 : 100) * kMicro),
      .phase = random.uniform(0, 2 * std::numbers::pi)};
  return {[=](Physics& p) { p.ripples.push_back(r); },
          {{"effect", "transmission_error"},
           {"joint", j + 1},
           {"parameters", ordered_json::array({parameter("cycles_per_turn", r.cycles),
                                               parameter("amplitude_deg", r.amplitude / kRad),
                                               parameter("phase_deg", turn(r.phase))})}}};
}

Planted joint_eccentricity(int j, double size, Random& random) {
  const Ripple r = {.joint = j,
                    .cycles = 1,
                    .amplitude = size * random.log_uniform(100 * kMicro, 800 * kMicro),
                    .phase = random.uniform(0, 2 * std::numbers::pi)};
  return {[=](Physics& p) { p.eccentricities.push_back(r); },
          {{"effect", "joint_eccentricity"},
           {"joint", j + 1},
           {"parameters", ordered_json::array({parameter("amplitude_deg", r.amplitude / kRad),
                                               parameter("phase_deg", turn(r.phase))})}}};
}

Planted link_geometry(double size, Random& random) {
  struct Member {
    Joints Deviations::*of;
    int row;
    const char* name;
    double unit;
  };
  const double mm = 1e-3;
  const std::array<Member, 10> members = {{{&Deviations::a, 2, "a_mm", mm},
                                           {&Deviations::a, 3, "a_mm", mm},
                                           {&Deviations::a, 4, "a_mm", mm},
                                           {&Deviations::d, 4, "d_mm", mm},
                                           {&Deviations::alpha, 2, "alpha_deg", kRad},
                                           {&Deviations::alpha, 3, "alpha_deg", kRad},
                                           {&Deviations::beta, 3, "beta_deg", kRad},
                                           {&Deviations::alpha, 4, "alpha_deg", kRad},
                                           {&Deviations::alpha, 5, "alpha_deg", kRad},
                                           {&Deviations::alpha, 6, "alpha_deg", kRad}}};
  const Member m = members[static_cast<std::size_t>(random.below(10))];
  const double si =
      random.sign() * size * (m.unit == mm ? random.log_uniform(1e-4, 1e-3) : random.log_uniform(3e-4, 3e-3));
  return {[=](Physics& p) { (p.geometry.*m.of)[static_cast<std::size_t>(m.row - 1)] += si; },
          {{"effect", "link_geometry"},
           {"joint", m.row},
           {"parameters", ordered_json::array({parameter(m.name, si / m.unit)})},
           {"accept_joint", {m.row, m.row - 1}}}};
}

Planted tool_offset(double size, Random& random) {
  const int axis = random.below(3);
  const double off = random.sign() * size * random.log_uniform(1e-4, 1e-3);
  const std::array<const char*, 3> name = {"x_mm", "y_mm", "z_mm"};
  return {
      [=](Physics& p) { p.geometry.tool[axis] += off; },
      {{"effect", "tool_offset"},
       {"joint", 0},
       {"parameters", ordered_json::array({parameter(name[static_cast<std::size_t>(axis)], 1e3 * off)})}}};
}

Planted thermal_growth(double size, Random& random) {
  const int joint = random.below(2) + 2;
  const double strain = size * random.log_uniform(8e-5, 5e-4), minutes = random.uniform(20, 60);
  return {[=](Physics& p) {
            p.warmings.push_back({.row = joint, .strain = strain, .time_constant = 60 * minutes});
          },
          {{"effect", "thermal_growth"},
           {"joint", joint},
           {"parameters", ordered_json::array({parameter("strain_ppm", 1e6 * strain),
                                               parameter("time_constant_min", minutes)})},
           {"accept_joint", {joint, joint + 1}}}};
}

Planted path_smoothing(double size, Random& random) {
  const double sigma = std::sqrt(size) * random.uniform(0.010, 0.040);  // its effect goes with the square
  return {[=](Physics& p) { p.smoothing = sigma; },
          {{"effect", "path_smoothing"},
           {"joint", 0},
           {"parameters", ordered_json::array({parameter("time_ms", 1e3 * sigma)})}}};
}

/// A moment between the first and the last recording of the first set-up; now and then while one is recorded.
double moment(const Plan& plan, Random& random) {
  std::vector<double> begins;
  for (const Recording& r : plan.recordings)
    if (plan.tests[static_cast<std::size_t>(r.test)].centre_mm == plan.tests.front().centre_mm)
      begins.push_back(60.0 * r.minute);
  const auto at = static_cast<std::size_t>(2 + random.below(static_cast<int>(begins.size()) - 3));
  return begins[at] + (random.below(10) < 3 ? random.uniform(3.0, 10.0) : -random.uniform(15.0, 40.0));
}

Planted slip(bool of_ball, double size, const Plan& plan, double epoch_us, Random& random) {
  const double far = size * random.log_uniform(3 * kMicro, 20 * kMicro);
  const Vector3d way = random.normal3(1.0).normalized() * far;
  Slip s = {.ball = way, .gauge = 0.0, .series_time = moment(plan, random)};
  const ordered_json time = parameter("time_us", std::round(epoch_us + 1e6 * s.series_time));
  if (of_ball)
    return {[=](Physics& p) { p.slips.push_back(s); },
            {{"effect", "ball_slip"},
             {"joint", 0},
             {"parameters",
              ordered_json::array({parameter("x_um", 1e6 * way.x()), parameter("y_um", 1e6 * way.y()),
                                   parameter("z_um", 1e6 * way.z()), time})}}};
  s.ball.setZero();
  s.gauge = random.sign() * far;
  return {[=](Physics& p) { p.slips.push_back(s); },
          {{"effect", "gauge_jump"},
           {"joint", 0},
           {"parameters", ordered_json::array({parameter("jump_um", 1e6 * s.gauge), time})}}};
}

Planted structural_vibration(double size, Random& random) {
  const Vibration v = {.frequency_hz = random.uniform(8, 25),
                       .amplitude = size * random.log_uniform(2 * kMicro, 15 * kMicro)};
  return {[=](Physics& p) { p.vibrations.push_back(v); },
          {{"effect", "structural_vibration"},
           {"joint", 0},
           {"parameters", ordered_json::array({parameter("frequency_hz", v.frequency_hz),
                                               parameter("amplitude_um", 1e6 * v.amplitude)})},
           {"note", "along the bar; another phase in each recording"}}};
}

Planted one_of(int what, double size, const Plan& plan, double epoch_us, Random& random) {
  const int j = random.below(kJoints);
  switch (what) {
    case 0:
      return servo_lag(j, size, random);
    case 1:
      return joint_compliance(j, size, random);
    case 2:
      return joint_lost_motion(j, size, random);
    case 3:
      return ripple(j, 2, size, random);
    case 4:
      return ripple(j, 1, size, random);
    case 5:
      return joint_eccentricity(j, size, random);
    case 6:
      return link_geometry(size, random);
    case 7:
      return thermal_growth(size, random);
    case 8:
      return path_smoothing(size, random);
    case 9:
      return tool_offset(size, random);
    case 10:
      return slip(true, size, plan, epoch_us, random);
    case 11:
      return slip(false, size, plan, epoch_us, random);
    default:
      return structural_vibration(size, random);
  }
}
constexpr int kKinds = 13, kBallSlip = 10;

}  // namespace

Kind kind_named(const std::string& name) {
  if (name == "main") return {};
  if (name == "null") return {.none = true};
  if (name == "weak") return {.size = 0.12};
  if (name == "noisy") return {.noise = 5.0};
  if (name == "clutter") return {.background_least_um = 1.0, .background_most_um = 2.0};
  if (name == "heavy-clutter") return {.background_least_um = 4.0, .background_most_um = 6.0};
  if (name == "outside") return {.outside = true};
  if (name == "slip") return {.only = "ball_slip"};
  if (name == "mujoco") return {.engine = true};
  if (name == "p0") return {.plan = "P0"};
  if (name == "p3") return {.plan = "P3"};
  throw std::invalid_argument("no kind '" + name + "'");
}

Physics always_present(Random& random) {
  Physics p;
  for (double& offset : p.zero_offset) offset = random.normal(1.5e-3);
  const auto about = [&](double sigma) {
    return std::clamp(random.normal(sigma), -2.5 * sigma, 2.5 * sigma);
  };
  p.masses = {.upper_arm = 1.0 + about(0.1),
              .forearm = 1.0 + about(0.1),
              .wrist = 1.0 + about(0.1),
              .upper_arm_off = about(0.010),
              .forearm_off = about(0.010),
              .payload_off = about(0.010)};
  return p;
}

std::vector<Planted> draw_effects(const Kind& kind, const Plan& plan, double epoch_us, Random& random) {
  const double share = random.uniform(0.0, 1.0);
  int count = share < 0.20 ? 0 : share < 0.65 ? 1 : share < 0.90 ? 2 : 3;
  if (kind.none || kind.outside) count = 0;
  if (kind.background_most_um > 0.0 && count == 0) count = 1;
  if (!kind.only.empty()) count = 1;
  std::vector<Planted> planted;
  while (static_cast<int>(planted.size()) < count) {
    const int what = kind.only.empty() ? random.below(kKinds) : kBallSlip;
    Planted next = one_of(what, kind.size, plan, epoch_us, random);
    const bool twice = std::any_of(planted.begin(), planted.end(), [&](const Planted& p) {
      return p.answer["effect"] == next.answer["effect"] && p.answer["joint"] == next.answer["joint"];
    });
    if (!twice) planted.push_back(std::move(next));
  }
  return planted;
}

std::vector<Planted> draw_for_engine(Random& random) {
  const double share = random.uniform(0.0, 1.0);
  const int count = share < 0.15 ? 0 : share < 0.55 ? 1 : share < 0.90 ? 2 : 3;
  const std::array<std::size_t, 4> row = {1, 2, 3, 3};
  std::vector<Planted> planted;
  while (static_cast<int>(planted.size()) < count) {
    const int what = random.below(8);
    Planted next;
    if (what < 3) {
      next = joint_compliance(random.below(kJoints), 1.0, random);
      next.answer.erase("note");
    } else if (what < 6) {
      next = backlash(std::array{0, 3, 4}[static_cast<std::size_t>(random.below(3))], 1.0, random);
    } else if (what < 7) {
      const int which = random.below(4);
      const double off = random.sign() * random.log_uniform(1e-4, 1e-3);
      const std::size_t at = row[static_cast<std::size_t>(which)];
      next = {[=](Physics& p) { (which < 3 ? p.geometry.a : p.geometry.d)[at] += off; },
              {{"effect", "link_geometry"},
               {"joint", at + 1},
               {"parameters", ordered_json::array({parameter(which < 3 ? "a_mm" : "d_mm", 1e3 * off)})},
               {"accept_joint", {at + 1, at}}}};
    } else {
      next = tool_offset(1.0, random);
    }
    // A gap's friction would wind up a spring of the same joint: lost motion wider than the gap.
    const bool twice = std::any_of(planted.begin(), planted.end(), [&](const Planted& p) {
      return p.answer["joint"] == next.answer["joint"] &&
             (p.answer["effect"] == next.answer["effect"] || next.answer["effect"] != "link_geometry");
    });
    if (!twice) planted.push_back(std::move(next));
  }
  return planted;
}

Outsider draw_outsider(const std::vector<std::pair<double, double>>& visited, Random& random) {
  using Shape = Strange::Shape;
  const Shape shape = std::array{Shape::kBump, Shape::kRipple, Shape::kSpeed,
                                 Shape::kTorqueSquared}[static_cast<std::size_t>(random.below(4))];
  Outsider result;
  Strange& s = result.strange;
  s.shape = shape;
  s.joint = shape == Shape::kTorqueSquared ? std::array{1, 2, 4}[static_cast<std::size_t>(random.below(3))]
                                           : random.below(kJoints);
  const auto [low, high] = visited[static_cast<std::size_t>(s.joint)];
  s.amplitude = shape == Shape::kRipple ? 1.0 : random.sign();
  s.at = random.uniform(0, 2 * std::numbers::pi);
  result.answer = {{"effect", "not_in_catalogue"}, {"joint", s.joint + 1}};
  switch (shape) {
    case Shape::kBump:
      s.at = low + (high - low) * random.uniform(0.2, 0.8);
      s.width = random.uniform(1.5, 4.0) * kRad;
      result.answer["driver"] = "angle";
      result.answer["shape"] = "bump";
      result.answer["at_deg"] = s.at / kRad;
      result.answer["sigma_deg"] = s.width / kRad;
      break;
    case Shape::kRipple:
      s.width = 12 + random.below(24);
      result.answer["driver"] = "angle";
      result.answer["shape"] = "ripple";
      result.answer["cycles_per_turn"] = s.width;
      result.answer["accept_effect"] = {"transmission_error"};
      break;
    case Shape::kSpeed:
      result.answer["driver"] = "velocity";
      result.answer["shape"] = "|joint velocity|";
      break;
    case Shape::kTorqueSquared:
      result.answer["driver"] = "torque";
      result.answer["shape"] = "torque squared";
      break;
  }
  return result;
}

Physics draw_background(Random& random) {
  Physics p;
  for (std::size_t j = 0; j < kJoints; ++j) {
    const int joint = static_cast<int>(j);
    p.compliance[j] = std::abs(random.normal(j < 3 ? 4e-6 : 2e-5));
    p.windup_half[j] = std::abs(random.normal(6 * kMicro));
    p.lag[j] = std::abs(random.normal(0.3e-3));
    for (const double rate : {1.0, 2.0})
      p.ripples.push_back({joint, rate * kGear[j], std::abs(random.normal(5 * kMicro)),
                           random.uniform(0, 2 * std::numbers::pi)});
    p.eccentricities.push_back(
        {joint, 1, std::abs(random.normal(30 * kMicro)), random.uniform(0, 2 * std::numbers::pi)});
    p.geometry.alpha[j + 1] = random.normal(1e-4);
  }
  for (const std::size_t row : {1U, 2U, 3U}) p.geometry.a[row] = random.normal(0.03e-3);
  p.geometry.d[3] = random.normal(0.03e-3);
  p.geometry.beta[2] = random.normal(1e-4);
  return p;
}

Physics with_background(Physics p, const Physics& b, double factor) {
  for (std::size_t j = 0; j < 6; ++j) {
    p.compliance[j] += factor * b.compliance[j];
    p.windup_half[j] += factor * b.windup_half[j];
    p.lag[j] += factor * b.lag[j];
    p.geometry.a[j] += factor * b.geometry.a[j];
    p.geometry.d[j] += factor * b.geometry.d[j];
    p.geometry.alpha[j] += factor * b.geometry.alpha[j];
    p.geometry.beta[j] += factor * b.geometry.beta[j];
  }
  for (Ripple r : b.ripples) {
    r.amplitude *= factor;
    p.ripples.push_back(r);
  }
  for (Ripple r : b.eccentricities) {
    r.amplitude *= factor;
    p.eccentricities.push_back(r);
  }
  return p;
}

}  // namespace blind
