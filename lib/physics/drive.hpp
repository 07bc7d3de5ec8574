#pragma once
/// Inside physics/ only: what a motion asks of the joints, worked out once for all effects that need it.

#include <Eigen/Core>
#include <optional>
#include <span>
#include <vector>

#include "kinematics/chain.hpp"
#include "kinematics/dynamics.hpp"
#include "physics/motion.hpp"

namespace ballbar {

class Drive {
 public:
  /// Refers to its arguments, which must outlive it.
  Drive(const Motion& motor, const Chain& chain, std::vector<Body> bodies)
      : motor_(motor), chain_(chain), bodies_(std::move(bodies)) {}

  const Motion& motor() const { return motor_; }

 private:
  const Motion& motor_;
  const Chain& chain_;
  std::vector<Body> bodies_;
};

}  // namespace ballbar
