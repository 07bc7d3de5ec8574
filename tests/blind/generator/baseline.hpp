#pragma once
/// How much of a change of the recordings is left when zero offsets, ball centres and the bar's length have
/// absorbed what they can.

#include <Eigen/Dense>

#include "truth.hpp"

namespace blind {

constexpr int kPerTurn = 400;

/// Indices of the measured arc, 400 a turn, in a recording of `test`.
std::vector<std::size_t> kept(const Test& test);

/// One row per kept sample of every fitted recording, in their order.
class Baseline {
 public:
  /// `asked`: commanded joints of each recording of the plan.
  Baseline(const Plan& plan, const std::vector<const std::vector<Joints>*>& asked);

  /// `with`, `without`: bar of each recording of the plan [m]. RMS [um] of their difference beside the
  /// baseline.
  double left_um(const std::vector<std::vector<double>>& with,
                 const std::vector<std::vector<double>>& without) const;

 private:
  const Plan& plan_;
  Eigen::MatrixXd span_;  // orthonormal
};

}  // namespace blind
