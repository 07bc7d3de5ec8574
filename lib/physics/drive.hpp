#pragma once
/// What a motion asks of the joints, worked out once for all effects that need it.

#include <Eigen/Core>
#include <functional>
#include <map>
#include <memory>
#include <optional>
#include <vector>

#include "kinematics/chain.hpp"
#include "kinematics/dynamics.hpp"
#include "physics/derivatives.hpp"
#include "physics/motion.hpp"

namespace ballbar {

/// Speeds, torques and inertias along a motion, each worked out when it is first asked for. Torques are those
/// of links that move exactly as the motors do: what they bend by changes them by less than 1 % of what an
/// effect of them does.
class Loads {
 public:
  Loads(Motion motor, Chain chain, std::vector<Body> bodies)
      : motor_(std::move(motor)), chain_(std::move(chain)), bodies_(std::move(bodies)) {}

  const Eigen::MatrixXd& speed() { return rates().speed; }                ///< [rad/s] joints x n
  const Eigen::MatrixXd& acceleration() { return rates().acceleration; }  ///< [rad/s^2] joints x n
  const Eigen::MatrixXd& torque();  ///< [Nm] joints x n that the drives must give (joint_torques)

  /// The same with other bodies, kept under a number that says which.
  const Eigen::MatrixXd& torque(int variant,
                                const std::function<std::vector<Body>(const std::vector<Body>&)>& change);

  /// [kg m^2] n values: what the links behind a joint have about it where all other joints stand.
  const Eigen::VectorXd& inertia(int joint);

  /// Those of this motion, chain and bodies are the same to a part in a thousand of what torques depend on. A
  /// clock that is off by a constant changes nothing; another speed or payload on the same path does.
  bool hold_for(const Motion& motor, const Chain& chain, const std::vector<Body>& bodies) const;

 private:
  const Derivatives& rates();
  Eigen::MatrixXd torque_of(const std::vector<Body>& bodies);

  Motion motor_;
  Chain chain_;
  std::vector<Body> bodies_;
  std::optional<Derivatives> rates_;
  std::optional<Eigen::MatrixXd> torque_;
  std::map<int, Eigen::MatrixXd> variants_;
  std::map<int, Eigen::VectorXd> inertia_;
};

/// A motion and what it asks of the joints. Refers to its arguments, which must outlive it.
class Drive {
 public:
  Drive(const Motion& motor, Loads& loads) : motor_(motor), loads_(loads) {}

  const Motion& motor() const { return motor_; }
  const Eigen::MatrixXd& speed() { return loads_.speed(); }
  const Eigen::MatrixXd& acceleration() { return loads_.acceleration(); }
  const Eigen::MatrixXd& torque() { return loads_.torque(); }
  const Eigen::VectorXd& inertia(int joint) { return loads_.inertia(joint); }

 private:
  const Motion& motor_;
  Loads& loads_;
};

}  // namespace ballbar
