#include "gap/proposed_tests.hpp"

#include <algorithm>
#include <cmath>
#include <iterator>
#include <numeric>
#include <optional>

#include "core/error.hpp"
#include "core/units.hpp"
#include "gap/commanded_path.hpp"
#include "gap/observation_parts.hpp"
#include "gap/proposed_lines.hpp"
#include "gap/proposed_parts.hpp"
#include "numerics/noise_spectrum.hpp"
#include "numerics/vector3.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kLeastOvershoot = kPi / 3.0;  // for play to be crossed before the arc
constexpr double kHigher = 0.13;               // [m]

/// A change of a circle's geometry; tilts are tried with one angle after another.
struct Change {
  enum class What { kNone, kPlane, kTool, kRaised, kSmall } what = What::kNone;
  int axis = 0;
  double sign = 1.0;
};

constexpr Change kChanges[] = {{Change::What::kNone},           {Change::What::kPlane, 1, 1.0},
                               {Change::What::kPlane, 1, -1.0}, {Change::What::kPlane, 0, 1.0},
                               {Change::What::kPlane, 0, -1.0}, {Change::What::kTool, 1, 1.0},
                               {Change::What::kTool, 1, -1.0},  {Change::What::kTool, 0, 1.0},
                               {Change::What::kRaised},         {Change::What::kSmall}};

ProposedTest changed(const TestSpec& base, const Matrix3d& tool, const Change& change, double angle) {
  ProposedTest made{base, ""};
  TestSpec& test = made.test;
  test.circle.overshoot = std::max(test.circle.overshoot, kLeastOvershoot);
  if (!(test.feed > 0.0)) test.feed = kLikelyFeed;
  const Matrix3d turn = turn_about(change.axis, change.sign * angle);
  const std::string by = tilt_words(change.axis, change.sign * angle);
  switch (change.what) {
    case Change::What::kNone:
      break;
    case Change::What::kPlane:
      test.circle.normal = vec3_of(turn * vector_of(base.circle.normal));
      test.circle.first_axis = vec3_of(turn * vector_of(base.circle.first_axis));
      test.tool_rpy = rpy_of(turn * tool);
      made.differs = "plane and tool" + by;
      break;
    case Change::What::kTool:
      test.tool_rpy = rpy_of(turn * tool);
      made.differs = "tool" + by;
      break;
    case Change::What::kRaised:
      test.circle.centre[2] += kHigher;
      made.differs = "raised by " + std::to_string(std::lround(to_mm(kHigher))) + " mm";
      break;
    case Change::What::kSmall:
      test.circle.radius /= 2.0;
      made.differs = "half the radius";
      break;
  }
  return made;
}

bool can_be_driven(const RobotModel& model, const TestSpec& test) {
  try {
    for (const int direction : {1, -1}) {
      const double rate = kPlacesPerTurn * test.feed / (kTurn * test.circle.radius);
      const CommandedPath path = commanded_circle(model, test, direction, test.feed, rate);
      if (!within_joint_speeds(model, path.motion)) return false;
    }
  } catch (const Error&) {
    return false;
  }
  return true;
}

/// Circles at other places, the first ones of the configuration.
std::vector<const TestSpec*> places_of(const RobotSpec& robot) {
  std::vector<const TestSpec*> places;
  for (const TestSpec& test : robot.tests) {
    const bool known = std::any_of(places.begin(), places.end(), [&](const TestSpec* place) {
      return place->circle.centre == test.circle.centre;
    });
    if (test.kind == TestKind::kCircle && !known && places.size() < kMostPlaces) places.push_back(&test);
  }
  return places;
}

/// Of circles about one place.
void propose_circles(const GapModel& model, const TestSpec& place, double heavy, TestNames& names,
                     const std::function<void()>& step, std::vector<ProposedTest>& all) {
  const std::optional<Matrix3d> tool = known_tool_orientation(model.model(), place);
  if (!tool) return;  // nothing to go by
  for (const Change& change : kChanges) {
    step();
    std::optional<ProposedTest> plain;
    for (const double tilt : kPlannedTilts) {
      ProposedTest tried = changed(place, *tool, change, tilt * kRadPerDeg);
      if (can_be_driven(model.model(), tried.test)) {
        plain = std::move(tried);
        break;
      }
    }
    if (!plain) continue;
    add_variants(
        model, *plain, heavy, [&](const TestSpec& fast) { return can_be_driven(model.model(), fast); },
        [&](ProposedTest one, const std::string& more) {
          one.differs = joined(one.differs, more);
          if (one.differs.empty()) one.differs = "nothing changed";
          one.differs += " about the centre of " + place.name;
          one.test.name = names.next(place.name);
          all.push_back(std::move(one));
        });
  }
}

}  // namespace

PlanScope scope_of(const std::vector<Observation>& driven) {
  return {.on_the_way = !lap_noise_of(driven, TestKind::kLine).at_stops};
}

std::vector<ProposedTest> proposed_tests(const GapModel& model, const PlanScope& scope,
                                         const Progress& progress) {
  const double heavy = scope.payload.value_or(heavy_of(model.spec()));
  const std::vector<const TestSpec*> places = places_of(model.spec());
  const std::vector<LinePlace> lines = line_places_of(model.spec(), scope.lines);
  const std::size_t of = places.size() * std::size(kChanges) + lines.size() * kLineChanges;
  TestNames names(model.spec());
  std::vector<ProposedTest> all;
  std::size_t done = 0;
  const auto step = [&] {
    if (progress) progress(done, of);
    ++done;
  };
  for (const TestSpec* place : places) propose_circles(model, *place, heavy, names, step, all);
  for (const LinePlace& place : lines) propose_lines(model, place, scope.on_the_way, heavy, names, step, all);
  return all;
}

LapNoise lap_noise_of(const std::vector<Observation>& observations, TestKind kind) {
  for (const Observation& seen : observations) {
    if (seen.instrument.kind != kind || seen.variance.size() < 2 || !(seen.feed > 0.0)) continue;
    const double way = seen.instrument.is_bar() ? kTurn * seen.instrument.radius : seen.instrument.length;
    return {seen.transform.frequency(),
            seen.variance * static_cast<double>(std::max<Index>(1, seen.laps.cols())), way / seen.feed,
            seen.at_rest || seen.instrument.is_bar()};
  }
  const NoiseSpectrum usual{0.49e-12, 4.9e-12, 5.0};
  const VectorXd frequency = VectorXd::LinSpaced(361, 0.0, kHighestFrequency);
  return {frequency, usual.variance(frequency), 11.0};
}

namespace {

std::vector<Observation> circle_as_observed(const GapModel& model, const TestSpec& test, int set_up,
                                            const LapNoise& noise) {
  std::vector<Observation> both;
  const CircleSpec& circle = test.circle;
  const double turns = circle.arc_sweep / kTurn;
  for (const int direction : {1, -1}) {
    const double rate = kPlacesPerTurn * test.feed / (kTurn * circle.radius);
    CommandedPath path = commanded_circle(model.model(), test, direction, test.feed, rate);
    Observation seen;
    const Index places = std::lround(kPlacesPerTurn * turns);
    seen.runs = {test.name + (direction > 0 ? "+1" : "-1")};
    seen.test = test.name;
    seen.direction = direction;
    seen.feed = test.feed;
    seen.instrument = {TestKind::kCircle, vector_of(circle.centre), circle.radius};
    seen.set_up = set_up;
    seen.conditions.payload = test.payload.value_or(model.spec().payload);
    seen.conditions.ball = seen.instrument.origin;
    seen.transform = CosineTransform(places, turns, std::min(kHighestFrequency, kPlacesPerTurn * 0.45));
    seen.place.resize(places);
    for (Index k = 0; k < places; ++k) {
      const double way = (static_cast<double>(k) + 0.5) / static_cast<double>(places);
      seen.place[k] = circle.arc_start + circle.arc_sweep * (direction > 0 ? way : 1.0 - way);
    }
    // In the middles of the path's steps, a few steps inside its ends: clocks may differ.
    const Index room = 1 + static_cast<Index>(std::ceil(kShiftRoom * rate));
    const Index behind = std::min(static_cast<Index>(kBehindWay * rate),
                                  path.motion.time.size() - path.arc_begin - places - room);
    const Index before = path.arc_begin - room;
    seen.sample.resize(static_cast<std::size_t>(places));
    std::iota(seen.sample.begin(), seen.sample.end(), before);
    seen.time = path.motion.time.segment(room, before + places + behind).array() + 0.5 / rate;
    seen.said = std::move(path.motion);
    leave_unmeasured(seen, noise, noise.time_per_turn * test.feed / (kTurn * circle.radius));
    seen.readings_per_turn = kPlacesPerTurn;
    both.push_back(std::move(seen));
  }
  return both;
}

}  // namespace

std::vector<Observation> as_observed(const GapModel& model, const TestSpec& test, int set_up,
                                     const LapNoise& noise) {
  if (!(test.feed > 0.0))
    throw Error(Cause::kInput, "test '" + test.name + "': give 'feed_mm_s', the speed of the tool point");
  return test.kind == TestKind::kLine ? line_as_observed(model, test, set_up, noise)
                                      : circle_as_observed(model, test, set_up, noise);
}

}  // namespace ballbar
