#include "gap/predict.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/error.hpp"
#include "gap/commanded_path.hpp"
#include "metrology/arc.hpp"
#include "metrology/line.hpp"
#include "numerics/interpolate.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::VectorXd;

constexpr double kCommandRate = 250.0;       // [1/s] of a command,
constexpr double kMostPredicted = 40'000.0;  // or lower, so that a slow one has so many: half a second's work
constexpr double kLeastLineRate = 20.0;      // [1/s] that still shows the stops of a line
constexpr double kDwell = 1.0;               // [s] at each point of a line: at rest
constexpr double kAtRest = 0.2;              // [s] before the end of a stop: nothing of the next move is seen
constexpr double kAnywhere = std::numeric_limits<double>::infinity();

Matrix3Xd nominal_points(const AsBuilt& robot, const Eigen::MatrixXd& q) {
  Matrix3Xd points(3, q.cols());
  for (Index i = 0; i < q.cols(); ++i)
    points.col(i) =
        robot.model().chain().forward({q.col(i).data(), static_cast<std::size_t>(q.rows())}).translation();
  return points;
}

double rate_for(double duration) { return std::min(kCommandRate, kMostPredicted / duration); }

}  // namespace

Conditions conditions_of(const Run& run) {
  Conditions conditions;
  conditions.payload = run.payload;
  conditions.series_known = false;
  conditions.start_us = run.started_us;
  return conditions;
}

Motion motion_of(const Run& run, const RobotModel& model) {
  const auto n = static_cast<Index>(run.joint_time.size());
  Motion motion;
  motion.time = Eigen::Map<const VectorXd>(run.joint_time.data(), n);
  motion.q = Eigen::Map<const Eigen::MatrixXd>(run.joint_position.data(), run.joints, n);
  for (Index i = 0; i < n; ++i)
    model.to_chain({motion.q.col(i).data(), static_cast<std::size_t>(run.joints)});
  return motion;
}

Matrix3Xd PredictedPath::points(const VectorXd& at) const {
  Matrix3Xd found = interpolate(along, nominal, at, widest, Interpolation::kCubic);
  found += interpolate(along, as_built - nominal, at, widest, Interpolation::kLinear);
  return found;
}

PredictedPath predict_from_joints(const Run& run, const AsBuilt& robot) {
  if (run.joints != robot.model().joints())
    throw std::invalid_argument("predict: the run's joints are not the model's");
  const Conditions conditions = conditions_of(run);
  const Motion said = motion_of(run, robot.model());
  const Matrix3Xd nominal = nominal_points(robot, said.q);
  if (robot.nominal()) return {said.time, nominal, nominal, kLongestJointGap};
  const Motion motor = robot.joints_are_commanded() ? robot.follow(said, conditions) : said;
  return {said.time, nominal, robot.tool_points(motor, conditions), kLongestJointGap};
}

PredictedPath predict_circle(const TestSpec& test, const AsBuilt& robot, int direction, double feed,
                             const Conditions& conditions, Seen seen) {
  const double way = test.circle.radius * (test.circle.arc_sweep + 2.0 * test.circle.overshoot);
  const CommandedPath path = commanded_circle(robot.model(), test, direction, feed, rate_for(way / feed));
  const Motion motor = robot.follow(path.motion, conditions);
  const Matrix3Xd reached =
      seen == Seen::kByMotors ? nominal_points(robot, motor.q) : robot.tool_points(motor, conditions);
  // At rest, at both ends, the angle does not move on: the first sample of each angle is the motion's.
  std::vector<Index> moving;
  for (Index i = 0; i < path.angle.size(); ++i)
    if (moving.empty() || direction * (path.angle[i] - path.angle[moving.back()]) > 1e-9) moving.push_back(i);
  return {direction * path.angle(moving), path.points(Eigen::all, moving), reached(Eigen::all, moving),
          kAnywhere};
}

Matrix3Xd predict_line(const TestSpec& test, const AsBuilt& robot, int direction, double feed,
                       const Conditions& conditions, const VectorXd& position) {
  const LineSpec& line = test.line;
  const double way =
      std::hypot(line.end[0] - line.start[0], line.end[1] - line.start[1], line.end[2] - line.start[2]);
  const double rate = rate_for(way / feed + line.points * kDwell);
  if (!(rate >= kLeastLineRate))
    throw Error(Cause::kInput, "test '" + test.name + "': the line is driven too slowly to be predicted");
  const CommandedPath path = commanded_line(robot.model(), test, direction, feed, kDwell, rate);
  const Motion motor = robot.follow(path.motion, conditions);
  const Matrix3Xd reached = robot.tool_points(motor, conditions);
  std::vector<Index> standing;  // a late sample of each stop: the robot has come to rest
  for (const double end : path.stop_end)
    standing.push_back(std::upper_bound(motor.time.begin(), motor.time.end(), end - kAtRest) -
                       motor.time.begin() - 1);
  const VectorXd along = direction * path.stop_position;
  VectorXd at = direction * position;
  for (double& place : at) {  // a reading at the end of the line is not beyond it by a rounding error
    const double inside = std::clamp(place, along.minCoeff(), along.maxCoeff());
    if (std::abs(place - inside) <= kSamePosition) place = inside;
  }
  return PredictedPath{along, path.points(Eigen::all, standing), reached(Eigen::all, standing), kAnywhere}
      .points(at);
}

}  // namespace ballbar
