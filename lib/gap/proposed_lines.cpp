#include "gap/proposed_lines.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "gap/commanded_path.hpp"
#include "gap/line_observation.hpp"
#include "metrology/line.hpp"
#include "numerics/vector3.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;

constexpr double kLeastLead = 0.02;    // [m] before and behind a line: joints settle, play is crossed
constexpr double kLeadTime = 0.1;      // [s] or so long at its feed: it begins and ends from rest
constexpr int kFewestStops = 9;        // the first is not used where the robot begins there
constexpr int kUsualStops = 41;        // where fewer are configured
constexpr double kUsualLength = 0.6;   // [m] where no line is configured
constexpr double kLeastLength = 0.15;  // [m]
constexpr double kLengths[] = {1.0, 0.75, 0.5, 0.35, 0.25};  // of the configured one, tried in this sequence
constexpr double kAgainstSingularity = 20.0 * kRadPerDeg;
constexpr double kAbove = 0.13, kAside = 0.1;  // [m]
constexpr double kDwellPlanned = 0.3;          // [s] at each stop
constexpr double kStopsRate = 50.0;            // [1/s] of joints, as controllers send them
constexpr double kSameDirection = 0.999;       // cosine from which directions count as one
constexpr double kWayPlaces = 400.0;           // on the way, at which reach is looked at

Vector3d line_start(const TestSpec& test) { return vector_of(test.line.start); }
Vector3d line_way(const TestSpec& test) { return vector_of(test.line.end) - line_start(test); }

/// How a line differs from the one about which it is planned.
struct LineChange {
  Vector3d along = Vector3d::Zero();  ///< its direction; 0: the same
  Vector3d moved = Vector3d::Zero();  ///< [m]
  const char* where = "through ";     ///< its middle lies, seen from the other's
  int axis = 0;                       ///< about which the tool is tilted
  double tilted = 0.0;                ///< sign of that; 0: it is not
};

struct ToolTilt {
  int axis = 0;        ///< of the base
  double angle = 0.0;  ///< [rad]
};

/// Horizontally across a line, away from the robot's foot; 0 where there is no such direction.
Vector3d outwards_from(const Vector3d& middle, const Vector3d& along) {
  Vector3d out = middle - middle.dot(along) * along;
  out[2] = 0.0;
  out -= out.dot(along) * along;
  return out.norm() > 1e-3 ? Vector3d(out.normalized()) : Vector3d(Vector3d::Zero());
}

std::vector<LineChange> line_changes(const TestSpec& test) {
  const Vector3d along = line_way(test).normalized();
  std::vector<LineChange> all{{}};
  for (const Vector3d& other :
       {Vector3d(1, 0, 0), Vector3d(0, 1, 0), Vector3d(0, 0, 1), Vector3d(1, 1, 0), Vector3d(1, -1, 0)})
    if (std::abs(other.normalized().dot(along)) < kSameDirection)
      all.push_back({.along = other.normalized()});
  all.push_back({.moved = kAbove * Vector3d::UnitZ(), .where = "130 mm above "});
  all.push_back({.moved = -kAbove * Vector3d::UnitZ(), .where = "130 mm below "});
  const Vector3d out = outwards_from(line_start(test) + 0.5 * line_way(test), along);
  if (out.norm() > 0.5) {
    all.push_back({.moved = kAside * out, .where = "100 mm further out than "});
    all.push_back({.moved = -kAside * out, .where = "100 mm nearer than "});
  }
  for (const int axis : {1, 0})
    for (const double sign : {1.0, -1.0}) all.push_back({.axis = axis, .tilted = sign});
  return all;
}

/// "X", or "[0.71 0.71 0]".
std::string direction_words(const Vector3d& along) {
  for (int axis = 0; axis < 3; ++axis)
    if (std::abs(along[axis]) > 1.0 - 1e-6) return std::string(1, "XYZ"[axis]);
  return "[" + to_hundredths(along[0]) + " " + to_hundredths(along[1]) + " " + to_hundredths(along[2]) + "]";
}

TestSpec changed_line(const TestSpec& base, const Matrix3d& tool, const LineChange& change, double length,
                      const ToolTilt& tilt) {
  TestSpec test = base;
  const Vector3d way = line_way(base), middle = line_start(base) + 0.5 * way + change.moved;
  const Vector3d along = change.along.isZero() ? Vector3d(way.normalized()) : change.along;
  if (!change.along.isZero() || !change.moved.isZero() || length != way.norm()) {
    test.line.start = vec3_of(middle - 0.5 * length * along);
    test.line.end = vec3_of(middle + 0.5 * length * along);
  }
  if (tilt.angle != 0.0) test.tool_rpy = rpy_of(turn_about(tilt.axis, tilt.angle) * tool);
  if (!(test.feed > 0.0)) test.feed = kLikelyFeed;
  if (test.line.points < kFewestStops) test.line.points = kUsualStops;
  return test;
}

double lead_of(const TestSpec& test) { return std::max(kLeastLead, kLeadTime * test.feed); }

/// From before the line to behind it, without a stop; positions count from the line's start.
CommandedPath driven_through(const RobotModel& model, const TestSpec& test, int direction, double rate) {
  const Vector3d lead = lead_of(test) * line_way(test).normalized();
  TestSpec longer = test;
  longer.line = {vec3_of(line_start(test) - lead), vec3_of(vector_of(test.line.end) + lead), 2};
  CommandedPath path = commanded_line(model, longer, direction, test.feed, kDwellPlanned, rate);
  path.position.array() -= lead_of(test);
  return path;
}

CommandedPath driven_with_stops(const RobotModel& model, const TestSpec& test, int direction) {
  return commanded_line(model, test, direction, test.feed, kDwellPlanned, kStopsRate);
}

/// Through it from before, and from stop to stop: an arm may come to these in another configuration.
bool line_can_be_driven(const RobotModel& model, const TestSpec& test) {
  try {
    for (const int direction : {1, -1}) {
      const double rate = kWayPlaces * test.feed / line_way(test).norm();
      if (!within_joint_speeds(model, driven_through(model, test, direction, rate).motion)) return false;
      driven_with_stops(model, test, direction);
    }
  } catch (const Error&) {
    return false;
  }
  return true;
}

/// How the tool may be held, the best first: as the change says, or else as where the arm is not singular.
std::vector<ToolTilt> tilts_of(const LineChange& change) {
  std::vector<ToolTilt> tilts;
  if (change.tilted != 0.0) {
    for (const double tilt : kPlannedTilts) tilts.push_back({change.axis, change.tilted * tilt * kRadPerDeg});
    return tilts;
  }
  tilts.push_back({});
  if (change.along.isZero() && change.moved.isZero()) return tilts;
  for (const int axis : {1, 0})
    for (const double sign : {1.0, -1.0}) tilts.push_back({axis, sign * kAgainstSingularity});
  return tilts;
}

/// The longest that can be driven; nothing where none can.
std::optional<ProposedTest> longest_drivable(const GapModel& model, const LinePlace& place,
                                             const Matrix3d& tool, const LineChange& change) {
  const double full = line_way(place.test).norm();
  for (const double share : kLengths) {
    const double length = share * full;
    if (share < 1.0 && length < kLeastLength) break;
    for (const ToolTilt& tilt : tilts_of(change)) {
      ProposedTest one{changed_line(place.test, tool, change, length, tilt), ""};
      if (!line_can_be_driven(model.model(), one.test)) continue;
      one.differs = "line along " + direction_words(line_way(one.test).normalized()) + ", " +
                    std::to_string(std::lround(to_mm(length))) + " mm long";
      if (tilt.angle != 0.0) one.differs += ", tool" + tilt_words(tilt.axis, tilt.angle);
      return one;
    }
  }
  return std::nullopt;
}

/// A line without deviations, as it would be recorded.
Run line_run(const GapModel& model, const TestSpec& test, int direction, const LapNoise& noise) {
  const double length = line_way(test).norm();
  Run run;
  run.test = test.name;
  run.kind = TestKind::kLine;
  run.direction = direction;
  run.feed = test.feed;
  run.payload = test.payload.value_or(model.spec().payload);
  run.joints = model.joints();
  const std::string axes = frame_of(test.line).axes_across();
  const auto read = [&](double time, double position) {
    for (const char axis : axes) run.readings.push_back({axis, time, position, 0.0});
  };
  CommandedPath path;
  if (noise.at_stops) {
    path = driven_with_stops(model.model(), test, direction);
    for (Index k = 0; k < path.stop_end.size(); ++k)
      read(path.stop_end[k] - 0.5 * kDwellPlanned, path.stop_position[k]);
  } else {
    // As many readings as the highest frequency of the noise asks for.
    const double wanted = kValuesPerCoefficient * 2.0 * (noise.frequency.tail(1)[0] + 1.5);
    path = driven_through(model.model(), test, direction, std::max(kStopsRate, wanted * test.feed / length));
    for (Index k = 0; k < path.position.size(); ++k)
      if (path.position[k] >= 0.0 && path.position[k] <= length) read(path.motion.time[k], path.position[k]);
  }
  run.joint_time.assign(path.motion.time.begin(), path.motion.time.end());
  for (Index k = 0; k < path.motion.q.cols(); ++k) {
    std::vector<double> q(path.motion.q.col(k).begin(), path.motion.q.col(k).end());
    model.model().from_chain(q);
    run.joint_position.insert(run.joint_position.end(), q.begin(), q.end());
  }
  return run;
}

}  // namespace

std::vector<LinePlace> line_places_of(const RobotSpec& robot, bool anywhere) {
  std::vector<LinePlace> places;
  const auto add = [&](const TestSpec& test, const std::string& words) {
    const bool known = std::any_of(places.begin(), places.end(), [&](const LinePlace& place) {
      return place.test.line.start == test.line.start && place.test.line.end == test.line.end;
    });
    if (!known && places.size() < kMostPlaces) places.push_back({test, words + test.name});
  };
  for (const TestSpec& test : robot.tests)
    if (test.kind == TestKind::kLine) add(test, "the middle of ");
  if (!places.empty() || !anywhere) return places;
  for (const TestSpec& test : robot.tests) {
    if (test.kind != TestKind::kCircle) continue;
    TestSpec line = test;
    line.kind = TestKind::kLine;
    line.circle = {};
    const Vector3d centre = vector_of(test.circle.centre), half = 0.5 * kUsualLength * Vector3d::UnitY();
    line.line = {vec3_of(centre - half), vec3_of(centre + half), kUsualStops};
    add(line, "the centre of ");
  }
  return places;
}

void propose_lines(const GapModel& model, const LinePlace& place, bool on_the_way, double heavy,
                   TestNames& names, const std::function<void()>& step, std::vector<ProposedTest>& all) {
  const std::optional<Matrix3d> tool = known_tool_orientation(model.model(), place.test);
  if (!tool) return;  // nothing to go by
  for (const LineChange& change : line_changes(place.test)) {
    step();
    const std::optional<ProposedTest> plain = longest_drivable(model, place, *tool, change);
    if (!plain) continue;
    const auto faster = [&](const TestSpec& fast) {  // at stops it tells nothing more
      return on_the_way && line_can_be_driven(model.model(), fast);
    };
    add_variants(model, *plain, heavy, faster, [&](ProposedTest one, const std::string& more) {
      one.differs = joined(one.differs, more) + ", " + change.where + place.words + ", read " +
                    (on_the_way ? "on the way" : "at " + std::to_string(one.test.line.points) + " stops");
      one.test.name = names.next(place.test.name);
      all.push_back(std::move(one));
    });
  }
}

std::vector<Observation> line_as_observed(const GapModel& model, const TestSpec& test, int set_up,
                                          const LapNoise& noise) {
  std::vector<Observation> all;
  const double time = line_way(test).norm() / test.feed;
  for (const int direction : {1, -1}) {
    const MeasuredRun lap{line_run(model, test, direction, noise), {}};
    int at = set_up;
    for (const char axis : frame_of(test.line).axes_across()) {
      std::vector<std::string> faults;
      std::optional<Observation> seen = observe_line({&lap}, axis, test, model.model(), faults);
      if (!seen) throw Error(Cause::kInput, "test '" + test.name + "': " + faults.front());
      seen->set_up = at++;
      leave_unmeasured(*seen, noise, noise.at_stops ? 1.0 : noise.time_per_turn / time);
      all.push_back(std::move(*seen));
    }
  }
  return all;
}

}  // namespace ballbar
