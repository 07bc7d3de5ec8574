#include "pipeline/process.hpp"

#include <Eigen/Core>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>

#include "core/units.hpp"
#include "gap/add_gap.hpp"
#include "metrology/arc.hpp"
#include "metrology/circle.hpp"
#include "metrology/line.hpp"
#include "numerics/circle_fit.hpp"
#include "pipeline/circle_test.hpp"

namespace ballbar {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kLeastCoverage = 0.98;           // of the measured arc
constexpr double kTooFar = kPi;                   // of the driven path beyond arc and overshoots
constexpr double kLeastTurn = 10.0 * kRadPerDeg;  // of the joints' path, to tell its direction
constexpr int kMaxOrder = 30;

void require_finite(const std::vector<double>& values, const char* what) {
  for (const double v : values)
    if (!std::isfinite(v)) throw std::invalid_argument(std::string("process: ") + what + " is not finite");
}

void set_status(RunResult& result, const std::string& status, const std::string& message) {
  if (result.status != "ok") return;  // the first thing that is wrong says most
  result.status = status;
  result.message = message;
}

/// What the end of the run says already.
void set_end_status(RunResult& result, RunEnd end) {
  switch (end) {
    case RunEnd::kMark:
    case RunEnd::kGeometry:
      return;
    case RunEnd::kAborted:
      return set_status(result, "aborted", "the producer aborted the run");
    case RunEnd::kSilence:
      return set_status(result, "no_end", "no end mark came before the robot fell silent");
    case RunEnd::kNextBegin:
      return set_status(result, "no_end", "the next run began without an end mark of this one");
    case RunEnd::kProducerRestart:
      return set_status(result, "producer_restarted",
                        "sequence and time of the producer fell back in the run");
    case RunEnd::kInterrupted:
      return set_status(result, "interrupted",
                        "the service was stopped, or its configuration changed, in the run");
    case RunEnd::kMarksLost:
      return set_status(result, "marks_lost",
                        "a mark was lost in the run: where it began or ended is not known");
    case RunEnd::kNoBegin:
      return set_status(result, "no_begin",
                        "the end mark came, the begin mark was lost: no sample is known to belong to it");
    case RunEnd::kTooLong:
      return set_status(result, "too_long", "the run held more samples than the stated maximum");
  }
}

/// Tool points at the times of the bar's samples: joints interpolated linearly, then nominal forward
/// kinematics.
Eigen::Matrix3Xd tool_points(const Run& run, const RobotModel& model) {
  const auto joints = static_cast<std::size_t>(run.joints);
  Eigen::Matrix3Xd points =
      Eigen::Matrix3Xd::Constant(3, static_cast<Eigen::Index>(run.bar_time.size()), kNan);
  std::vector<double> q(joints);
  std::size_t next = 0;  // first joint sample that is not before the bar's
  for (std::size_t i = 0; i < run.bar_time.size(); ++i) {
    const double t = run.bar_time[i];
    while (next < run.joint_time.size() && run.joint_time[next] < t) ++next;
    if (next == run.joint_time.size()) break;
    const bool exact = run.joint_time[next] == t;
    if (!exact && (next == 0 || run.joint_time[next] - run.joint_time[next - 1] > kLongestJointGap)) continue;
    const std::size_t before = exact ? next : next - 1;
    const double share =
        exact ? 0.0 : (t - run.joint_time[before]) / (run.joint_time[next] - run.joint_time[before]);
    for (std::size_t j = 0; j < joints; ++j) {
      const double from = run.joint_position[before * joints + j];
      q[j] = from + share * (run.joint_position[next * joints + j] - from);
    }
    points.col(static_cast<Eigen::Index>(i)) = model.forward(q).translation();
  }
  return points;
}

std::string mm_text(double metres) {
  const double tenths = std::round(to_mm(metres) * 10.0);
  const auto whole = static_cast<std::int64_t>(std::abs(tenths));
  return (tenths < 0 ? "-" : "") + std::to_string(whole / 10) + "." + std::to_string(whole % 10);
}

/// Whether the joints drive the circle that is configured: a wrong centre, radius, URDF or joint convention
/// gives wrong figures that look right.
void check_driven_circle(const Eigen::Matrix3Xd& points, const CircleSpec& circle, RunResult& result) {
  const CirclePlane plane = plane_of(circle);
  Eigen::Matrix2Xd in_plane(2, points.cols());
  double height = 0.0;
  Eigen::Index known = 0;
  for (Eigen::Index i = 0; i < points.cols(); ++i) {
    const Eigen::Vector3d p = points.col(i) - plane.centre;
    if (!p.allFinite()) continue;
    in_plane.col(known++) << p.dot(plane.e1), p.dot(plane.e2);
    height = std::max(height, std::abs(p.dot(plane.normal)));
  }
  if (known < 10) return;
  const CircleFit driven = fit_circle(in_plane.leftCols(known));
  const bool round = driven.status == FitStatus::kOk;
  const double off = round ? driven.centre.norm() : 0.0;
  if (round && off < kOffPath && std::abs(driven.radius - circle.radius) < kOffPath && height < kOffPath)
    return;
  const std::string drives = round ? "a circle of " + mm_text(driven.radius) + " mm about a centre " +
                                         mm_text(off) + " mm off, up to " + mm_text(height) +
                                         " mm out of its plane"
                                   : "no circle";
  set_status(result, "wrong_path",
             "the joints drive " + drives + ", configured are " + mm_text(circle.radius) +
                 " mm: look at the test's centre and radius, the tool, the URDF and joint_convention");
}

/// +1, -1, or 0 where the path does not turn.
int direction_of(const Eigen::VectorXd& angle) {
  double first = kNan;
  double last = kNan;
  for (const double a : angle) {
    if (std::isnan(a)) continue;
    if (std::isnan(first)) first = a;
    last = a;
  }
  if (!(std::abs(last - first) > kLeastTurn)) return 0;
  return last > first ? 1 : -1;
}

/// Angle of every bar sample, by the best source that the run has.
Eigen::VectorXd sample_angles(const Run& run, const CircleSpec& circle, const RobotModel* model,
                              RunResult& result) {
  const bool joints = model && run.joint_time.size() > 1;
  if (joints && run.joints == model->joints()) {
    result.angle_source = "joints";
    const Eigen::Matrix3Xd points = tool_points(run, *model);
    check_driven_circle(points, circle, result);
    Eigen::VectorXd angle = angles_on_circle(points, circle);
    const int direction = direction_of(angle);
    if (result.direction == 0) result.direction = direction;
    if (direction != 0 && direction != result.direction)
      set_status(result, "wrong_direction", "the joints turn the other way than the mark says");
    return angle;
  }
  if (joints)
    set_status(result, "no_joints",
               "JOINTS hold " + std::to_string(run.joints) + " angles, the chain has " +
                   std::to_string(model->joints()) + "; angles are from time");
  result.angle_source = "time";
  const double end = static_cast<double>(run.ended_us - run.started_us) * kSecondsPerUs;
  const Eigen::VectorXd time =
      Eigen::Map<const Eigen::VectorXd>(run.bar_time.data(), static_cast<Eigen::Index>(run.bar_time.size()));
  return angles_at_constant_feed(time, 0.0, end, circle, result.direction, run.feed);
}

/// Two circles that lost marks have merged are no circle: the path must go once through the arc, one way.
void check_path(const std::vector<double>& angle, const Arc& arc, const CircleSpec& circle, int direction,
                RunResult& result) {
  double lowest = std::numeric_limits<double>::infinity();
  double highest = -lowest;
  double furthest = -lowest;  // along the direction, within the arc
  double back = 0.0;
  for (std::size_t i = 0; i < angle.size(); ++i) {
    if (std::isnan(angle[i])) continue;
    lowest = std::min(lowest, angle[i]);
    highest = std::max(highest, angle[i]);
    if (i < arc.begin || i >= arc.end) continue;
    furthest = std::max(furthest, direction * angle[i]);
    back = std::max(back, furthest - direction * angle[i]);
  }
  if (back > kBackwards || highest - lowest > circle.arc_sweep + 2.0 * circle.overshoot + kTooFar)
    set_status(result, "path_not_simple",
               "the path goes more than once, or both ways, through the arc: were marks lost?");
}

std::optional<double> feed_on(const Arc& arc, const std::vector<double>& angle,
                              const std::vector<double>& time, double radius) {
  const auto begin = static_cast<Eigen::Index>(arc.begin);
  const auto count = static_cast<Eigen::Index>(arc.end) - begin;
  const auto all = static_cast<Eigen::Index>(angle.size());
  return calculated_feed(Eigen::Map<const Eigen::VectorXd>(angle.data(), all).segment(begin, count),
                         Eigen::Map<const Eigen::VectorXd>(time.data(), all).segment(begin, count), radius);
}

/// Angles and measured arc, and whether they can be those of the configured circle.
/// @return whether there is anything to analyse
bool locate_circle(const Run& run, const CircleSpec& circle, const RobotModel* model, RunResult& result) {
  result.source = run.virtual_bar ? "joints" : "bar";
  if (run.bar_time.empty()) {
    set_status(result, "too_few_samples", "no BALLBAR samples came between the marks");
    return false;
  }
  Eigen::VectorXd angle = sample_angles(run, circle, model, result);
  if (result.direction == 0) {
    set_status(result, "no_direction", "neither the mark nor JOINTS say which way the circle ran");
    return false;
  }
  const Arc arc = find_arc(angle, circle);
  result.angle.assign(angle.begin(), angle.end());
  result.arc_begin = arc.begin;
  result.arc_end = arc.end;
  check_path(result.angle, arc, circle, result.direction, result);
  if (arc.coverage < kLeastCoverage || arc.largest_hole > kLargestHole)
    set_status(result, "arc_incomplete",
               "samples cover " + std::to_string(static_cast<int>(100.0 * arc.coverage)) +
                   " % of the arc; the widest hole is " +
                   std::to_string(static_cast<int>(to_deg(arc.largest_hole))) + " degrees");
  const auto implausible = [&](double d) { return std::abs(d) > circle.radius / 2.0; };
  if (std::any_of(run.bar_deviation.begin(), run.bar_deviation.end(), implausible)) {
    set_status(result, "implausible", "a deviation is larger than half the radius: is its unit micrometres?");
    return false;
  }
  return true;
}

void analyse_located(const Run& run, const TestSpec& test, const std::optional<CircleTrace>& other_way,
                     RunResult& result) {
  const CircleSpec& circle = test.circle;
  // A hole in JOINTS leaves samples inside the arc without an angle: they are not used, and the arc may be
  // incomplete.
  CircleTrace trace = measured_arc(result.angle, run.bar_deviation, result.arc_begin, result.arc_end);
  trace.direction = result.direction;
  trace.feed = run.feed;
  trace.temperature = run.temperature;
  // Angles from time are made with a feed: they tell of none.
  if (result.angle_source == "joints")
    trace.calculated_feed = feed_on({.begin = result.arc_begin, .end = result.arc_end}, result.angle,
                                    run.bar_time, circle.radius);
  result.samples = trace.angle.size();
  result.circle = analyse_circle(trace.angle, trace.deviation, circle.radius, kMaxOrder);
  add_circle_figures(trace, test, other_way, result);
  if (!result.circle && (!result.circle_figures || carries_centre(trace.angle)))
    set_status(result, "too_few_samples", "the samples in the measured arc determine no circle");
}

/// A line with points left out may look straighter than it is.
void check_points(const LineResult& line, const LineSpec& spec, RunResult& result) {
  constexpr double kSpan = 0.95;  // of the line, where the number of points is not configured
  const double length =
      std::hypot(spec.end[0] - spec.start[0], spec.end[1] - spec.start[1], spec.end[2] - spec.start[2]);
  const double span = line.points.back().position - line.points.front().position;
  const auto points = static_cast<int>(line.points.size());
  const bool short_of_points = spec.points > 0 ? points < spec.points : span < kSpan * length;
  if (short_of_points)
    set_status(result, "line_incomplete",
               std::to_string(points) + " positions over " + std::to_string(std::lround(to_mm(span))) +
                   " mm were measured, not " +
                   (spec.points > 0 ? std::to_string(spec.points) : "the whole line"));
}

void process_line(const Run& run, const LineSpec& spec, const std::vector<LinePartner>& partners,
                  RunResult& result) {
  result.source = "interferometer";
  result.samples = static_cast<std::int64_t>(run.readings.size());
  const double length =
      std::hypot(spec.end[0] - spec.start[0], spec.end[1] - spec.start[1], spec.end[2] - spec.start[2]);
  const auto implausible = [&](const InterferometerReading& r) {
    return std::abs(r.deviation) > length / 2.0;
  };
  if (length > 0.0 && std::any_of(run.readings.begin(), run.readings.end(), implausible))
    return set_status(result, "implausible",
                      "a deviation is larger than half the line: is its unit micrometres?");
  std::map<char, std::vector<InterferometerReading>> by_axis;
  for (const InterferometerReading& reading : run.readings) by_axis[reading.axis].push_back(reading);
  for (const auto& [axis, readings] : by_axis) {
    std::optional<LineResult> line = analyse_line(readings);
    if (!line) continue;
    for (const LinePartner& partner : partners)
      if (partner.axis == axis) add_reversal(*line, run.direction, partner.points);
    check_points(*line, spec, result);
    result.lines.push_back(std::move(*line));
  }
  if (result.lines.empty())
    set_status(result, "too_few_samples", "INTERFEROMETER gave fewer than 3 positions on the line");
}

/// What holds before the samples are looked at.
RunResult begun(const Run& run, const TestSpec& test) {
  if (run.kind != test.kind) throw std::invalid_argument("process: the run is not of the test's kind");
  require_finite(run.bar_time, "a bar time");
  require_finite(run.bar_deviation, "a bar deviation");
  require_finite(run.joint_position, "a joint angle");
  RunResult result;
  result.direction = run.direction;
  if (run.kind == TestKind::kCircle) result.plane = plane_name(test.circle);
  set_end_status(result, run.end);
  return result;
}

}  // namespace

RunResult process_measured(const Run& run, const TestSpec& test, const RobotModel* model,
                           const Partners& partners) {
  RunResult result = begun(run, test);
  if (discards(run.end)) return result;
  // Without marks nobody said that a test begins: the robot may drive the circle at work.
  if (run.virtual_bar && partners.bar && run.end != RunEnd::kGeometry)
    set_status(
        result, "no_bar",
        "no BALLBAR came between the marks, though the circle before in this series had it: is it "
        "connected? The figures are those of the joints; circles without a bar are a series of their own");
  if (run.kind == TestKind::kLine)
    process_line(run, test.line, partners.lines, result);
  else if (locate_circle(run, test.circle, model, result))
    analyse_located(run, test, partners.circle, result);
  return result;
}

RunResult process(const Run& run, const TestSpec& test, const AsBuilt* robot, const Partners& partners) {
  RunResult result = process_measured(run, test, robot ? &robot->model() : nullptr, partners);
  if (robot && !discards(run.end)) add_gap(run, test, *robot, result);
  return result;
}

RunResult locate(const Run& run, const TestSpec& test, const RobotModel& robot) {
  if (run.kind != TestKind::kCircle) throw std::invalid_argument("locate: no circle");
  RunResult result = begun(run, test);
  if (!discards(run.end)) locate_circle(run, test.circle, &robot, result);
  return result;
}

}  // namespace ballbar
