#pragma once
/// Inside gap/ only: what proposed circles and lines have in common.

#include <Eigen/Core>
#include <functional>
#include <optional>
#include <string>

#include "gap/proposed_tests.hpp"

namespace ballbar {

inline constexpr double kLikelyFeed = 0.055;   // [m/s] where none is configured
inline constexpr std::size_t kMostPlaces = 2;  // that tests are planned about
inline constexpr double kFasterFeed = 2.0;     // times the feed
/// [deg] tried one after another.
inline constexpr double kPlannedTilts[] = {30.0, 20.0};

Vec3 vec3_of(const Eigen::Vector3d& v);

/// Angles of turns about the base's X, then Y, then Z.
Vec3 rpy_of(const Eigen::Matrix3d& r);

/// Of a turn about an axis of the base. @param angle  [rad]
Eigen::Matrix3d turn_about(int axis, double angle);

/// " tilted by -30 deg about Y". @param angle  [rad]
std::string tilt_words(int axis, double angle);

std::string joined(const std::string& a, const std::string& b);

/// No joint comes near its greatest speed.
bool within_joint_speeds(const RobotModel& model, const Motion& motion);

/// How the tool is held; nothing where that is not configured.
std::optional<Eigen::Matrix3d> known_tool_orientation(const RobotModel& model, const TestSpec& test);

/// [kg] of tests with payload: the heaviest configured one, or 2 kg more than the lightest.
double heavy_of(const RobotSpec& robot);

/// Gives names that neither the robot's tests nor those given before have: "A-1", "A-2".
class TestNames {
 public:
  explicit TestNames(const RobotSpec& robot) : robot_(robot) {}
  std::string next(const std::string& after);

 private:
  const RobotSpec& robot_;
  int number_ = 0;
};

/// A test as it is, with payload, and faster where it can be driven so.
/// @param heavy  [kg]
/// @param add    takes each, and what is changed of it; empty: nothing
void add_variants(const GapModel& model, const ProposedTest& plain, double heavy,
                  const std::function<bool(const TestSpec&)>& can_be_driven,
                  const std::function<void(ProposedTest, const std::string& more)>& add);

/// Nothing measured, and the noise of two laps.
/// @param sparser  times fewer readings than where the noise was seen
void leave_unmeasured(Observation& seen, const LapNoise& noise, double sparser);

}  // namespace ballbar
