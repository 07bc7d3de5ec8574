#pragma once
/// The robot as built: its nominal model and the effects that are known of it.

#include <Eigen/Core>
#include <memory>
#include <vector>

#include "core/spec.hpp"
#include "kinematics/robot_model.hpp"
#include "physics/motion.hpp"

namespace ballbar {

class Effect;

/// Immutable; any number of users at once. The way of a motion:
/// command --follow()--> motor side --tool_points()--> where the tool point truly goes.
class AsBuilt {
 public:
  /// @param spec  gear ratios, payload's centre of mass, effects
  /// @throws Error(kInput) for an effect, joint, parameter or word that the catalogue does not hold, naming
  /// it
  AsBuilt(RobotModel model, const RobotSpec& spec);

  const RobotModel& model() const { return model_; }

  /// No effect is known: tool_points() is nominal forward kinematics.
  bool nominal() const { return effects_.empty(); }

  /// The motors' motion where the controller commands `command`: servo_lag, path_smoothing.
  Motion follow(const Motion& command, const Conditions& conditions) const;

  /// Tool points in the base frame [m], 3 x n, where the motors move so: everything behind the motors'
  /// encoders, with what happened earlier in the same motion (lost motion has a state).
  Eigen::Matrix3Xd tool_points(const Motion& motor, const Conditions& conditions) const;

 private:
  RobotModel model_;
  std::vector<std::shared_ptr<const Effect>> effects_;
};

}  // namespace ballbar
