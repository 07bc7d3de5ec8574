#pragma once
/// What a motion asks of the joints, worked out once for all effects that need it.

#include <Eigen/Core>
#include <optional>
#include <utility>
#include <vector>

#include "kinematics/chain.hpp"
#include "kinematics/dynamics.hpp"
#include "physics/derivatives.hpp"
#include "physics/motion.hpp"

namespace ballbar {

/// Torques are those of links that move exactly as the motors do: what they bend by changes them by less than
/// 1 % of what an effect of them does.
class Drive {
 public:
  /// Refers to its arguments, which must outlive it.
  Drive(const Motion& motor, const Chain& chain, std::vector<Body> bodies)
      : motor_(motor), chain_(chain), bodies_(std::move(bodies)) {}

  const Motion& motor() const { return motor_; }
  const Eigen::MatrixXd& speed() { return rates().speed; }                ///< [rad/s] joints x n
  const Eigen::MatrixXd& acceleration() { return rates().acceleration; }  ///< [rad/s^2] joints x n
  const Eigen::MatrixXd& torque();  ///< [Nm] joints x n that the drives must give (joint_torques)

  /// [kg m^2] n values: what the links behind a joint have about it where all other joints stand.
  Eigen::VectorXd inertia(int joint);

 private:
  const Derivatives& rates();

  const Motion& motor_;
  const Chain& chain_;
  std::vector<Body> bodies_;
  std::optional<Derivatives> rates_;
  std::optional<Eigen::MatrixXd> torque_;
};

}  // namespace ballbar
