#include "plan.hpp"

#include <cmath>
#include <cstdio>
#include <sstream>
#include <stdexcept>

namespace blind {
namespace {

const Vector3d kPlaceA(380, -320, -251), kPlaceB(380, 320, -251), kZ(390, 0, -120), kH(330, -150, -230);
const Vector3d kUp(0, 0, 1), kX(1, 0, 0), kY(0, 1, 0);
const Vector3d kDown(180, 0, 0);
constexpr double kFast = 180.0, kHeavy = 3.0;
const double kSin = 0.5, kCos = std::sqrt(0.75);

Test circle(std::string name, const Vector3d& centre, const Vector3d& tool_rpy) {
  Test test;
  test.name = std::move(name);
  test.centre_mm = centre;
  test.normal = kUp;
  test.first_axis = kX;
  test.tool_rpy_deg = tool_rpy;
  return test;
}

/// Plane and tool turned together by +-30 deg: `about` "x" or "y".
Test tilted(std::string name, const Vector3d& centre, char about, double sign) {
  Test test =
      circle(std::move(name), centre, about == 'y' ? Vector3d(180, 30 * sign, 0) : Vector3d(180, 0, 0));
  if (about == 'y') {
    test.normal = {sign * kSin, 0, kCos};
    test.first_axis = {kCos, 0, -sign * kSin};
  } else {
    test.normal = {0, -sign * kSin, kCos};
    test.tool_rpy_deg.x() = sign > 0 ? -150 : 150;
  }
  return test;
}

Test heavy(Test test, double kg = kHeavy) {
  test.payload_kg = kg;
  return test;
}

Test fast(Test test) {
  test.feed_mm_s = kFast;
  return test;
}

Test named(std::string name, Test test) {
  test.name = std::move(name);
  return test;
}

Test arc(std::string name, const Vector3d& normal, const Vector3d& first) {
  Test test = circle(std::move(name), kZ, {180, 30, 0});
  test.normal = normal;
  test.first_axis = first;
  test.start_deg = -20;
  test.sweep_deg = 220;
  return test;
}

std::vector<Test> minimal() {
  const Test steep = tilted("A3", kPlaceA, 'y', -1);
  const Test tipped = circle("A6", kPlaceA, {180, 30, 0});
  return {circle("A", kPlaceA, kDown),
          named("A2", fast(steep)),
          steep,
          named("A4", heavy(tipped)),
          heavy(tilted("A5", kPlaceA, 'x', 1)),
          tipped,
          tilted("B", kPlaceB, 'x', -1)};
}

std::vector<Test> wide() {
  std::vector<Test> tests;
  for (const auto& [letter, centre] : {std::pair{"A", kPlaceA}, std::pair{"B", kPlaceB}}) {
    const std::string name = letter;
    const Test flat = circle(name, centre, kDown);
    tests.push_back(flat);
    tests.push_back(named(name + "2", heavy(flat)));
    tests.push_back(named(name + "3", fast(flat)));
  }
  tests.push_back(tilted("A4", kPlaceA, 'y', -1));
  tests.push_back(named("A5", heavy(tests.back())));
  tests.push_back(tilted("A6", kPlaceA, 'x', 1));
  tests.push_back(named("A7", heavy(tests.back())));
  tests.push_back(tilted("B4", kPlaceB, 'x', -1));
  tests.push_back(tilted("B5", kPlaceB, 'y', -1));
  tests.push_back(circle("Z", kZ, {180, 30, 0}));
  tests.push_back(named("Z2", heavy(tests.back())));
  tests.push_back(arc("Z3", kX, kY));
  tests.push_back(arc("Z4", kY, -kX));
  return tests;
}

std::vector<Test> held_out() {
  Test second = circle("H2", kH, {-159.353103513, 14.076095422, 5.236189386});
  second.normal = {0.258819045102521, -0.330366089549352, 0.907673371190369};
  second.first_axis = {0.965925826289068, 0.088521326901377, -0.243210346801694};
  second.radius_mm = 80;
  second.feed_mm_s = 100;
  return {circle("H", kH, {180, 20, 0}), heavy(second, 2.0)};
}

struct Frame {
  Vector3d e1, e2;
};

Frame frame(const Test& test) {
  const Vector3d n = test.normal.normalized();
  const Vector3d e1 = (test.first_axis - test.first_axis.dot(n) * n).normalized();
  return {e1, n.cross(e1)};
}

Eigen::Matrix3d orientation(const Test& test) {
  const Vector3d rpy = test.tool_rpy_deg * kRad;
  return (Eigen::AngleAxisd(rpy.z(), Vector3d::UnitZ()) * Eigen::AngleAxisd(rpy.y(), Vector3d::UnitY()) *
          Eigen::AngleAxisd(rpy.x(), Vector3d::UnitX()))
      .toRotationMatrix();
}

std::string number(double value) {
  std::array<char, 32> text{};
  std::snprintf(text.data(), text.size(), "%.15g", value == 0.0 ? 0.0 : value);
  return text.data();
}

std::string three(const Vector3d& v) {
  return "[" + number(v.x()) + ", " + number(v.y()) + ", " + number(v.z()) + "]";
}

}  // namespace

Plan plan(const std::string& name) {
  Plan result;
  result.name = name;
  bool again = true;
  if (name == "PM") {
    result.tests = minimal();
  } else if (name == "P0") {
    result.tests = {circle("A", kPlaceA, kDown), circle("B", kPlaceB, kDown)};
    again = false;
  } else if (name == "P3") {
    result.tests = wide();
  } else {
    throw std::invalid_argument("no plan '" + name + "'");
  }
  double minute = 0.0;
  const auto pair = [&](int test, int first_repetition, bool last) {
    for (const int direction : {1, -1}) {
      for (const int k : {0, 1})
        result.recordings.push_back({.test = test,
                                     .direction = direction,
                                     .repetition = first_repetition + k,
                                     .minute = minute + 1.2 * k,
                                     .held_out = last});
      minute += 3.0;
    }
  };
  const int fitted = static_cast<int>(result.tests.size());
  for (int i = 0; i < fitted; ++i) pair(i, 1, false);
  if (again) {
    minute += 40.0;
    pair(0, 3, false);
  }
  minute += 17.0;
  for (const Test& test : held_out()) result.tests.push_back(test);
  pair(fitted, 1, true);
  pair(fitted + 1, 1, true);
  return result;
}

Sampling sampling(const Test& test) {
  const double turn = 2.0 * std::numbers::pi * test.radius_mm / test.feed_mm_s;
  Sampling s;
  s.joints_per_turn = 100 * std::max(1, static_cast<int>(std::lround(turn / 1.62)));
  const double bars = 4.0 * s.joints_per_turn;
  s.bar_period = turn / bars;
  s.before = static_cast<int>(std::lround(bars * kOvershootDeg / 360.0));
  s.arc = static_cast<int>(std::lround(bars * test.sweep_deg / 360.0));
  return s;
}

std::vector<Joints> command(const Test& test, int direction, double first_time, double step,
                            std::size_t count) {
  const Sampling s = sampling(test);
  const Frame at = frame(test);
  const Eigen::Matrix3d tool = orientation(test);
  const double turn = 2.0 * std::numbers::pi * test.radius_mm / test.feed_mm_s;
  const double over = 2.0 * std::numbers::pi * s.before * s.bar_period / turn;
  const double begin =
      direction > 0 ? test.start_deg * kRad - over : (test.start_deg + test.sweep_deg) * kRad + over;
  std::vector<Joints> way(count);
  Joints near{};
  for (std::size_t k = 0; k < count; ++k) {
    const double time = first_time + step * static_cast<double>(k);
    const double angle = begin + direction * 2.0 * std::numbers::pi * time / turn;
    const Vector3d point =
        1e-3 * (test.centre_mm + test.radius_mm * (std::cos(angle) * at.e1 + std::sin(angle) * at.e2));
    near = way[k] = inverse(point, tool, near);
  }
  return way;
}

Joints at_centre(const Test& test) { return inverse(1e-3 * test.centre_mm, orientation(test), {}); }

std::string configuration(const Plan& plan, bool fanuc, const std::string& joints) {
  std::ostringstream out;
  out << "# Generated recording. Robot: FANUC LR Mate 200iC with ball and bar, simulated; other figures are "
         "assumptions.\n"
         "# The ball stays where it is for all tests with the same centre; it is set anew where the centre "
         "changes.\n"
      << "# JOINTS: " << joints << (joints == "commanded" ? " angles" : "") << ".\n\n"
      << "[[robot]]\nname = \"lrmate-1\"\nurdf = \"lrmate200ic.urdf\"            # beside this file\n"
      << "base = \"base\"\ntip = \"tcp\"\n"
      << "joint_convention = "
      << (fanuc ? "\"fanuc\"      # J3 on the wire is the teach pendant's: J3 of the URDF chain = J3 + J2"
                : "\"serial\"      # joint angles on the wire are those of the URDF chain")
      << "\ngear_ratio = [120, 121, 100, 80, 80, 50]\npayload_kg = 0.438\npayload_com_mm = [0, 0, 50]\n";
  for (const Test& test : plan.tests)
    out << "\n[[robot.test]]\nname = \"" << test.name
        << "\"\nkind = \"circle\"\ncentre_mm = " << three(test.centre_mm)
        << "\nnormal = " << three(test.normal) << "\nfirst_axis = " << three(test.first_axis)
        << "\narc_deg = [" << number(test.start_deg) << ", " << number(test.sweep_deg)
        << "]\novershoot_deg = " << number(kOvershootDeg) << "\nradius_mm = " << number(test.radius_mm)
        << "\nfeed_mm_s = " << number(test.feed_mm_s) << "\ntool_rpy_deg = " << three(test.tool_rpy_deg)
        << "\npayload_kg = " << number(test.payload_kg) << "\n";
  return out.str();
}

}  // namespace blind
