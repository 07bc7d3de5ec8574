#include "gap/add_gap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "gap/compare.hpp"
#include "gap/predict.hpp"
#include "metrology/line.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::VectorXd;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kFeedTolerance = 0.1;  // of the driven feed

bool has_joints(const Run& run, const AsBuilt& robot) {
  return run.joints == robot.model().joints() && run.joint_time.size() > 1;
}

/// Samples of the arc whose angle is known.
std::vector<std::size_t> known_samples(const RunResult& result) {
  std::vector<std::size_t> known;
  for (std::size_t i = result.arc_begin; i < result.arc_end; ++i)
    if (std::isfinite(result.angle[i])) known.push_back(i);
  return known;
}

VectorXd pick(const std::vector<double>& values, const std::vector<std::size_t>& which) {
  VectorXd picked(static_cast<Index>(which.size()));
  for (std::size_t i = 0; i < which.size(); ++i) picked[static_cast<Index>(i)] = values[which[i]];
  return picked;
}

/// The programmed feed where the samples bear it out: a mark may say anything. Else that of the samples.
double feed_of(const Run& run, const CircleSpec& circle, const VectorXd& angle, const VectorXd& time) {
  const double turned = std::abs(angle[angle.size() - 1] - angle[0]);
  const double driven = circle.radius * turned / (time[time.size() - 1] - time[0]);
  return std::abs(run.feed - driven) <= kFeedTolerance * driven ? run.feed : driven;
}

/// The prediction of a circle at the bar's samples.
struct CirclePrediction {
  PredictedPath path;
  VectorXd at;        ///< where on the path each sample lies
  double rate = 1.0;  ///< of `at` per second
  bool has_shape = false;
};

CirclePrediction predict(const Run& run, const TestSpec& test, const AsBuilt& robot, const RunResult& result,
                         const VectorXd& angle, const VectorXd& time) {
  const bool made_of_joints = result.source == "joints";
  if (!made_of_joints && has_joints(run, robot))
    return {predict_from_joints(run, robot), time, 1.0, !robot.nominal()};
  const double feed = feed_of(run, test.circle, angle, time);
  if (!(feed > 0.0)) return {};
  return {predict_circle(test, robot, result.direction, feed, conditions_of(run),
                         made_of_joints ? Seen::kByMotors : Seen::kByInstrument),
          result.direction * angle, feed / test.circle.radius, !made_of_joints && !robot.nominal()};
}

/// Samples that the path holds, whatever the shift of the clocks.
std::vector<Index> predicted_samples(const CirclePrediction& prediction) {
  const double most = prediction.has_shape ? kLargestTimeShift * prediction.rate : 0.0;
  const Matrix3Xd early = prediction.path.points(prediction.at.array() - most);
  const Matrix3Xd late = prediction.path.points(prediction.at.array() + most);
  std::vector<Index> found;
  for (Index i = 0; i < prediction.at.size(); ++i)
    if (early.col(i).allFinite() && late.col(i).allFinite()) found.push_back(i);
  return found;
}

void add_circle(const Run& run, const TestSpec& test, const AsBuilt& robot, RunResult& result) {
  const std::vector<std::size_t> known = known_samples(result);
  if (known.size() < 4) return;
  const VectorXd angle = pick(result.angle, known);
  const VectorXd time = pick(run.bar_time, known);
  if (!(time[time.size() - 1] > time[0])) return;
  const CirclePrediction prediction = predict(run, test, robot, result, angle, time);
  const std::vector<Index> finite = predicted_samples(prediction);
  if (finite.size() < 4) return;
  const Conditions conditions = conditions_of(run);
  const Matrix3Xd ball = robot.ball_displacement(time(finite), conditions);
  // Of all readings: an effect may count them from the run's first one.
  const VectorXd all_times =
      Eigen::Map<const VectorXd>(run.bar_time.data(), static_cast<Index>(run.bar_time.size()));
  const VectorXd offset = VectorXd(robot.gauge_offset(all_times, conditions)(known))(finite);
  const VectorXd at = prediction.at(finite);
  const PointsAt points = [&](double shift) -> Matrix3Xd {
    return prediction.path.points(at.array() + shift * prediction.rate) - ball;
  };
  const VectorXd deviation = VectorXd(pick(run.bar_deviation, known)(finite)) - offset;
  const std::optional<CircleComparison> found =
      compare_circle(test.circle, angle(finite), deviation, points, prediction.has_shape);
  if (!found) return;
  result.predicted_from = result.source != "joints" && has_joints(run, robot) ? "joints" : "command";
  result.circle_gap = found->gap;
  result.predicted.assign(run.bar_time.size(), kNan);
  for (std::size_t i = 0; i < finite.size(); ++i) {
    const auto k = static_cast<Index>(i);
    result.predicted[known[static_cast<std::size_t>(finite[i])]] = found->predicted[k] + offset[k];
  }
}

/// The line's frame, for deviations along the world's axes.
struct LineFrame {
  Eigen::Vector3d start, along;

  explicit LineFrame(const LineSpec& line)
      : start(line.start[0], line.start[1], line.start[2]),
        along((Eigen::Vector3d(line.end[0], line.end[1], line.end[2]) - start).normalized()) {}

  double deviation(const Eigen::Vector3d& point, double position, char axis) const {
    return (point - start - position * along)[axis - 'X'];
  }
};

/// Means of the predictions over the readings at each of the line's points.
VectorXd predict_from_readings(const Run& run, const AsBuilt& robot, const LineFrame& frame,
                               const LineResult& line) {
  VectorXd time(static_cast<Index>(run.readings.size()));
  for (std::size_t i = 0; i < run.readings.size(); ++i) time[static_cast<Index>(i)] = run.readings[i].time;
  const Matrix3Xd points = predict_from_joints(run, robot).points(time);
  VectorXd sum = VectorXd::Zero(static_cast<Index>(line.points.size()));
  VectorXd count = sum;
  for (std::size_t i = 0; i < run.readings.size(); ++i) {
    const InterferometerReading& reading = run.readings[i];
    if (reading.axis != line.axis) continue;
    const auto point =
        std::lower_bound(line.points.begin(), line.points.end(), reading.position - kSamePosition,
                         [](const LinePoint& p, double position) { return p.position < position; });
    if (point == line.points.end() || point->position > reading.position + kSamePosition) continue;
    const Index k = point - line.points.begin();
    sum[k] += frame.deviation(points.col(static_cast<Index>(i)), reading.position, line.axis);
    count[k] += 1.0;
  }
  return sum.cwiseQuotient(count);  // 0 / 0 = not known
}

void add_lines(const Run& run, const TestSpec& test, const AsBuilt& robot, RunResult& result) {
  const LineFrame frame(test.line);
  const bool from_joints = has_joints(run, robot);
  if (!from_joints && (result.direction == 0 || !(run.feed > 0.0))) return;
  const Conditions conditions = conditions_of(run);
  for (LineResult& line : result.lines) {
    VectorXd predicted;
    if (from_joints) {
      predicted = predict_from_readings(run, robot, frame, line);
    } else {
      VectorXd position(static_cast<Index>(line.points.size()));
      for (Index k = 0; k < position.size(); ++k)
        position[k] = line.points[static_cast<std::size_t>(k)].position;
      const Matrix3Xd points = predict_line(test, robot, result.direction, run.feed, conditions, position);
      predicted.resize(position.size());
      for (Index k = 0; k < position.size(); ++k)
        predicted[k] = frame.deviation(points.col(k), position[k], line.axis);
    }
    compare_line(line, predicted);
    if (line.gap) result.predicted_from = from_joints ? "joints" : "command";
  }
}

}  // namespace

void add_gap(const Run& run, const TestSpec& test, const AsBuilt& robot, RunResult& result) {
  try {
    if (result.circle) add_circle(run, test, robot, result);
    if (!result.lines.empty()) add_lines(run, test, robot, result);
  } catch (const Error&) {
    // The model cannot drive this test: there is no prediction. `ballbar config check` says why, before any
    // run.
  }
}

}  // namespace ballbar
