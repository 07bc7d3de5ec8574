#pragma once
/// The modified DH table of any chain of rotating joints, from where its axes lie at zero.

#include <Eigen/Core>
#include <Eigen/Geometry>
#include <vector>

#include "kinematics/chain.hpp"

namespace ballbar {

/// The choices that the axes leave open are made so that maker's tables come out where makers give any:
/// - Axes within 5 deg of each other count as parallel: the way to the next one starts where the former
/// arrived (so d is 0), at
///   right angles to the former axis, and what is left of the angle goes to alpha and beta (Hayati).
/// - z of parallel neighbours points the same way: so that the first d of them which is not 0 is positive (a
/// length of a link),
///   else so that its largest component is positive in the base frame. The base counts as an axis along its
///   z.
/// - Where two axes meet, x is the one of both normals that is nearer to the former x.
/// - The last frame has its origin where the URDF has the last joint's, and theta 0.
/// For the LR Mate 200iC: alpha (0, -90, 0, -90, 90, -90) deg, a (0, 75, 300, 75, 0, 0) mm, d (0, 0, 0, 320,
/// 0, 80) mm.
/// @param axes  of the joints at zero in the base frame, 1..kMaxChainJoints; origins as in the URDF
/// @param tip   pose of the tip at zero in the base frame
Chain chain_from_axes(const std::vector<JointAxis>& axes, const Eigen::Isometry3d& tip);

}  // namespace ballbar
