#include "gap/add_gap.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "gap/compare.hpp"
#include "gap/predict.hpp"
#include "metrology/line.hpp"
#include "numerics/vector3.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::VectorXd;

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kFeedTolerance = 0.1;  // of the driven feed

/// From the joints where they are there; but a virtual bar is made of them.
bool predicted_from_joints(const Run& run, const AsBuilt& robot, const RunResult& result) {
  return result.source != "joints" && run.joints == robot.model().joints() && run.joint_time.size() > 1;
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
                         const VectorXd& angle, const VectorXd& time, bool from_joints) {
  if (from_joints) return {predict_from_joints(run, robot), time, 1.0, !robot.nominal()};
  const bool made_of_joints = result.source == "joints";
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

/// @return whether there is a prediction
bool add_circle(const Run& run, const TestSpec& test, const AsBuilt& robot, bool from_joints,
                RunResult& result) {
  const std::vector<std::size_t> known = known_samples(result);
  if (known.size() < 4) return false;
  const VectorXd angle = pick(result.angle, known);
  const VectorXd time = pick(run.bar_time, known);
  if (!(time[time.size() - 1] > time[0])) return false;
  const CirclePrediction prediction = predict(run, test, robot, result, angle, time, from_joints);
  const std::vector<Index> finite = predicted_samples(prediction);
  if (finite.size() < 4) return false;
  Conditions conditions = conditions_of(run);
  conditions.ball = vector_of(test.circle.centre);
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
  if (!found) return false;
  result.circle_gap = found->gap;
  result.predicted.assign(run.bar_time.size(), kNan);
  for (std::size_t i = 0; i < finite.size(); ++i) {
    const auto k = static_cast<Index>(i);
    result.predicted[known[static_cast<std::size_t>(finite[i])]] = found->predicted[k] + offset[k];
  }
  return true;
}

VectorXd times_of(const std::vector<InterferometerReading>& readings) {
  VectorXd time(static_cast<Index>(readings.size()));
  std::transform(readings.begin(), readings.end(), time.begin(),
                 [](const InterferometerReading& reading) { return reading.time; });
  return time;
}

/// Of all points of all lines, one line behind the other.
VectorXd positions_of(const std::vector<LineResult>& lines) {
  std::vector<double> position;
  for (const LineResult& line : lines)
    for (const LinePoint& point : line.points) position.push_back(point.position);
  return Eigen::Map<const VectorXd>(position.data(), static_cast<Index>(position.size()));
}

/// Means over the readings at each of the line's points.
/// @param predicted  [m] one deviation per reading of the run, those along other axes among them
VectorXd means_of_readings(const std::vector<InterferometerReading>& readings, const VectorXd& predicted,
                           const LineResult& line) {
  VectorXd sum = VectorXd::Zero(static_cast<Index>(line.points.size()));
  VectorXd count = sum;
  for (std::size_t i = 0; i < readings.size(); ++i) {
    const InterferometerReading& reading = readings[i];
    if (reading.axis != line.axis) continue;
    const auto point =
        std::lower_bound(line.points.begin(), line.points.end(), reading.position - kSamePosition,
                         [](const LinePoint& p, double position) { return p.position < position; });
    if (point == line.points.end() || point->position > reading.position + kSamePosition) continue;
    const Index k = point - line.points.begin();
    sum[k] += predicted[static_cast<Index>(i)];
    count[k] += 1.0;
  }
  return sum.cwiseQuotient(count);  // 0 / 0 = not known
}

/// @return whether there is a prediction
bool add_lines(const Run& run, const TestSpec& test, const AsBuilt& robot, bool from_joints,
               RunResult& result) {
  if (!from_joints && (result.direction == 0 || !(run.feed > 0.0))) return false;
  const LineFrame frame = frame_of(test.line);
  const Matrix3Xd points = from_joints ? predict_from_joints(run, robot).points(times_of(run.readings))
                                       : predict_line(test, robot, result.direction, run.feed,
                                                      conditions_of(run), positions_of(result.lines));
  bool predicted = false;
  Index first = 0;
  for (LineResult& line : result.lines) {
    const VectorXd deviations = frame.deviations(points, line.axis);
    const auto n = static_cast<Index>(line.points.size());
    compare_line(line, from_joints ? means_of_readings(run.readings, deviations, line)
                                   : VectorXd(deviations.segment(first, n)));
    first += n;
    predicted = predicted || line.gap.has_value();
  }
  return predicted;
}

}  // namespace

void add_gap(const Run& run, const TestSpec& test, const AsBuilt& robot, RunResult& result) {
  try {
    const bool from_joints = predicted_from_joints(run, robot, result);
    const bool predicted = (result.circle && add_circle(run, test, robot, from_joints, result)) ||
                           (!result.lines.empty() && add_lines(run, test, robot, from_joints, result));
    if (predicted) result.predicted_from = from_joints ? "joints" : "command";
  } catch (const Error&) {
    // The model cannot drive this test: there is no prediction. `ballbar config check` says why, before any
    // run.
  }
}

}  // namespace ballbar
