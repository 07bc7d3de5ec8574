#include "gap/proposed_tests.hpp"

#include <Eigen/Geometry>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <optional>

#include "core/error.hpp"
#include "core/text.hpp"
#include "core/units.hpp"
#include "gap/commanded_path.hpp"
#include "gap/observation_parts.hpp"
#include "numerics/noise_spectrum.hpp"
#include "numerics/vector3.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr int kLaps = 2;
constexpr double kLeastOvershoot = kPi / 3.0;  // for play to be crossed before the arc
constexpr double kHigher = 0.13, kMoreLoad = 2.0, kFaster = 2.0;
constexpr double kLikelyFeed = 0.055;  // [m/s] where none is configured
constexpr std::size_t kMostPlaces = 2;
constexpr double kOfSpeedLimit = 0.8;

Vec3 vec3_of(const Vector3d& v) { return {v[0], v[1], v[2]}; }

/// Angles of turns about the base's X, then Y, then Z.
Vec3 rpy_of(const Matrix3d& r) {
  return {std::atan2(r(2, 1), r(2, 2)), std::asin(std::clamp(-r(2, 0), -1.0, 1.0)),
          std::atan2(r(1, 0), r(0, 0))};
}

std::string degrees(double angle) { return std::to_string(std::lround(angle / kRadPerDeg)); }

/// A change of a circle's geometry; tilts are tried with one angle after another.
struct Change {
  enum class What { kNone, kPlane, kTool, kRaised, kSmall } what = What::kNone;
  int axis = 0;
  double sign = 1.0;
};

ProposedTest changed(const TestSpec& base, const Matrix3d& tool, const Change& change, double angle) {
  ProposedTest made{base, ""};
  TestSpec& test = made.test;
  test.circle.overshoot = std::max(test.circle.overshoot, kLeastOvershoot);
  if (!(test.feed > 0.0)) test.feed = kLikelyFeed;
  const Matrix3d turn =
      Eigen::AngleAxisd(change.sign * angle, Vector3d::Unit(change.axis)).toRotationMatrix();
  const std::string by = " tilted by " + std::string(change.sign < 0.0 ? "-" : "") + degrees(angle) +
                         " deg about " + "XYZ"[change.axis];
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
      for (Index j = 0; j < path.motion.q.rows(); ++j) {
        const double limit = model.limits()[static_cast<std::size_t>(j)].velocity;
        const Index n = path.motion.q.cols();
        const double fastest =
            ((path.motion.q.row(j).tail(n - 1) - path.motion.q.row(j).head(n - 1)).array() /
             (path.motion.time.tail(n - 1) - path.motion.time.head(n - 1)).transpose().array())
                .abs()
                .maxCoeff();
        if (limit > 0.0 && fastest > kOfSpeedLimit * limit) return false;
      }
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

double heavy_of(const RobotSpec& robot) {
  double lightest = robot.payload, heaviest = robot.payload;
  for (const TestSpec& test : robot.tests) {
    lightest = std::min(lightest, test.payload.value_or(robot.payload));
    heaviest = std::max(heaviest, test.payload.value_or(robot.payload));
  }
  return heaviest > lightest + 0.5 ? heaviest : lightest + kMoreLoad;
}

std::string joined(const std::string& a, const std::string& b) {
  return a.empty() ? b : b.empty() ? a : a + ", " + b;
}

}  // namespace

std::vector<ProposedTest> proposed_tests(const GapModel& model, std::optional<double> payload,
                                         const Progress& progress) {
  using What = Change::What;
  const std::vector<Change> changes{{What::kNone},          {What::kPlane, 1, 1.0},  {What::kPlane, 1, -1.0},
                                    {What::kPlane, 0, 1.0}, {What::kPlane, 0, -1.0}, {What::kTool, 1, 1.0},
                                    {What::kTool, 1, -1.0}, {What::kTool, 0, 1.0},   {What::kRaised},
                                    {What::kSmall}};
  const std::vector<const TestSpec*> places = places_of(model.spec());
  const double heavy = payload.value_or(heavy_of(model.spec()));
  std::vector<ProposedTest> all;
  std::size_t done = 0;
  for (const TestSpec* place : places) {
    std::optional<Matrix3d> tool;
    try {
      tool = tool_orientation(model.model(), *place);
    } catch (const Error&) {  // how the tool is held is not configured: nothing to go by
    }
    for (const Change& change : changes) {
      if (progress) progress(done, places.size() * changes.size());
      ++done;
      if (!tool) continue;
      std::optional<ProposedTest> plain;
      for (const double tilt : {30.0, 20.0}) {
        ProposedTest tried = changed(*place, *tool, change, tilt * kRadPerDeg);
        if (can_be_driven(model.model(), tried.test)) {
          plain = std::move(tried);
          break;
        }
      }
      if (!plain) continue;
      const std::string at = " about the centre of " + place->name;
      const double light = place->payload.value_or(model.spec().payload);
      const auto add = [&](ProposedTest one, const std::string& more) {
        one.differs = joined(one.differs, more);
        if (one.differs.empty()) one.differs = "nothing changed";
        one.differs += at;
        one.test.name = place->name + "-" + std::to_string(all.size() + 1);
        all.push_back(std::move(one));
      };
      add(*plain, "");
      if (std::abs(heavy - light) > 0.1 && model.loads_known()) {
        ProposedTest loaded = *plain;
        loaded.test.payload = heavy;
        add(std::move(loaded), to_hundredths(heavy) + " kg");
      }
      ProposedTest fast = *plain;
      fast.test.feed *= kFaster;
      if (can_be_driven(model.model(), fast.test)) add(std::move(fast), "twice the feed");
    }
  }
  return all;
}

LapNoise lap_noise_of(const std::vector<Observation>& observations) {
  for (const Observation& seen : observations)
    if (seen.instrument.is_bar() && seen.variance.size() > 1 && seen.feed > 0.0)
      return {seen.transform.frequency(),
              seen.variance * static_cast<double>(std::max<Index>(1, seen.laps.cols())),
              kTurn * seen.instrument.radius / seen.feed};
  const NoiseSpectrum usual{0.49e-12, 4.9e-12, 5.0};
  const VectorXd frequency = VectorXd::LinSpaced(361, 0.0, kHighestFrequency);
  return {frequency, usual.variance(frequency), 11.0};
}

namespace {

double variance_at(const LapNoise& noise, double frequency) {
  const auto above = std::lower_bound(noise.frequency.begin(), noise.frequency.end(), frequency);
  const Index k = std::min<Index>(above - noise.frequency.begin(), noise.frequency.size() - 1);
  return noise.variance[k];
}

}  // namespace

std::vector<Observation> as_observed(const GapModel& model, const TestSpec& test, int set_up,
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
    const VectorXd& frequency = seen.transform.frequency();
    const double sparser = noise.time_per_turn * test.feed / (kTurn * circle.radius);
    seen.variance.resize(frequency.size());
    for (Index k = 0; k < frequency.size(); ++k)
      seen.variance[k] = variance_at(noise, frequency[k]) * sparser / kLaps;
    seen.measured = VectorXd::Zero(frequency.size());
    seen.laps = Eigen::MatrixXd::Zero(frequency.size(), kLaps);
    seen.readings_per_turn = kPlacesPerTurn;
    both.push_back(std::move(seen));
  }
  return both;
}

}  // namespace ballbar
