#include "gap/simulate.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <map>
#include <optional>
#include <random>
#include <stdexcept>
#include <utility>

#include "core/error.hpp"
#include "core/units.hpp"
#include "gap/ball_fit.hpp"
#include "metrology/arc.hpp"
#include "metrology/line.hpp"
#include "numerics/interpolate.hpp"
#include "numerics/vector3.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kBarRate = 246.0;            // [1/s]
constexpr int kFewestPerTurn = 72;            // bar samples, however fast the circle
constexpr Index kBarBlock = 50;               // samples a message
constexpr double kCircleJointsUs = 8e3;       // 125 Hz
constexpr double kLineJointsUs = 20e3;        // 50 Hz
constexpr double kLineRate = 100.0;           // [1/s] of the path of a line
constexpr double kDwellSimulated = 0.3;       // [s] stop at each point of a line
constexpr double kReading = 0.04;             // [s] before a stop ends
constexpr double kRest = 0.2;                 // [s] between a mark and the motion
constexpr std::int64_t kPauseUs = 4'000'000;  // between two runs
constexpr Index kMargin = 2;                  // samples beyond the marks, for interpolation

std::int64_t to_us(double seconds) { return std::llround(seconds / kSecondsPerUs); }

/// A generator of its own for each run. Source of the hash: FNV-1a, 64 bits.
std::mt19937_64 noise_of(const SimulateOptions& options, const std::string& robot, const SimulatedRun& run) {
  std::uint64_t hash = 14695981039346656037ULL;
  const auto add = [&hash](std::uint64_t byte) { hash = (hash ^ byte) * 1099511628211ULL; };
  for (int i = 0; i < 64; i += 8) add(options.seed >> i & 0xFFU);
  for (const std::string& text : {robot, run.test}) {
    for (const char c : text) add(static_cast<unsigned char>(c));
    add(0);
  }
  add(run.direction > 0 ? 1 : 2);
  for (int i = 0; i < 32; i += 8) add(static_cast<std::uint32_t>(run.repetition) >> i & 0xFFU);
  return std::mt19937_64(hash);
}

/// Columns at other times; a motion is smooth and has no holes.
Eigen::MatrixXd at_times(const Motion& motion, const Eigen::MatrixXd& columns, const VectorXd& times) {
  constexpr double kAnyPlace = std::numeric_limits<double>::infinity();
  return interpolate(motion.time, columns, times, kAnyPlace, Interpolation::kCubic);
}

/// The commanded motion of a run by the run's clock, at rest before and behind; `lead` samples stand before
/// the path's own.
struct RunMotion {
  Motion motion;
  Index lead = 0;
  double duration = 0.0;  ///< [s] from mark to mark
};

RunMotion run_motion(const CommandedPath& path) {
  const VectorXd& time = path.motion.time;
  const Index n = time.size();
  const double period = (time[n - 1] - time[0]) / static_cast<double>(n - 1);
  RunMotion run;
  run.duration = path.duration + 2.0 * kRest;
  run.lead = static_cast<Index>(std::floor((kRest + time[0]) / period)) + kMargin;
  const Index tail = static_cast<Index>(std::floor((run.duration - kRest - time[n - 1]) / period)) + kMargin;
  const Index all = run.lead + n + tail;
  run.motion.time =
      (VectorXd::LinSpaced(all, 0.0, static_cast<double>(all - 1)).array() - static_cast<double>(run.lead)) *
          period +
      (kRest + time[0]);
  run.motion.q.resize(path.motion.q.rows(), all);
  run.motion.q << path.motion.q.col(0).replicate(1, run.lead), path.motion.q,
      path.motion.q.col(n - 1).replicate(1, tail);
  return run;
}

double feed_of(const TestSpec& test) {
  if (!(test.feed > 0.0))
    throw Error(Cause::kInput, "test '" + test.name + "': give 'feed_mm_s', the speed of the tool point");
  return test.feed;
}

CommandedPath commanded(const RobotModel& model, const TestSpec& test, int direction) {
  const double feed = feed_of(test);
  if (test.kind == TestKind::kLine)
    return commanded_line(model, test, direction, feed, kDwellSimulated, kLineRate);
  const double turn = kTurn * test.circle.radius / feed;
  const double samples = std::max<double>(kFewestPerTurn, std::round(kBarRate * turn));
  return commanded_circle(model, test, direction, feed, samples / turn);
}

/// The ball, at the points' mean height above the plane, from which their distances differ least from one
/// radius. Not the circle of their projections: the bar is as long as the way in space.
Vector3d fitted_ball(const TestSpec& test, const Eigen::Matrix3Xd& points) {
  const CirclePlane plane = plane_of(test.circle);
  const PointsAt local = [&](double /*time_shift*/) { return in_plane(plane, points); };
  const VectorXd radius = VectorXd::Constant(points.cols(), test.circle.radius);
  const std::optional<BallFit> fit = fit_ball(local, radius, local(0.0).rowwise().mean(), false);
  if (!fit)
    throw Error(Cause::kInput,
                "test '" + test.name + "': the true tool points lie on no circle; set the ball otherwise");
  return from_plane(plane, fit->ball);
}

/// @param on_arc  [m] true tool points of the measured arc
Vector3d place_ball(const AsBuilt& as_built, const TestSpec& test, BallPlacement placement,
                    const Eigen::Matrix3Xd& on_arc, const Conditions& conditions) {
  if (placement == BallPlacement::kProgrammed) return vector_of(test.circle.centre);
  if (placement == BallPlacement::kFitted) return fitted_ball(test, on_arc);
  Motion still{VectorXd::Zero(1), {}};
  still.q =
      commanded_posture(as_built.model(), test, vector_of(test.circle.centre), "at the centre of the circle");
  return as_built.tool_points(still, conditions).col(0);
}

/// Everything that is the same for all runs, and counts on from run to run.
class Simulator {
 public:
  Simulator(const AsBuilt& as_built, const RobotSpec& robot, const SimulateOptions& options)
      : as_built_(as_built), robot_(robot), options_(options), begin_us_(options.start_us) {}

  SimulatedRun drive(const TestSpec& test, const std::shared_ptr<const CommandedPath>& path, int direction,
                     int repetition);

 private:
  SampleHeader header(std::size_t stream, double time) {
    return {begin_us_ + to_us(time), ++seq_.at(stream), robot_.name};
  }
  void mark(SimulatedRun& run, const TestSpec& test, Mark mark, double time);
  void joints(SimulatedRun& run, const Motion& motor, double duration, double period_us,
              const Conditions& conditions);
  void bar(SimulatedRun& run, const TestSpec& test, const RunMotion& driven, const Motion& motor,
           const Conditions& conditions);
  void interferometer(SimulatedRun& run, const TestSpec& test, const Motion& motor,
                      const Conditions& conditions);

  const AsBuilt& as_built_;
  const RobotSpec& robot_;
  const SimulateOptions& options_;
  std::int64_t begin_us_;
  std::array<std::int64_t, 4> seq_{};  ///< BALLBAR, INTERFEROMETER, JOINTS, TEST_MARK
  std::map<Vec3, Vector3d> balls_;     ///< by programmed centre
};

SimulatedRun Simulator::drive(const TestSpec& test, const std::shared_ptr<const CommandedPath>& path,
                              int direction, int repetition) {
  SimulatedRun run;
  run.test = test.name;
  run.kind = test.kind;
  run.direction = direction;
  run.repetition = repetition;
  run.commanded = path;
  const bool circle = test.kind == TestKind::kCircle;
  Conditions conditions{test.payload.value_or(robot_.payload),
                        static_cast<double>(begin_us_ - options_.start_us) * kSecondsPerUs, begin_us_};
  if (circle) conditions.ball = vector_of(test.circle.centre);
  const RunMotion driven = run_motion(*path);
  const Motion motor = as_built_.follow(driven.motion, conditions);
  mark(run, test, Mark::kBegin, 0.0);
  joints(run, as_built_.joints_are_commanded() ? driven.motion : motor, driven.duration,
         circle ? kCircleJointsUs : kLineJointsUs, conditions);
  if (circle)
    bar(run, test, driven, motor, conditions);
  else
    interferometer(run, test, motor, conditions);
  mark(run, test, Mark::kEnd, driven.duration);
  std::stable_sort(run.samples.begin(), run.samples.end(),
                   [](const Sample& a, const Sample& b) { return sent_us(a) < sent_us(b); });
  begin_us_ += to_us(driven.duration) + kPauseUs;
  return run;
}

void Simulator::mark(SimulatedRun& run, const TestSpec& test, Mark mark, double time) {
  run.samples.emplace_back(TestMark{header(3, time),
                                    test.name,
                                    mark,
                                    run.direction,
                                    run.repetition,
                                    options_.series,
                                    test.feed,
                                    test.payload.value_or(robot_.payload),
                                    {}});
}

void Simulator::joints(SimulatedRun& run, const Motion& motor, double duration, double period_us,
                       const Conditions& conditions) {
  const auto messages = static_cast<Index>(std::floor(duration / (period_us * kSecondsPerUs))) + 1;
  Motion sent;
  sent.time =
      VectorXd::LinSpaced(messages, 0.0, static_cast<double>(messages - 1)) * (period_us * kSecondsPerUs);
  sent.q = at_times(motor, motor.q, sent.time);
  const Eigen::MatrixXd reading = as_built_.readback(sent, conditions);
  for (Index i = 0; i < messages; ++i) {
    JointSample sample{header(2, sent.time[i]), {reading.col(i).begin(), reading.col(i).end()}, {}};
    as_built_.model().from_chain(sample.position);
    run.samples.emplace_back(std::move(sample));
  }
}

void Simulator::bar(SimulatedRun& run, const TestSpec& test, const RunMotion& driven, const Motion& motor,
                    const Conditions& conditions) {
  const CommandedPath& path = *run.commanded;
  const Eigen::Matrix3Xd points = as_built_.tool_points(motor, conditions);
  const Index arc = driven.lead + path.arc_begin;
  const Index on_arc = path.arc_end - path.arc_begin;
  const auto found = balls_.find(test.circle.centre);
  run.ball = found != balls_.end()
                 ? found->second
                 : balls_
                       .emplace(test.circle.centre, place_ball(as_built_, test, options_.ball,
                                                               points.middleCols(arc, on_arc), conditions))
                       .first->second;
  const Index first = kMargin;
  const Index count = points.cols() - 2 * kMargin;
  const VectorXd time = driven.motion.time.segment(first, count);
  const Eigen::Matrix3Xd ball = as_built_.ball_displacement(time, conditions).colwise() + run.ball;
  VectorXd deviation = (points.middleCols(first, count) - ball).colwise().norm().transpose();
  deviation.array() -= test.circle.radius;
  deviation += as_built_.gauge_offset(time, conditions);
  std::mt19937_64 generator = noise_of(options_, robot_.name, run);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (double& d : deviation) d += options_.noise * normal(generator);
  run.angle = path.angle.segment(path.arc_begin, on_arc);
  run.deviation = deviation.segment(arc - first, on_arc);

  const double period = time[1] - time[0];
  for (Index i = 0; i < count; i += kBarBlock) {
    const VectorXd block = deviation.segment(i, std::min(kBarBlock, count - i));
    run.samples.emplace_back(BallbarBlock{header(0, time[i]), period, {block.begin(), block.end()}});
  }
}

void Simulator::interferometer(SimulatedRun& run, const TestSpec& test, const Motion& motor,
                               const Conditions& conditions) {
  const CommandedPath& path = *run.commanded;
  const VectorXd time = path.stop_end.array() + (kRest - kReading);
  const Eigen::Matrix3Xd points = at_times(motor, as_built_.tool_points(motor, conditions), time);
  const LineFrame frame = frame_of(test.line);
  const std::string axes = frame.axes_across();
  Eigen::MatrixX2d deviation(time.size(), 2);
  deviation << frame.deviations(points, axes[0]), frame.deviations(points, axes[1]);
  std::mt19937_64 generator = noise_of(options_, robot_.name, run);
  std::normal_distribution<double> normal(0.0, 1.0);
  for (Index k = 0; k < time.size(); ++k)
    for (Index i = 0; i < 2; ++i)
      run.samples.emplace_back(InterferometerBlock{header(1, time[k]),
                                                   axes[static_cast<std::size_t>(i)],
                                                   {path.stop_position[k]},
                                                   {deviation(k, i) + options_.noise * normal(generator)}});
}

}  // namespace

HarmonicFit bar_harmonics(const SimulatedRun& circle) {
  constexpr int kOrders = 10;
  return fit_harmonics(circle.angle, circle.deviation, kOrders);
}

std::int64_t sent_us(const Sample& sample) {
  const auto* bar = std::get_if<BallbarBlock>(&sample);
  const std::int64_t first = std::visit([](const auto& s) { return s.header.time_us; }, sample);
  if (!bar || bar->deviation.empty()) return first;
  return first + to_us(static_cast<double>(bar->deviation.size() - 1) * bar->period);
}

void simulate(const AsBuilt& as_built, const RobotSpec& robot, const SimulateOptions& options,
              const std::function<void(SimulatedRun)>& take) {
  std::vector<const TestSpec*> tests;
  for (const std::string& name : options.tests) {
    tests.push_back(robot.find_test(name));
    if (tests.back()) continue;
    std::string known;
    for (const TestSpec& test : robot.tests) known += (known.empty() ? "" : ", ") + test.name;
    throw Error(Cause::kInput, "robot '" + robot.name + "' has no test '" + name +
                                   "'; configured are: " + (known.empty() ? "none" : known));
  }
  if (options.tests.empty())
    for (const TestSpec& test : robot.tests) tests.push_back(&test);
  Simulator simulator(as_built, robot, options);
  for (const TestSpec* test : tests) {
    std::vector<std::shared_ptr<const CommandedPath>> paths;
    for (const int direction : options.directions)
      paths.push_back(std::make_shared<const CommandedPath>(commanded(as_built.model(), *test, direction)));
    for (int repetition = 1; repetition <= options.repetitions; ++repetition)
      for (std::size_t i = 0; i < paths.size(); ++i)
        take(simulator.drive(*test, paths[i], options.directions[i], repetition));
  }
}

}  // namespace ballbar
