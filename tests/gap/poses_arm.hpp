#pragma once
/// Made poses of an arm: kinematics, gravity and errors of their own, by 4x4 matrices; nothing of lib/ but
/// the plain structs.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <cmath>
#include <functional>
#include <numbers>
#include <random>
#include <string>
#include <vector>

#include "core/poses.hpp"
#include "core/spec.hpp"
#include "kinematics/robot_model.hpp"

namespace ballbar::test {

inline constexpr double kRad = std::numbers::pi / 180.0;
using Angles = std::array<double, 6>;

/// Lengths [m] and one mass in the forearm [kg].
struct Arm {
  double a1 = 0.075, a2 = 0.300, a3 = 0.075, d4 = 0.320, d6 = 0.080;
  double mass = 12.0;
  Angles zero{};   ///< [rad] to be added to what the encoders say
  double al1 = 0;  ///< [rad] J2 tilted against J1

  using T = Eigen::Transform<double, 3, Eigen::Affine>;
  static T turn(double angle, const Eigen::Vector3d& axis) { return T(Eigen::AngleAxisd(angle, axis)); }
  static T shift(double x, double y, double z) { return T(Eigen::Translation3d(x, y, z)); }

  T forearm(const Angles& q) const {
    const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY(),
                          z = Eigen::Vector3d::UnitZ();
    return turn(q[0] + zero[0], z) * turn(al1, x) * shift(a1, 0, 0) * turn(q[1] + zero[1], y) *
           shift(0, 0, a2) * turn(-q[2] - zero[2], y);
  }
  /// The flange with x out of it.
  T flange(const Angles& q) const {
    const Eigen::Vector3d x = Eigen::Vector3d::UnitX(), y = Eigen::Vector3d::UnitY();
    return forearm(q) * shift(d4, 0, a3) * turn(-q[3] - zero[3], x) * turn(-q[4] - zero[4], y) *
           shift(d6, 0, 0) * turn(-q[5] - zero[5], x);
  }
  double potential(const Angles& q) const {
    return mass * 9.80665 * (forearm(q) * shift(0.15, 0, 0.05)).translation().z();
  }
  /// [Nm] that joint j must give to hold the arm.
  double torque(const Angles& q, std::size_t j) const {
    Angles up = q, down = q;
    up[j] += 1e-5;
    down[j] -= 1e-5;
    return (potential(up) - potential(down)) / 2e-5;
  }
};

/// The same arm as a URDF; `tool0` has z out of the flange.
inline std::string arm_urdf() {
  const auto joint = [](int n, const std::string& xyz, const std::string& axis) {
    return "<joint name=\"j" + std::to_string(n) + "\" type=\"revolute\"><origin xyz=\"" + xyz +
           "\"/><parent link=\"l" + std::to_string(n - 1) + "\"/><child link=\"l" + std::to_string(n) +
           "\"/><axis xyz=\"" + axis +
           "\"/><limit lower=\"-6.3\" upper=\"6.3\" velocity=\"3\" effort=\"0\"/></joint>";
  };
  std::string text =
      "<robot name=\"arm\"><link name=\"l0\"/><link name=\"l1\"/><link name=\"l2\"/><link "
      "name=\"l3\"><inertial>"
      "<origin xyz=\"0.15 0 0.05\"/><mass value=\"12\"/><inertia ixx=\"1e-3\" ixy=\"0\" ixz=\"0\" "
      "iyy=\"1e-3\" "
      "iyz=\"0\" izz=\"1e-3\"/></inertial></link><link name=\"l4\"/><link name=\"l5\"/><link name=\"l6\"/>"
      "<link name=\"tool0\"/>";
  text += joint(1, "0 0 0", "0 0 1") + joint(2, "0.075 0 0", "0 1 0") + joint(3, "0 0 0.3", "0 -1 0") +
          joint(4, "0 0 0.075", "-1 0 0") + joint(5, "0.32 0 0", "0 -1 0") + joint(6, "0.08 0 0", "-1 0 0");
  return text +
         "<joint name=\"f\" type=\"fixed\"><origin xyz=\"0 0 0\" rpy=\"3.141592653589793 -1.5707963267948966 "
         "0\"/>"
         "<parent link=\"l6\"/><child link=\"tool0\"/></joint></robot>";
}

inline RobotModel arm_model() { return {arm_urdf(), "l0", "tool0", JointConvention::kSerial}; }

/// What a case changes. Angles are the motors'.
struct MadeError {
  Arm arm{};
  std::function<double(std::size_t joint, const Angles& q, const Angles& before)>
      angle{};  ///< link minus motor [rad]
  std::function<double(double read, double before, std::size_t joint)>
      reading{};                                                           ///< what the controller says
  std::function<Eigen::Vector3d(int row, double seconds)> displacement{};  ///< [m] in the base frame
  bool commands = false;  ///< the file has the motors' true angles as c1_deg..
};

struct MadeSet {
  int poses = 240;
  double noise = 20e-6;  ///< [m] per coordinate
  int repeats = 1;
  bool lengths = false;
  bool both_sides = false;  ///< every pose from + and from -
  bool hold_out = true;     ///< every fifth pose by the column held_out
  unsigned seed = 7;
};

/// std::normal_distribution is not the same everywhere: a sum of twelve.
inline double normal(std::mt19937& random) {
  double sum = -6.0;
  for (int i = 0; i < 12; ++i) sum += static_cast<double>(random()) / 4294967296.0;
  return sum;
}

inline PoseSet make_poses(const MadeError& error, const MadeSet& made) {
  std::mt19937 random(made.seed);
  const auto uniform = [&](double least, double most) {
    return least + (most - least) * static_cast<double>(random()) / 4294967296.0;
  };
  const Eigen::Isometry3d frame = Eigen::Translation3d(1.2, -0.7, 0.3) *
                                  Eigen::AngleAxisd(0.8, Eigen::Vector3d(0.2, -0.5, 1.0).normalized());
  const Eigen::Vector3d tool(0.13, 0.04, 0.06), fixed(0.9, 0.5, 0.7);
  PoseSet set;
  set.lengths = made.lengths;
  Angles before{};
  for (int pose = 0; pose < made.poses; ++pose) {
    Angles q{uniform(-2.4, 2.4), uniform(-0.7, 1.4), uniform(-0.9, 1.9),
             uniform(-2.8, 2.8), uniform(-1.8, 1.8), uniform(-3.0, 3.0)};
    if (pose == 0) before = q;
    for (int side = made.both_sides ? -1 : 1; side <= 1; side += 2)
      for (int repeat = 0; repeat < made.repeats; ++repeat) {
        Angles link = q;
        const double seconds = 20.0 * static_cast<double>(set.poses.size());
        for (std::size_t j = 0; j < 6; ++j) {
          if (error.angle) link[j] += error.angle(j, q, before);
          if (made.both_sides && j == 1) link[j] -= 0.5 * side * 2.5e-4;  // lost motion of J2
        }
        Eigen::Vector3d point = error.arm.flange(link) * tool;
        const int row = static_cast<int>(set.poses.size()) + 1;
        if (error.displacement) point += error.displacement(row, seconds);
        Pose measured;
        measured.row = row;
        for (std::size_t j = 0; j < 6; ++j) {
          measured.joints.push_back(error.reading ? error.reading(q[j], before[j], j) : q[j]);
          if (error.commands) measured.command.push_back(q[j]);
        }
        measured.time = seconds;
        measured.held_out = made.hold_out && pose % 5 == 4;
        if (made.both_sides) measured.direction = side;
        measured.length = (point - fixed).norm() + made.noise * normal(random);
        const Eigen::Vector3d seen = frame * point;
        for (int k = 0; k < 3; ++k)
          measured.point[static_cast<std::size_t>(k)] = seen[k] + made.noise * normal(random);
        set.poses.push_back(measured);
      }
    before = q;
  }
  return set;
}

}  // namespace ballbar::test
