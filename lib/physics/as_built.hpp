#pragma once
/// The robot as built: its nominal model and the effects that are known of it.

#include <Eigen/Core>
#include <optional>
#include <vector>

#include "core/spec.hpp"
#include "kinematics/robot_model.hpp"
#include "physics/effect.hpp"
#include "physics/motion.hpp"

namespace ballbar {

/// Immutable value; any number of users at once. The way of a motion:
/// command --follow()--> motors' encoders --link_angles()--> links --tool_points()--> tool point.
/// Effects come in the catalogue's order, whatever their order in the file: same effects, same bits.
/// Every function takes motions of model().joints() rows and as many columns as times, and throws
/// std::invalid_argument for anything else.
class AsBuilt {
 public:
  /// @param spec  gear ratios, payload's centre of mass, effects
  /// @throws Error(kInput) for an effect, joint, parameter or word that the catalogue does not hold, naming
  /// it; or where an effect needs the payload and the URDF has no `tool0`
  AsBuilt(const RobotModel& model, const RobotSpec& spec);

  /// The same with these effects instead of the specification's.
  AsBuilt(RobotModel model, const RobotSpec& spec, std::vector<Effect> effects);

  const RobotModel& model() const { return model_; }

  /// The chain with all effects of geometry that were there from the begin of the series.
  const Chain& chain() const { return chain_; }

  /// In the catalogue's order.
  const std::vector<Effect>& effects() const { return effects_; }

  /// JOINTS are what the controller commands: the motors follow() them.
  bool joints_are_commanded() const { return joints_commanded_; }

  /// No effect is known: tool_points() is nominal forward kinematics.
  bool nominal() const { return effects_.empty(); }

  /// The motors' motion where the controller commands `command`: servo_lag, path_smoothing.
  Motion follow(const Motion& command, const Conditions& conditions) const;

  /// The links' angles [rad], joints x n, where the motors move so; joint_zero_offset is geometry, so not in
  /// them. What has a history (lost motion) begins with the motion, see joint_lost_motion.cpp.
  Eigen::MatrixXd link_angles(const Motion& motor, const Conditions& conditions) const;

  /// The same where what the motion asks of the joints is known.
  Eigen::MatrixXd link_angles(Drive& drive) const;

  /// Tool points [m], 3 x n, in the base frame as it stood when the series began: everything behind the
  /// motors' encoders. NaN where an effect leaves no finite angle.
  Eigen::Matrix3Xd tool_points(const Motion& motor, const Conditions& conditions) const;

  /// The same of link_angles(), or of some of its columns, at their times.
  Eigen::Matrix3Xd tool_points(const Eigen::MatrixXd& link_angles, const Eigen::VectorXd& time,
                               const Conditions& conditions) const;

  /// The chain's angles [rad], joints x n, that the controller reports where the motors move so:
  /// joint_readback_lag, joint_readback_rounding.
  Eigen::MatrixXd readback(const Motion& motor, const Conditions& conditions) const;

  /// Movement of the set-up's ball [m], 3 x n, at times of the run: ball_slip.
  Eigen::Matrix3Xd ball_displacement(const Eigen::VectorXd& time, const Conditions& conditions) const;

  /// What a bar reads too long [m], n values, one per time of the run: gauge_jump, structural_vibration.
  Eigen::VectorXd gauge_offset(const Eigen::VectorXd& time, const Conditions& conditions) const;

 private:
  RobotModel model_;
  bool joints_commanded_;
  Chain chain_;
  std::vector<Effect> effects_;
  std::optional<Body> payload_;  ///< of 1 kg; where an effect needs it
};

}  // namespace ballbar
