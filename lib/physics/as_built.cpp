#include "physics/as_built.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>
#include <string>
#include <tuple>
#include <utility>

#include "core/error.hpp"
#include "physics/catalogue.hpp"
#include "physics/drive.hpp"

namespace ballbar {
namespace {

std::vector<Effect> read(const RobotSpec& spec, int joints) {
  std::vector<Effect> effects;
  for (const EffectSpec& effect : spec.effects) {
    try {
      effects.push_back(make_effect(effect, joints));
    } catch (const Error& error) {
      throw Error(error.cause(), "robot '" + spec.name + "': " + error.what());
    }
  }
  return effects;
}

Chain built(const Chain& nominal, const std::vector<Effect>& effects) {
  ChainDeviation deviation;
  deviation.links.resize(nominal.rows().size());
  for (const Effect& effect : effects)
    if (effect.kind->geometry && !effect.kind->growth) effect.kind->geometry(effect, nominal, deviation);
  return nominal.with(deviation);
}

void check(const Motion& motion, int joints) {
  if (motion.q.rows() != joints || motion.q.cols() != motion.time.size())
    throw std::invalid_argument("motion: " + std::to_string(motion.q.rows()) + " x " +
                                std::to_string(motion.q.cols()) + " angles for " + std::to_string(joints) +
                                " joints and " + std::to_string(motion.time.size()) + " times");
  for (Eigen::Index k = 1; k < motion.time.size(); ++k)
    if (!(motion.time(k) > motion.time(k - 1))) throw std::invalid_argument("motion: times must rise");
}

Eigen::Matrix3Xd points(const Chain& chain, const Eigen::MatrixXd& q) {
  Eigen::Matrix3Xd points(3, q.cols());
  for (Eigen::Index k = 0; k < q.cols(); ++k) {
    if (!q.col(k).allFinite()) {
      points.col(k).setConstant(std::numeric_limits<double>::quiet_NaN());
      continue;
    }
    points.col(k) = chain.tip({q.col(k).data(), static_cast<std::size_t>(q.rows())});
  }
  return points;
}

}  // namespace

AsBuilt::AsBuilt(const RobotModel& model, const RobotSpec& spec)
    : AsBuilt(model, spec, read(spec, model.joints())) {}

AsBuilt::AsBuilt(RobotModel model, const RobotSpec& spec, std::vector<Effect> effects)
    : model_(std::move(model)),
      joints_commanded_(spec.joints_commanded),
      chain_(model_.chain()),
      effects_(std::move(effects)) {
  // Pointers into one vector: the catalogue's order.
  std::sort(effects_.begin(), effects_.end(), [](const Effect& a, const Effect& b) {
    return std::tie(a.kind, a.joint, a.word, a.values) < std::tie(b.kind, b.joint, b.word, b.values);
  });
  chain_ = built(model_.chain(), effects_);
  const bool loaded =
      std::any_of(effects_.begin(), effects_.end(), [](const Effect& e) { return e.kind->loaded; });
  if (loaded)
    payload_ = model_.payload(1.0, {spec.payload_com[0], spec.payload_com[1], spec.payload_com[2]}, "tool0");
}

Motion AsBuilt::follow(const Motion& command, const Conditions& /*conditions*/) const {
  check(command, model_.joints());
  Motion motor = command;
  for (const Effect& effect : effects_)
    if (effect.kind->command) effect.kind->command(effect, motor);
  return motor;
}

Eigen::MatrixXd AsBuilt::link_angles(const Motion& motor, const Conditions& conditions) const {
  check(motor, model_.joints());
  std::vector<Body> bodies = model_.bodies();
  if (payload_ && conditions.payload > 0.0) {
    bodies.push_back(*payload_);
    bodies.back().mass = conditions.payload;
  }
  Loads loads(motor, chain_, std::move(bodies));
  Drive drive(motor, loads);
  return link_angles(drive);
}

Eigen::MatrixXd AsBuilt::link_angles(Drive& drive) const {
  Eigen::MatrixXd q = drive.motor().q;
  for (const Effect& effect : effects_)
    if (effect.kind->deflection)
      q.row(effect.joint - 1) += effect.kind->deflection(effect, drive).transpose();
  return q;
}

Eigen::Matrix3Xd AsBuilt::tool_points(const Motion& motor, const Conditions& conditions) const {
  return tool_points(link_angles(motor, conditions), motor.time, conditions);
}

Eigen::Matrix3Xd AsBuilt::tool_points(const Eigen::MatrixXd& q, const Eigen::VectorXd& time,
                                      const Conditions& conditions) const {
  const Eigen::Matrix3Xd at_begin = points(chain_, q);
  Eigen::Matrix3Xd all = at_begin;
  for (const Effect& effect : effects_) {
    const EffectKind& kind = *effect.kind;
    if (kind.growth) {
      // The point is linear in lengths, so growth needs the chain as grown once, not at each time.
      ChainDeviation deviation;
      deviation.links.resize(static_cast<std::size_t>(model_.joints()));
      kind.geometry(effect, model_.chain(), deviation);
      const Eigen::Matrix3Xd grown = points(chain_.with(deviation), q) - at_begin;
      for (Eigen::Index k = 0; k < q.cols(); ++k)
        all.col(k) += kind.growth(effect, conditions.series_time + time(k)) * grown.col(k);
    }
    if (kind.base)
      for (Eigen::Index k = 0; k < q.cols(); ++k)
        all.col(k) += kind.base(effect, conditions.series_time + time(k));
  }
  return all;
}

Eigen::MatrixXd AsBuilt::readback(const Motion& motor, const Conditions& /*conditions*/) const {
  check(motor, model_.joints());
  Motion reading = motor;
  for (const Effect& effect : effects_)
    if (effect.kind->readback) effect.kind->readback(effect, model_, reading);
  return reading.q;
}

Eigen::Matrix3Xd AsBuilt::ball_displacement(const Eigen::VectorXd& time, const Conditions& conditions) const {
  Eigen::Matrix3Xd moved = Eigen::Matrix3Xd::Zero(3, time.size());
  for (const Effect& effect : effects_)
    if (effect.kind->ball)
      for (Eigen::Index k = 0; k < time.size(); ++k)
        moved.col(k) += effect.kind->ball(effect, time(k), conditions);
  return moved;
}

Eigen::VectorXd AsBuilt::gauge_offset(const Eigen::VectorXd& time, const Conditions& conditions) const {
  Eigen::VectorXd offset = Eigen::VectorXd::Zero(time.size());
  for (const Effect& effect : effects_)
    if (effect.kind->gauge)
      for (Eigen::Index k = 0; k < time.size(); ++k)
        offset(k) += effect.kind->gauge(effect, time(k), static_cast<int>(k) + 1, conditions);
  return offset;
}

}  // namespace ballbar
