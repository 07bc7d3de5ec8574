#pragma once
/// What is configured: robots and their tests, in SI units.

#include <array>
#include <map>
#include <optional>
#include <string>
#include <vector>

namespace ballbar {

using Vec3 = std::array<double, 3>;

enum class TestKind { kCircle, kLine };
enum class JointConvention {
  kSerial,  ///< joint angles as in the URDF chain
  kFanuc,   ///< J3 as on the teach pendant: J3 of the chain = J3 + J2
};

/// Where a virtual ballbar has its ball.
enum class VirtualCentre {
  kConfigured,  ///< at the circle's configured centre
  kFitted,      ///< at the least-squares centre of the arc that the joints drove, in the circle's plane
};

/// Angle 0 lies on first_axis made orthogonal to normal; + is counter-clockwise about normal.
struct CircleSpec {
  Vec3 centre{};             ///< [m] in the robot's base frame
  Vec3 normal{0, 0, 1};      ///< unit
  Vec3 first_axis{1, 0, 0};  ///< unit, orthogonal to normal
  double radius = 0.1;       ///< [m] nominal, = nominal bar length
  double arc_start = 0.0;    ///< [rad]
  double arc_sweep = 0.0;    ///< [rad] > 0, at most one turn
  double overshoot = 0.0;    ///< [rad] driven before and after the arc
};

struct LineSpec {
  Vec3 start{};  ///< [m] in the robot's base frame
  Vec3 end{};    ///< [m]
  int points = 0;
};

/// Of steel [1/K]: what R20 is made with where nothing else is configured (metrology.md 1.1).
inline constexpr double kSteelExpansion = 11.7e-6;

struct TestSpec {
  std::string name;
  TestKind kind = TestKind::kCircle;
  CircleSpec circle;                                          ///< where kind is kCircle
  LineSpec line;                                              ///< where kind is kLine
  VirtualCentre virtual_centre = VirtualCentre::kConfigured;  ///< circles
  std::optional<double> filter_upr;    ///< circles: Gaussian filter of the figures by ISO 230-4 [undulations
                                       ///< per revolution]; nothing: none
  double expansion = kSteelExpansion;  ///< circles: [1/K] for R20
  double feed = 0.0;                   ///< [m/s]
  std::optional<Vec3> tool_rpy;        ///< [rad] fixed-axis X, Y, Z
  std::optional<double> payload;       ///< [kg]
  std::vector<double> posture;  ///< [rad] joint angles in the robot's convention near which it stands, one
                                ///< per joint; empty: all zeros
};

/// Physics already known of a robot, as a diagnosis writes it. Parameters by their names with units.
struct EffectSpec {
  std::string effect;
  int joint = 0;  ///< from 1; 0 = none
  std::map<std::string, double> parameters;
  std::map<std::string, std::string> words;  ///< e.g. kind
};

struct RobotSpec {
  std::string name;
  std::string urdf_path;  ///< as configured, made absolute
  std::string base = "base";
  std::string tip = "tcp";
  JointConvention joint_convention = JointConvention::kSerial;
  bool joints_commanded = false;   ///< JOINTS are what is commanded, not what the motors' encoders read
  std::vector<double> gear_ratio;  ///< motor turns per joint turn; 0 = not known
  double payload = 0.0;            ///< [kg]
  Vec3 payload_com{};              ///< [m] from the flange, in tool0
  std::vector<TestSpec> tests;
  std::vector<EffectSpec> effects;

  const TestSpec* find_test(const std::string& test) const {
    for (const TestSpec& t : tests)
      if (t.name == test) return &t;
    return nullptr;
  }
};

}  // namespace ballbar
