#include "gap/gap_model.hpp"

#include <cmath>
#include <limits>

#include "core/error.hpp"
#include "metrology/arc.hpp"
#include "numerics/interpolate.hpp"
#include "physics/catalogue.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Matrix3Xd;
using Eigen::MatrixXd;
using Eigen::VectorXd;

std::span<const double> column(const MatrixXd& q, Index k) {
  return {q.col(k).data(), static_cast<std::size_t>(q.rows())};
}

/// With what the instrument's scale, zero and jumps make of it.
VectorXd reading_of(const AsBuilt& built, const Observation& seen, const GapState& state,
                    const VectorXd& perfect, const VectorXd& time) {
  if (!seen.instrument.is_bar()) return perfect;
  return (1.0 + state.bar_scale) * perfect + built.gauge_offset(time, seen.conditions) +
         VectorXd::Constant(time.size(), state.bar_zero);
}

/// A joint at rest keeps the direction in which it came, too slowly for anything but its sign to count.
void keep_direction(const MatrixXd& speed, const std::vector<Index>& sample, MatrixXd& at_place) {
  constexpr double kMoves = 1e-4, kAtRest = 1e-9;  // [rad/s]
  for (Index joint = 0; joint < speed.rows(); ++joint) {
    for (std::size_t k = 0; k < sample.size(); ++k) {
      Index last = sample[k];
      while (last > 0 && std::abs(speed(joint, last)) < kMoves) --last;
      at_place(static_cast<Index>(k), joint) = speed(joint, last) < 0.0 ? -kAtRest : kAtRest;
    }
  }
}

}  // namespace

GapModel::GapModel(const AsBuilt& robot, const RobotSpec& spec) : robot_(robot), spec_(spec) {
  // Where JOINTS are what the motors' encoders read, a configured filter of the command is in them already;
  // one that is looked for acts on them.
  spec_.joints_commanded = true;
  if (!robot.joints_are_commanded()) {
    std::vector<Effect> behind;
    for (const Effect& effect : robot.effects())
      if (!effect.kind->command) behind.push_back(effect);
    robot_ = AsBuilt(robot.model(), spec_, std::move(behind));
  }
  try {
    model().payload(1.0, {spec.payload_com[0], spec.payload_com[1], spec.payload_com[2]}, "tool0");
    payload_known_ = true;
  } catch (const Error&) {
    payload_known_ = false;
  }
}

GapState GapModel::start(const std::vector<Observation>& observations) const {
  GapState state;
  state.zero = VectorXd::Zero(joints());
  int set_ups = 0;
  for (const Observation& seen : observations) set_ups = std::max(set_ups, seen.set_up + 1);
  state.set_up.assign(static_cast<std::size_t>(set_ups), Eigen::Vector3d::Zero());
  state.shift.assign(observations.size(), 0.0);
  return state;
}

AsBuilt GapModel::built(const GapState& state) const {
  std::vector<Effect> effects = robot_.effects();
  effects.insert(effects.end(), state.effects.begin(), state.effects.end());
  static const EffectKind* const zero = find_effect_kind("joint_zero_offset");
  for (Index j = 0; j < state.zero.size(); ++j)
    if (state.zero[j] != 0.0)
      effects.push_back({.kind = zero, .joint = static_cast<int>(j) + 1, .values = {state.zero[j]}});
  return {robot_.model(), spec_, std::move(effects)};
}

Motion GapModel::motor_of(const AsBuilt& built, const Observation& seen, std::size_t index,
                          const GapState& state) const {
  Motion said;
  said.time = seen.time.array() + state.shift[index];
  said.q = interpolate(seen.said.time, seen.said.q, said.time, std::numeric_limits<double>::infinity(),
                       Interpolation::kCubic);
  return built.follow(said, seen.conditions);
}

std::vector<Body> GapModel::bodies(const Conditions& conditions) const {
  std::vector<Body> bodies = model().bodies();
  if (payload_known_ && conditions.payload > 0.0)
    bodies.push_back(model().payload(
        conditions.payload, {spec_.payload_com[0], spec_.payload_com[1], spec_.payload_com[2]}, "tool0"));
  return bodies;
}

std::shared_ptr<Loads> GapModel::loads_of(const AsBuilt& built, const Observation& seen, const Motion& motor,
                                          const std::shared_ptr<Loads>& known) const {
  std::vector<Body> moved = bodies(seen.conditions);
  if (known && known->hold_for(motor, built.chain(), moved)) return known;
  return std::make_shared<Loads>(motor, built.chain(), std::move(moved));
}

Sight GapModel::seen_by(const AsBuilt& built, const Observation& seen, const GapState& state,
                        const MatrixXd& link_angles, const VectorXd& time) const {
  return sight_of(seen.instrument, built.tool_points(link_angles, time, seen.conditions), seen.place,
                  state.set_up[static_cast<std::size_t>(seen.set_up)],
                  built.ball_displacement(time, seen.conditions));
}

VectorXd GapModel::predict(const AsBuilt& built, const Observation& seen, std::size_t index,
                           const GapState& state, const std::shared_ptr<Loads>& known) const {
  const Motion motor = motor_of(built, seen, index, state);
  const std::shared_ptr<Loads> loads = loads_of(built, seen, motor, known);
  Drive drive(motor, *loads);
  const VectorXd time = seen.time(seen.sample);
  const MatrixXd links = built.link_angles(drive)(Eigen::all, seen.sample);
  return reading_of(built, seen, state, seen_by(built, seen, state, links, time).reading, time);
}

Tangent GapModel::tangent(const AsBuilt& built, const Observation& seen, std::size_t index,
                          const GapState& state, const std::shared_ptr<Loads>& known) const {
  const Index n = seen.places();
  Tangent at{.chain = built.chain()};
  at.motor = motor_of(built, seen, index, state);
  at.sample = seen.sample;
  at.bar = seen.instrument.is_bar();
  at.conditions = seen.conditions;
  at.loads = loads_of(built, seen, at.motor, known);
  at.time = seen.time(seen.sample);
  Drive drive = at.drive();
  at.speed = drive.speed()(Eigen::all, seen.sample).transpose();
  if (seen.at_rest) keep_direction(drive.speed(), seen.sample, at.speed);
  at.at_rest = seen.at_rest;
  const MatrixXd links = built.link_angles(drive)(Eigen::all, seen.sample);
  const Sight sight = seen_by(built, seen, state, links, at.time);
  at.predicted = reading_of(built, seen, state, sight.reading, at.time);
  at.along = sight.along;
  at.set_up = set_up_columns(seen.instrument, seen.place, at.along);
  at.joint = MatrixXd(n, joints());
  at.a = at.d = at.alpha = at.beta = at.joint;
  at.tool = MatrixXd(n, 3);
  for (Index k = 0; k < n; ++k) {
    const PositionColumns by = built.chain().position_columns(column(links, k));
    const Eigen::RowVector3d u = at.along.row(k);
    at.joint.row(k) = u * by.joint;
    at.a.row(k) = u * by.a;
    at.d.row(k) = u * by.d;
    at.alpha.row(k) = u * by.alpha;
    at.beta.row(k) = u * by.beta;
    at.tool.row(k) = u * by.tool;
  }
  return at;
}

VectorXd GapModel::push(const Tangent& at, Drive& drive, const Effect& effect) const {
  const EffectKind& kind = *effect.kind;
  const Index n = at.time.size(), row = effect.joint - 1;
  VectorXd sum = VectorXd::Zero(n);
  if (kind.deflection) sum += kind.deflection(effect, drive)(at.sample).cwiseProduct(at.joint.col(row));
  if (kind.command) {
    Motion followed = at.motor;
    kind.command(effect, followed);
    sum +=
        (followed.q - at.motor.q)(Eigen::all, at.sample).transpose().cwiseProduct(at.joint).rowwise().sum();
  }
  if (kind.geometry) {
    ChainDeviation deviation;
    deviation.links.resize(static_cast<std::size_t>(joints()));
    kind.geometry(effect, model().chain(), deviation);
    VectorXd grown = at.tool * deviation.tool;
    for (Index j = 0; j < joints(); ++j) {
      const LinkDeviation& link = deviation.links[static_cast<std::size_t>(j)];
      if (link.zero_offset != 0.0) grown += link.zero_offset * at.joint.col(j);
      if (link.a != 0.0) grown += link.a * at.a.col(j);
      if (link.d != 0.0) grown += link.d * at.d.col(j);
      if (link.alpha != 0.0) grown += link.alpha * at.alpha.col(j);
      if (link.beta != 0.0) grown += link.beta * at.beta.col(j);
    }
    if (kind.growth)
      for (Index k = 0; k < n; ++k) grown[k] *= kind.growth(effect, at.conditions.series_time + at.time[k]);
    sum += grown;
  }
  for (Index k = 0; k < n; ++k) {
    if (kind.base) sum[k] += at.along.row(k).dot(kind.base(effect, at.conditions.series_time + at.time[k]));
    if (kind.ball && at.bar) sum[k] -= at.along.row(k).dot(kind.ball(effect, at.time[k], at.conditions));
    if (kind.gauge && at.bar)
      sum[k] += kind.gauge(effect, at.time[k], static_cast<int>(k) + 1, at.conditions);
  }
  return sum;
}

}  // namespace ballbar
