#include "kinematics/robot_model.hpp"

#include <stdexcept>
#include <utility>

#include "core/error.hpp"
#include "kinematics/dh_table.hpp"
#include "kinematics/urdf_reader.hpp"

namespace ballbar {
namespace {

constexpr double kSamePose = 1e-9;  // [m], [rad]: far above rounding, far below any drawing

/// The table is our own derivation; KDL knows nothing of it. A difference would be a bug, and everything
/// after it wrong.
void check_against_kdl(const Chain& chain, const std::vector<Checkpoint>& checkpoints) {
  for (const Checkpoint& checkpoint : checkpoints) {
    const Eigen::Isometry3d tip = chain.forward(checkpoint.q);
    if (!((tip.matrix() - checkpoint.tip.matrix()).cwiseAbs().maxCoeff() < kSamePose))
      throw std::logic_error("the DH table of this URDF does not agree with KDL");
  }
}

/// J3 + J2 is an angle against the horizontal only where both turn about one direction, in opposite senses.
void check_fanuc(const std::vector<JointAxis>& axes, const std::vector<JointLimit>& limits) {
  if (axes.size() < 3)
    throw Error(Cause::kInput, "URDF: joint_convention \"fanuc\" needs at least 3 joints; set \"serial\"");
  if (axes[1].direction.dot(axes[2].direction) > -0.99)
    throw Error(Cause::kInput, "URDF: joint_convention \"fanuc\" needs '" + limits[1].name + "' and '" +
                                   limits[2].name +
                                   "' to turn in opposite senses, as FANUC's do; set \"serial\"");
}

}  // namespace

RobotModel::RobotModel(const std::string& urdf_text, const std::string& base, const std::string& tip,
                       JointConvention convention)
    : RobotModel(read_urdf(urdf_text, base, tip), convention) {}

RobotModel::RobotModel(UrdfChain urdf, JointConvention convention)
    : convention_(convention),
      chain_(chain_from_axes(urdf.axes, urdf.tip)),
      limits_(std::move(urdf.limits)),
      bodies_(std::move(urdf.bodies)),
      hand_(std::move(urdf.hand)) {
  if (convention == JointConvention::kFanuc) check_fanuc(urdf.axes, limits_);
  check_against_kdl(chain_, urdf.checkpoints);
  // From the base frame at zero into the frame of the joint that carries them.
  const std::vector<double> zero(limits_.size(), 0.0);
  const ChainFrames at = chain_.frames(zero);
  for (Body& body : bodies_) {
    const auto i = static_cast<std::size_t>(body.joint - 1);
    body.com = (at.rotation[i].transpose() * (body.com - at.origin[i])).eval();
    body.inertia = (at.rotation[i].transpose() * body.inertia * at.rotation[i]).eval();
  }
  Eigen::Isometry3d last = Eigen::Isometry3d::Identity();
  last.linear() = at.rotation[limits_.size() - 1];
  last.translation() = at.origin[limits_.size() - 1];
  for (auto& [name, pose] : hand_) pose = last.inverse() * pose;
}

void RobotModel::to_chain(std::span<double> q) const {
  if (convention_ == JointConvention::kFanuc) q[2] += q[1];
}

void RobotModel::from_chain(std::span<double> q) const {
  if (convention_ == JointConvention::kFanuc) q[2] -= q[1];
}

JointVector RobotModel::chain_angles(std::span<const double> q) const {
  if (q.size() != limits_.size())
    throw std::invalid_argument(std::to_string(q.size()) + " joint angles for a chain of " +
                                std::to_string(limits_.size()));
  JointVector angles = Eigen::Map<const Eigen::VectorXd>(q.data(), joints());
  to_chain({angles.data(), q.size()});
  return angles;
}

Eigen::Isometry3d RobotModel::forward(std::span<const double> q) const {
  const JointVector angles = chain_angles(q);
  return chain_.forward({angles.data(), q.size()});
}

Eigen::Isometry3d RobotModel::forward(std::span<const double> q, const ChainDeviation& deviation) const {
  const JointVector angles = chain_angles(q);
  return chain_.with(deviation).forward({angles.data(), q.size()});
}

Jacobian RobotModel::jacobian(std::span<const double> q) const {
  const JointVector angles = chain_angles(q);
  Jacobian jacobian = chain_.jacobian({angles.data(), q.size()});
  if (convention_ == JointConvention::kFanuc)
    jacobian.col(1) += jacobian.col(2);  // J2 turns J3 of the chain as well
  return jacobian;
}

Body RobotModel::payload(double mass, const Eigen::Vector3d& com, const std::string& link) const {
  const auto found = hand_.find(link);
  if (found == hand_.end())
    throw Error(Cause::kInput,
                "URDF: no link '" + link + "' that moves with the tool point; the payload hangs there");
  return {"payload", joints(), mass, found->second * com, Eigen::Matrix3d::Zero()};
}

}  // namespace ballbar
