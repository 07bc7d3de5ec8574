#pragma once
/// One effect: a way in which a real robot, its instrument or its set-up differs from the nominal model. The
/// kind says what it is called, which parameters it has and what it does; the effect holds the figures.

#include <Eigen/Core>
#include <limits>
#include <string_view>
#include <vector>

#include "kinematics/chain.hpp"
#include "kinematics/robot_model.hpp"
#include "physics/motion.hpp"

namespace ballbar {

class Drive;

enum class Need {
  kRequired,
  kOptional,
  kSomeOf,  ///< at least one of those of this kind that are marked so
  kOneOf,   ///< exactly one of them
};

struct ParameterKind {
  std::string_view name{};  ///< with its unit
  double si = 1.0;          ///< from that unit to SI
  double typical = 0.0;     ///< size on a sound robot, in the unit of the name
  Need need = Need::kRequired;
  double least = -std::numeric_limits<double>::infinity();  ///< in the unit of the name
  double most = std::numeric_limits<double>::infinity();    ///< in the unit of the name
  double absent = 0.0;                                      ///< SI value where it is not given
  std::string_view meaning{};                               ///< a few words
};

enum class JointUse {
  kNone,       ///< joint 0 or left out
  kOne,        ///< a joint from 1
  kOneOrAll,   ///< a joint from 1, or 0 = all
  kLinkOrAll,  ///< the link between a joint and the next one, or 0 = all
};

struct WordKind {
  std::string_view name{};  ///< empty = the effect has no such word
  std::vector<std::string_view> allowed{};
  bool required = false;
};

struct Effect;

/// The functions are the stages of a motion's way through the robot, in this order; null where the effect has
/// no part. They are pure, and what one of them adds does not depend on the other effects of its stage, but
/// for the two filters `command` and `readback`, which are applied in the catalogue's order. Whatever more an
/// effect can do, such as derivatives by its parameters, becomes one more function here.
struct EffectKind {
  std::string_view name{};
  JointUse joint = JointUse::kNone;
  std::vector<ParameterKind> parameters{};
  WordKind word{};
  std::string_view meaning{};  ///< one line for people
  std::string_view source{};
  bool loaded = false;  ///< depends on masses and payload
  bool forward = true;  ///< false: a name that a diagnosis gives, without a model behind it

  /// What the motors do of what is commanded.
  void (*command)(const Effect&, Motion&) = nullptr;

  /// Link's angle minus motor's [rad] of the effect's joint, n values.
  Eigen::VectorXd (*deflection)(const Effect&, Drive&) = nullptr;

  /// Adds to the chain's geometry, where growth() has reached 1. Lengths only where there is a growth().
  void (*geometry)(const Effect&, const Chain& nominal, ChainDeviation&) = nullptr;

  /// How much of geometry() is there, by time since the series began [s]; null = all of it, always.
  double (*growth)(const Effect&, double series_time) = nullptr;

  /// [m] movement of the robot's base, by time since the series began [s].
  Eigen::Vector3d (*base)(const Effect&, double series_time) = nullptr;

  /// What the controller says of the motors' motion.
  void (*readback)(const Effect&, const RobotModel&, Motion&) = nullptr;

  /// [m] movement of the set-up's ball at a time of the run [s].
  Eigen::Vector3d (*ball)(const Effect&, double time, const Conditions&) = nullptr;

  /// [m] what the instrument reads too long; `row` counts the readings from 1.
  double (*gauge)(const Effect&, double time, int row, const Conditions&) = nullptr;
};

/// An effect that is known, checked against its kind.
struct Effect {
  const EffectKind* kind = nullptr;  ///< never null; of catalogue()
  int joint = 0;                     ///< from 1; 0 = none, or all
  std::vector<double> values{};      ///< SI, in the order of kind->parameters
  int word = -1;                     ///< of kind->word.allowed; -1 = not given
};

}  // namespace ballbar
