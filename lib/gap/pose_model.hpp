#pragma once
/// What a measured pose should read, and what each parameter does to that reading.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "gap/poses.hpp"
#include "kinematics/chain.hpp"

namespace ballbar {

enum class PoseEffect {
  kZeroOffset,
  kLinkA,
  kLinkD,
  kLinkAlpha,
  kLinkBeta,
  kCompliance,
  kEccentricity,
  kRipple,           ///< setting: cycles per turn, setting2: stroke of the joint in the fitted rows [rad]
  kRippleRate,       ///< how far a ripple's rate is off; setting: its cycles per turn, setting2: its phase
  kLostMotion,       ///< by the column direction
  kLostMotionMove,   ///< by the side from which the joint came, from the sequence of the rows
  kReadbackMove,     ///< the reading lacks a part of the way from the pose before
  kReadbackCommand,  ///< the truth lies between the reading and the command
  kReadbackTime,     ///< the reading of a joint in motion is old
  kJump,             ///< setting: row from which on
  kDrift,
  kGrowth,      ///< setting: time constant [s]
  kAngleCurve,  ///< setting, setting2: range [rad]
  kTimeCurve,   ///< over the place in the file
};

/// One effect as columns. Values are linear in it: SI, lines and eccentricities as sine and cosine.
struct PoseTerm {
  PoseEffect effect = PoseEffect::kZeroOffset;
  int joint = 0;  ///< from 1; 0 = all, or none
  double setting = 0.0;
  double setting2 = 0.0;
  double typical = 1.0;  ///< size of each value on a sound robot [SI]
  int width = 1;         ///< values

  bool same_as(const PoseTerm& other) const {
    return effect == other.effect && joint == other.joint && setting == other.setting;
  }
};

struct PoseState {
  std::vector<Eigen::Isometry3d> frames;  ///< base of the robot in the instrument's frame, one per series
  std::vector<Eigen::Vector3d> fixed;     ///< lengths: the fixed point in the base frame [m], one per series
  std::vector<Eigen::Vector3d> tools;     ///< [m] tool points in the tip frame
  std::vector<PoseTerm> terms;
  std::vector<double> values;  ///< of all terms, one after the other

  int nuisance(bool lengths) const;  ///< parameters of set-ups: they stand before the terms
};

/// At one row and one state: the reading, and where everything that moves the tool point moves it.
struct PoseGeometry {
  PositionColumns columns;  ///< in the instrument's frame; along the length: row 0 only
  Eigen::Vector3d tip;      ///< [m] predicted point; or (length, 0, 0)
  Eigen::Vector3d arm;      ///< [m] predicted point minus the frame's origin
  Eigen::Matrix3d axes;     ///< of the base frame, as columns
};

class PoseModel {
 public:
  /// Refers to its arguments, which must outlive it.
  PoseModel(const Chain& chain, bool lengths) : chain_(chain), lengths_(lengths) {}

  bool lengths() const { return lengths_; }
  int per_row() const { return lengths_ ? 1 : 3; }
  const Chain& chain() const { return chain_; }

  /// [m] measured minus predicted, per_row() values a row.
  Eigen::VectorXd residual(const std::vector<PoseRow>& rows, const PoseState& state) const;

  /// @param geometry  if not null: as many as rows
  Eigen::VectorXd residual(const std::vector<PoseRow>& rows, const PoseState& state,
                           std::vector<PoseGeometry>* geometry) const;

  /// d reading / d parameter: readings x nuisance.
  Eigen::MatrixXd nuisance_columns(const std::vector<PoseRow>& rows, const PoseState& state,
                                   const std::vector<PoseGeometry>& geometry) const;

  /// Readings x term.width.
  Eigen::MatrixXd term_columns(const std::vector<PoseRow>& rows, const PoseTerm& term,
                               const std::vector<PoseGeometry>& geometry) const;

  /// The state with nuisance and values moved by a step, in the order of the columns.
  PoseState moved(const PoseState& state, const Eigen::VectorXd& step) const;

 private:
  const Chain& chain_;
  bool lengths_;
};

/// What the terms add to a joint's angle: `term.width` numbers for one joint (from 0); false: not an angle.
bool angle_pattern(const PoseTerm& term, const PoseRow& row, Eigen::Index joint, double* pattern);

inline constexpr int kAngleKnots = 24;
inline constexpr int kTimeKnots = 12;

}  // namespace ballbar
