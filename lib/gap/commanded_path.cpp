#include "gap/commanded_path.hpp"

#include <Eigen/Geometry>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <functional>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/error.hpp"
#include "core/units.hpp"
#include "kinematics/inverse.hpp"
#include "metrology/arc.hpp"
#include "numerics/vector3.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kCircleRamp = 0.5;   // [s] of rising feed, where the overshoot is long enough
constexpr double kLineRamp = 0.1;     // [s]
constexpr double kMostSamples = 1e6;  // of a path
constexpr double kWholeTurn = kTurn - 1e-9;
constexpr double kAlike = 0.3;  // of the largest: joints that share the blame for a singularity

/// A way from rest to rest: the feed rises and falls as a polynomial whose acceleration has no step either.
struct Travel {
  double length = 0.0;  ///< [m]
  double feed = 0.0;    ///< [m/s]
  double ramp = 0.0;    ///< [s] rising, and again falling; 0: at feed from end to end

  double duration() const { return length / feed + ramp; }
  double rising(double t) const {
    const double u = t / ramp;
    return feed * ramp * u * u * u * u * (2.5 - 3.0 * u + u * u);
  }
  /// [m] from the start, at t [s] after it.
  double at(double t) const {
    t = std::clamp(t, 0.0, duration());
    if (ramp > 0.0 && t < ramp) return rising(t);
    if (ramp > 0.0 && duration() - t < ramp) return length - rising(duration() - t);
    return feed * (t - 0.5 * ramp);
  }
};

/// One decimal, as people read an angle or a place.
std::string tenths(double value) {
  std::string text = std::to_string(std::round(value * 10.0) / 10.0);
  text.erase(text.find('.') + 2);
  return text == "-0.0" ? "0.0" : text;
}

std::string joint_name(const RobotModel& model, int joint) {
  return "J" + std::to_string(joint) + " (" + model.limits()[static_cast<std::size_t>(joint - 1)].name + ")";
}

/// The joints that turn against each other without moving the tool: "J4 and J6".
std::string stuck_joints(const RobotModel& model, std::span<const double> q) {
  const Jacobian jacobian = model.jacobian(q);
  const Eigen::MatrixXd dense = jacobian;
  const Eigen::JacobiSVD<Eigen::MatrixXd> svd(dense, Eigen::ComputeFullV);
  const VectorXd weakest = svd.matrixV().col(std::min<Index>(5, model.joints() - 1)).cwiseAbs();
  std::vector<int> joints;
  for (Index i = 0; i < weakest.size(); ++i)
    if (weakest[i] > kAlike * weakest.maxCoeff()) joints.push_back(static_cast<int>(i) + 1);
  std::string text;
  for (std::size_t i = 0; i < joints.size(); ++i)
    text += (i == 0 ? "J" : i + 1 == joints.size() ? " and J" : ", J") + std::to_string(joints[i]);
  return text;
}

/// What stands in the way of one pose, as an error that names it.
/// @param q  robot's joint convention, at or next to that pose
Error obstacle(const RobotModel& model, const TestSpec& test, const std::string& place, IkStatus status,
               int joint, std::span<const double> q) {
  const std::string begin = "test '" + test.name + "': " + place + " ";
  const std::string where = test.kind == TestKind::kCircle ? "centre_mm" : "start_mm and end_mm";
  if (status == IkStatus::kLimit) {
    const JointLimit& limit = model.limits()[static_cast<std::size_t>(joint - 1)];
    return {Cause::kInput, begin + joint_name(model, joint) + " would pass its limits of " +
                               tenths(to_deg(limit.lower)) + " to " + tenths(to_deg(limit.upper)) +
                               " deg in the chain; move " + where +
                               ", or hold the tool otherwise (tool_rpy_deg, posture_deg)"};
  }
  if (status == IkStatus::kSingular)
    return {Cause::kInput, begin + "the arm is singular: " + stuck_joints(model, q) +
                               " turn against each other; tilt the tool by 15 deg or more (tool_rpy_deg), or "
                               "move " +
                               where};
  return {Cause::kInput,
          begin + "no joint angles bring the tool there; move " + where + " towards the robot's reach" +
              (test.kind == TestKind::kCircle ? ", lessen radius_mm" : "") + ", or look at tool_rpy_deg"};
}

std::span<const double> posture_of(const RobotModel& model, const TestSpec& test) {
  if (!test.posture.empty() && test.posture.size() != static_cast<std::size_t>(model.joints()))
    throw Error(Cause::kInput, "test '" + test.name + "': 'posture_deg' holds " +
                                   std::to_string(test.posture.size()) + " angles, the chain has " +
                                   std::to_string(model.joints()) + " joints");
  return test.posture;
}

/// Joint angles of the path; what is in its way becomes an error.
/// @param place  how an error names sample i
Eigen::MatrixXd chain_angles(const RobotModel& model, const TestSpec& test, const Eigen::Matrix3Xd& points,
                             const std::function<std::string(Index)>& place) {
  const std::span<const double> posture = posture_of(model, test);
  std::vector<Isometry3d> poses(static_cast<std::size_t>(points.cols()), Isometry3d::Identity());
  const Eigen::Matrix3d orientation = tool_orientation(model, test);
  for (Index i = 0; i < points.cols(); ++i) {
    poses[static_cast<std::size_t>(i)].linear() = orientation;
    poses[static_cast<std::size_t>(i)].translation() = points.col(i);
  }
  PathResult path = solve_path(model, poses, posture);
  if (path.status != IkStatus::kOk) {
    const auto failed = static_cast<std::size_t>(path.index);
    const std::vector<double> near = path.index == 0 ? inverse(model, poses[0], posture).q
                                                     : std::vector<double>(path.q.col(path.index - 1).begin(),
                                                                           path.q.col(path.index - 1).end());
    throw obstacle(model, test, place(static_cast<Index>(failed)), path.status, path.joint, near);
  }
  for (Index i = 0; i < path.q.cols(); ++i)
    model.to_chain({path.q.col(i).data(), static_cast<std::size_t>(path.q.rows())});
  return std::move(path.q);
}

/// A feed that is a slip of the pen must not fill the memory.
void check_length(const TestSpec& test, double duration, double rate) {
  if (duration * rate <= kMostSamples) return;
  throw Error(Cause::kInput, "test '" + test.name + "': at its feed it takes " + tenths(duration / 3600.0) +
                                 " hours, of " + tenths(rate) +
                                 " samples a second; raise feed_mm_s (or lessen points)");
}

void check(const TestSpec& test, TestKind kind, int direction, double feed, double rate) {
  if (test.kind != kind || (direction != 1 && direction != -1) || !(feed > 0.0) || !(rate > 0.0) ||
      !std::isfinite(feed) || !std::isfinite(rate))
    throw std::invalid_argument("commanded path: direction is +1 or -1, feed and rate are above 0");
}

}  // namespace

Eigen::Matrix3d tool_orientation(const RobotModel& model, const TestSpec& test) {
  if (test.tool_rpy) return tool_pose({}, *test.tool_rpy).linear();
  const std::span<const double> posture = posture_of(model, test);
  if (posture.empty())
    throw Error(Cause::kInput, "test '" + test.name +
                                   "': how the tool is held is not configured; give tool_rpy_deg (or "
                                   "posture_deg, whose orientation is kept)");
  return model.forward(posture).linear();
}

Eigen::VectorXd commanded_posture(const RobotModel& model, const TestSpec& test, const Vector3d& place,
                                  const std::string& what) {
  Isometry3d pose = Isometry3d::Identity();
  pose.linear() = tool_orientation(model, test);
  pose.translation() = place;
  IkResult found = inverse(model, pose, posture_of(model, test));
  if (found.status != IkStatus::kOk && found.status != IkStatus::kSingular)
    throw obstacle(model, test, what, found.status, found.joint, found.q);
  model.to_chain(found.q);
  return Eigen::Map<const VectorXd>(found.q.data(), model.joints());
}

CommandedPath commanded_circle(const RobotModel& model, const TestSpec& test, int direction, double feed,
                               double rate) {
  check(test, TestKind::kCircle, direction, feed, rate);
  const CircleSpec& circle = test.circle;
  const CirclePlane plane = plane_of(circle);
  const double lead = circle.overshoot * circle.radius;
  // Half of the overshoot at most: the other half is there for the joints to settle.
  const Travel travel{circle.arc_sweep * circle.radius + 2.0 * lead, feed,
                      std::min(kCircleRamp, lead / feed)};
  check_length(test, travel.duration(), rate);
  const double entry = lead / feed + 0.5 * travel.ramp;
  const auto before = static_cast<Index>(std::floor(entry * rate + 1e-9));
  const auto after = static_cast<Index>(std::floor((travel.duration() - entry) * rate + 1e-9));
  const double from = direction > 0 ? circle.arc_start - circle.overshoot
                                    : circle.arc_start + circle.arc_sweep + circle.overshoot;
  CommandedPath path;
  const bool whole_turn = circle.arc_sweep > kWholeTurn;
  const auto on_arc = static_cast<Index>(std::floor(circle.arc_sweep * circle.radius / feed * rate + 1e-9));
  path.arc_begin = before;
  path.arc_end = before + on_arc + (whole_turn ? 0 : 1);
  path.duration = travel.duration();
  path.motion.time =
      (VectorXd::LinSpaced(before + after + 1, 0.0, static_cast<double>(before + after)).array() -
       static_cast<double>(before)) /
          rate +
      entry;
  path.angle.resize(path.motion.time.size());
  path.points.resize(3, path.motion.time.size());
  for (Index i = 0; i < path.angle.size(); ++i) {
    path.angle[i] = from + direction * travel.at(path.motion.time[i]) / circle.radius;
    path.points.col(i) = plane.centre + circle.radius * (std::cos(path.angle[i]) * plane.e1 +
                                                         std::sin(path.angle[i]) * plane.e2);
  }
  path.motion.q = chain_angles(model, test, path.points, [&](Index i) {
    const double turned = to_deg(path.angle[i]);
    return "at " + tenths(turned - 360.0 * std::floor(turned / 360.0)) + " deg of the circle";
  });
  return path;
}

CommandedPath commanded_line(const RobotModel& model, const TestSpec& test, int direction, double feed,
                             double dwell, double rate) {
  check(test, TestKind::kLine, direction, feed, rate);
  if (!(dwell >= 0.0)) throw std::invalid_argument("commanded path: dwell is not below 0");
  const int points = test.line.points;
  if (points < 2)
    throw Error(Cause::kInput, "test '" + test.name + "': give 'points', the number of stops on the line");
  const Vector3d start = vector_of(test.line.start);
  const Vector3d way = vector_of(test.line.end) - start;
  const double step = way.norm() / (points - 1);
  const Travel travel{step, feed, std::min(kLineRamp, step / feed)};
  const double cycle = dwell + travel.duration();
  check_length(test, dwell + (points - 1) * cycle, rate);
  CommandedPath path;
  path.duration = dwell + (points - 1) * cycle;
  path.stop_end.resize(points);
  path.stop_position.resize(points);
  const auto from_start = [&](double driven) { return direction > 0 ? driven : way.norm() - driven; };
  for (int k = 0; k < points; ++k) {
    path.stop_end[k] = dwell + k * cycle;
    path.stop_position[k] = from_start(k * step);
  }
  const auto samples = static_cast<Index>(std::floor(path.duration * rate + 1e-9)) + 1;
  path.motion.time = VectorXd::LinSpaced(samples, 0.0, static_cast<double>(samples - 1)) / rate;
  path.position.resize(samples);
  path.points.resize(3, samples);
  for (Index i = 0; i < samples; ++i) {
    const double t = path.motion.time[i];
    const int stop = std::min(static_cast<int>(t / cycle), points - 1);
    path.position[i] = from_start(stop * step + travel.at(t - stop * cycle - dwell));
    path.points.col(i) = start + way * (path.position[i] / way.norm());
  }
  path.motion.q = chain_angles(model, test, path.points, [&](Index i) {
    return "at " + tenths(to_mm(path.position[i])) + " mm of the line";
  });
  return path;
}

}  // namespace ballbar
