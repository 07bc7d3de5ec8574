#include "gap/line_observation.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numeric>

#include "core/text.hpp"
#include "core/units.hpp"
#include "gap/observation_parts.hpp"
#include "gap/predict.hpp"
#include "metrology/arc.hpp"
#include "metrology/line.hpp"
#include "numerics/interpolate.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kSameRest = 1e-4;   // [rad] that no joint leaves while the robot stands: roundings and noise
constexpr double kLeastRest = 0.1;   // [s]: a motion has died out, and clocks may differ
constexpr double kAboutRest = 0.02;  // [s] between the model's times there, two on either side: rates are 0
constexpr double kMoveStep = 0.02;   // [s] between the model's times of a move,
constexpr int kFewestSteps = 8, kMostSteps = 24;  // and how many it has
constexpr double kApproachStep = 0.05;            // [s] on the way to the first stop
constexpr int kMostApproach = 200;                // steps
constexpr double kApproach = 1e-3;                // [rad] that a joint has moved before the first stop
constexpr double kSameStop = 1e-3;                // [m] between laps
constexpr Index kLeastStops = 8;
constexpr Index kLeastOnLine = 40;   // readings of a run that does not stop
constexpr double kUncovered = 0.02;  // of the line, that such a run may lack at each end
constexpr double kLateBy = 0.03;     // [s] that positions and joints may be apart

/// The readings along one axis.
struct Read {
  VectorXd time, position, deviation;
};

Read readings_along(const Run& run, char axis) {
  std::vector<double> time, position, deviation;
  for (const InterferometerReading& reading : run.readings) {
    if (reading.axis != axis || (!time.empty() && reading.time <= time.back())) continue;
    time.push_back(reading.time);
    position.push_back(reading.position);
    deviation.push_back(reading.deviation);
  }
  const auto n = static_cast<Index>(time.size());
  return {Eigen::Map<VectorXd>(time.data(), n), Eigen::Map<VectorXd>(position.data(), n),
          Eigen::Map<VectorXd>(deviation.data(), n)};
}

struct Rest {
  double begin = 0.0, end = 0.0;  ///< [s]
  double length() const { return end - begin; }
  double middle() const { return 0.5 * (begin + end); }
};

/// How long the robot has stood where it was at a time, within what the joints cover whatever the clocks.
Rest rest_at(const Motion& said, double time) {
  const auto after = std::lower_bound(said.time.begin(), said.time.end(), time) - said.time.begin();
  Index at = std::min<Index>(after, said.time.size() - 1);
  if (at > 0 && time - said.time[at - 1] < said.time[at] - time) --at;
  const auto here = [&](Index k) {
    return (said.q.col(k) - said.q.col(at)).cwiseAbs().maxCoeff() < kSameRest;
  };
  Index first = at, last = at;
  while (first > 0 && here(first - 1)) --first;
  while (last + 1 < said.time.size() && here(last + 1)) ++last;
  return {std::max(said.time[first], said.time[0] + kShiftRoom),
          std::min(said.time[last], said.time[said.time.size() - 1] - kShiftRoom)};
}

/// Stops in sequence of time.
struct Stops {
  VectorXd position, deviation;
  std::vector<Rest> rest;
  Index moving = 0;  ///< readings between them
};

Stops stops_of(const Motion& said, const Read& read) {
  Stops stops;
  std::vector<double> position, deviation, count;
  Rest rest;
  for (Index i = 0; i < read.time.size(); ++i) {
    const bool same = !stops.rest.empty() && read.time[i] >= rest.begin && read.time[i] <= rest.end;
    if (!same) {
      rest = rest_at(said, read.time[i]);
      if (rest.length() < kLeastRest) {
        ++stops.moving;
        continue;
      }
      if (stops.rest.empty() || rest.begin != stops.rest.back().begin) {
        stops.rest.push_back(rest);
        position.push_back(0.0);
        deviation.push_back(0.0);
        count.push_back(0.0);
      }
    }
    position.back() += read.position[i];
    deviation.back() += read.deviation[i];
    count.back() += 1.0;
  }
  const auto n = static_cast<Index>(count.size());
  const auto mean = [&](const std::vector<double>& sum) -> VectorXd {
    return Eigen::Map<const VectorXd>(sum.data(), n)
        .cwiseQuotient(Eigen::Map<const VectorXd>(count.data(), n));
  };
  stops.position = mean(position);
  stops.deviation = mean(deviation);
  return stops;
}

/// One lap of a line, at its stops or while it moves.
struct LineLap {
  bool at_rest = false;
  Stops stops;
  Lap lap;
  Motion said;
};

/// The largest distance of the nominal tool point from where the readings say that it was [m].
double off_line(const Motion& said, const VectorXd& time, const VectorXd& position, const LineFrame& frame,
                const RobotModel& model) {
  const MatrixXd q =
      interpolate(said.time, said.q, time, std::numeric_limits<double>::infinity(), Interpolation::kLinear);
  double most = 0.0;
  for (Index k = 0; k < time.size(); ++k) {
    const Eigen::Vector3d point =
        model.chain().forward({q.col(k).data(), static_cast<std::size_t>(q.rows())}).translation();
    most = std::max(most, (point - frame.start - position[k] * frame.along).norm());
  }
  return most;
}

/// What is wrong with a way; empty: nothing.
std::string fault_of_way(const Motion& said, const VectorXd& time, const VectorXd& position, const Run& run,
                         const LineFrame& frame, const RobotModel& model) {
  const Index n = position.size();
  if ((run.direction * (position[n - 1] - position[0])) < 0.0)
    return "its positions run the other way than its mark says; look at the mark's direction";
  const double speed = (position[n - 1] - position[0]) / (time[n - 1] - time[0]);
  const double off = off_line(said, time, position, frame, model);
  if (!(off < kOffPath + kLateBy * std::abs(speed)))
    return "its joints are up to " + to_hundredths(to_mm(off)) +
           " mm away from where its readings say that it was on the configured line; look at the test's "
           "start and end, the tool and the robot";
  return {};
}

/// @return nothing, with the reason in `fault`, where the lap cannot be used
std::optional<LineLap> lap_on(const Run& run, char axis, const LineSpec& line, const RobotModel& model,
                              std::string& fault) {
  const LineFrame frame = frame_of(line);
  const double length = (Eigen::Map<const Eigen::Vector3d>(line.end.data()) - frame.start).norm();
  if (run.joints != model.joints() || run.joint_time.size() < 2) {
    fault = "no joints were recorded with it; send JOINTS while the line is driven";
    return std::nullopt;
  }
  if (!frame.across(axis).allFinite()) {
    fault = std::string("its line lies along ") + axis + ", which straightness optics do not see";
    return std::nullopt;
  }
  LineLap lap;
  lap.said = motion_of(run, model);
  const double first = lap.said.time[0], last = lap.said.time[lap.said.time.size() - 1];
  if (!without_holes(lap.said) || last - first < 1.0) {
    fault = "its joints have holes; send JOINTS without a pause from begin to end of the line";
    return std::nullopt;
  }
  const Read read = readings_along(run, axis);
  lap.stops = stops_of(lap.said, read);
  lap.at_rest = 2 * lap.stops.moving < read.time.size();
  if (lap.at_rest) {
    Stops& stops = lap.stops;
    auto n = static_cast<Index>(stops.rest.size());
    Index begin = 0;
    if (n > 0) {
      const Index rests =
          std::lower_bound(lap.said.time.begin(), lap.said.time.end(), stops.rest.front().begin) -
          lap.said.time.begin();
      const MatrixXd before = lap.said.q.leftCols(rests + 1);
      if ((before.rowwise().maxCoeff() - before.rowwise().minCoeff()).maxCoeff() < kApproach) begin = 1;
    }
    n -= begin;
    if (n < kLeastStops) {
      fault = "the robot stands at " + std::to_string(std::max<Index>(n, 0)) +
              " usable points of it; eight at least are needed, each for a tenth of a second or longer";
      return std::nullopt;
    }
    stops.position = stops.position.tail(n).eval();
    stops.deviation = stops.deviation.tail(n).eval();
    stops.rest.erase(stops.rest.begin(), stops.rest.begin() + begin);
    VectorXd time(n);
    for (Index k = 0; k < n; ++k) time[k] = stops.rest[static_cast<std::size_t>(k)].middle();
    fault = fault_of_way(lap.said, time, stops.position, run, frame, model);
  } else {
    std::vector<Index> on;
    double furthest = -std::numeric_limits<double>::infinity();
    for (Index i = 0; i < read.time.size(); ++i) {
      const double way = (run.direction > 0 ? read.position[i] : length - read.position[i]) / length;
      if (way < 0.0 || way > 1.0 || way <= furthest) continue;
      furthest = way;
      on.push_back(i);
    }
    const auto n = static_cast<Index>(on.size());
    if (n >= 2) fault = fault_of_way(lap.said, read.time, read.position, run, frame, model);
    if (!fault.empty()) return std::nullopt;
    lap.lap.time = read.time(on);
    lap.lap.deviation = read.deviation(on);
    lap.lap.x = read.position(on) / length;
    if (run.direction < 0) lap.lap.x = 1.0 - lap.lap.x.array();
    if (n < kLeastOnLine || lap.lap.x[0] > kUncovered || lap.lap.x[n - 1] < 1.0 - kUncovered)
      fault = "the robot moves while it is read, and the readings are fewer than " +
              std::to_string(kLeastOnLine) +
              " or do not reach from end to end; read faster, or stop at each point";
  }
  if (!fault.empty()) return std::nullopt;
  return lap;
}

/// Times of the model: fine about the middle of each rest, where the place is, and on the moves between them.
void set_times_of_stops(const LineLap& lap, Observation& seen) {
  std::vector<double> times;
  const auto steps = [&](double from, double to, double step, int fewest, int most) {
    if (!times.empty()) from = std::max(from, times.back() + 0.5 * kAboutRest);
    const double room = to - from;
    if (!(room > 0.0)) return;
    const int count = std::clamp(static_cast<int>(std::ceil(room / step)), fewest, most);
    for (int k = 0; k < count; ++k) times.push_back(from + room * k / count);
  };
  double left = lap.said.time[0] + kShiftRoom;
  bool approach = true;
  for (const Rest& rest : lap.stops.rest) {
    const double middle = rest.middle(), near = middle - 2.0 * kAboutRest;
    if (approach)
      steps(left, rest.begin, kApproachStep, 1, kMostApproach);
    else
      steps(left, rest.begin, kMoveStep, kFewestSteps, kMostSteps);
    if (rest.begin < near - 0.5 * kAboutRest) times.push_back(rest.begin);
    for (int k = -2; k <= 2; ++k) {
      if (k == 0) seen.sample.push_back(static_cast<Index>(times.size()));
      times.push_back(middle + k * kAboutRest);
    }
    left = std::max(rest.end, times.back() + 0.5 * kAboutRest);
    approach = false;
  }
  seen.time = Eigen::Map<const VectorXd>(times.data(), static_cast<Index>(times.size()));
}

bool same_stops(const LineLap& a, const LineLap& b) {
  return a.stops.position.size() == b.stops.position.size() &&
         (a.stops.position - b.stops.position).cwiseAbs().maxCoeff() < kSameStop;
}

void place_stops(const std::vector<LineLap>& laps, Observation& seen) {
  const LineLap& first = laps.front();
  const Index n = first.stops.position.size();
  seen.at_rest = true;
  seen.place = first.stops.position;
  // A value at each stop as in the middles of equal parts: the transform is orthonormal, and all are used.
  seen.transform = CosineTransform(n, 1.0, 0.5 * static_cast<double>(n));
  seen.readings_per_turn = static_cast<double>(n);
  set_times_of_stops(first, seen);
  seen.laps.resize(seen.transform.frequency().size(), static_cast<Index>(laps.size()));
  for (std::size_t i = 0; i < laps.size(); ++i)
    seen.laps.col(static_cast<Index>(i)) = seen.transform(laps[i].stops.deviation);
}

/// @return whether the joints cover the line
bool place_evenly(const std::vector<LineLap>& laps, Observation& seen) {
  double density = std::numeric_limits<double>::infinity();
  for (const LineLap& lap : laps) density = std::min(density, static_cast<double>(lap.lap.x.size()));
  const Index places = smooth_number(kPlacesPerTurn);
  seen.transform = CosineTransform(
      places, 1.0, std::min(kHighestFrequency, density / (2.0 * kValuesPerCoefficient) - 1.0));
  seen.readings_per_turn = density;
  const VectorXd way = (VectorXd::LinSpaced(places, 0.0, static_cast<double>(places - 1)).array() + 0.5) /
                       static_cast<double>(places);
  seen.place = seen.instrument.length * (seen.direction > 0 ? way : VectorXd(1.0 - way.array()));
  if (!set_times(laps.front().lap, seen)) return false;
  seen.laps.resize(seen.transform.frequency().size(), static_cast<Index>(laps.size()));
  for (std::size_t i = 0; i < laps.size(); ++i)
    seen.laps.col(static_cast<Index>(i)) = seen.transform.fit(laps[i].lap.x, laps[i].lap.deviation);
  return true;
}

}  // namespace

std::string axes_of(const Run& run) {
  std::string axes;
  for (const InterferometerReading& reading : run.readings)
    if (axes.find(reading.axis) == std::string::npos) axes += reading.axis;
  std::sort(axes.begin(), axes.end());
  return axes;
}

std::optional<Observation> observe_line(const std::vector<const MeasuredRun*>& laps, char axis,
                                        const TestSpec& test, const RobotModel& model,
                                        std::vector<std::string>& left_aside) {
  std::vector<LineLap> usable;
  std::vector<const Run*> used;
  for (const MeasuredRun* measured : laps) {
    const Run& run = measured->run;
    std::string fault;
    std::optional<LineLap> lap = lap_on(run, axis, test.line, model, fault);
    if (lap && !usable.empty() &&
        (lap->at_rest != usable.front().at_rest || (lap->at_rest && !same_stops(*lap, usable.front()))))
      fault = "it was not read at the same points as the lap before it; drive all laps alike";
    if (fault.empty()) {
      usable.push_back(std::move(*lap));
      used.push_back(&run);
    } else {
      left_aside.push_back(run_name(run) + " " + axis + ": " + fault);
    }
  }
  if (usable.empty()) return std::nullopt;
  const LineFrame frame = frame_of(test.line);
  Observation seen;
  describe(used, seen);
  seen.instrument.kind = TestKind::kLine;
  seen.instrument.origin = frame.start;
  seen.instrument.axis = axis;
  seen.instrument.across = frame.across(axis);
  seen.instrument.length = (Eigen::Map<const Eigen::Vector3d>(test.line.end.data()) - frame.start).norm();
  seen.said = usable.front().said;
  if (usable.front().at_rest) {
    place_stops(usable, seen);
  } else if (!place_evenly(usable, seen)) {
    left_aside.push_back(run_name(*used.front()) + " " + axis + ": its joints do not cover the line");
    return std::nullopt;
  }
  seen.measured = seen.laps.rowwise().mean();
  return seen;
}

}  // namespace ballbar
