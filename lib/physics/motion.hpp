#pragma once
/// What one run asks of a robot, and under which conditions.

#include <Eigen/Core>
#include <cstdint>
#include <optional>

namespace ballbar {

/// Joint angles over time: as commanded, or as the motors' encoders read them.
struct Motion {
  Eigen::VectorXd time;  ///< [s] n values, rising
  Eigen::MatrixXd q;     ///< [rad] joints x n angles of the URDF chain, without jumps
};

struct Conditions {
  double payload = 0.0;       ///< [kg] on the flange
  double series_time = 0.0;   ///< [s] at Motion::time = 0, since the series began; 0 where not known
  std::int64_t start_us = 0;  ///< producer's clock at Motion::time = 0; 0 where not known
  bool series_known = true;   ///< series_time is exact: what oscillates in time has a known phase
  std::optional<Eigen::Vector3d> ball{};  ///< [m] programmed place of the set-up's ball in the base frame
};

}  // namespace ballbar
