#include "kinematics/chain.hpp"

#include <cmath>
#include <stdexcept>
#include <string>
#include <utility>

namespace ballbar {

using Eigen::AngleAxisd;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;

Chain::Chain(const Isometry3d& base, std::vector<DhRow> rows, const Isometry3d& tool)
    : base_(base), rows_(std::move(rows)), tool_(tool) {
  if (rows_.empty() || rows_.size() > kMaxChainJoints)
    throw std::invalid_argument("chain: " + std::to_string(rows_.size()) + " joints; 1 to " +
                                std::to_string(kMaxChainJoints) + " are possible");
  for (const DhRow& row : rows_) {
    Link link;
    link.rotation = (AngleAxisd(row.alpha, Vector3d::UnitX()) * AngleAxisd(row.beta, Vector3d::UnitY()) *
                     AngleAxisd(row.theta, Vector3d::UnitZ()))
                        .toRotationMatrix();
    link.translation = row.a * Vector3d::UnitX() + row.d * link.rotation.col(2);
    link.tilt_axis = {0.0, std::cos(row.alpha), std::sin(row.alpha)};
    links_.push_back(link);
  }
}

void Chain::check(std::span<const double> q) const {
  if (q.size() != rows_.size())
    throw std::invalid_argument(std::to_string(q.size()) + " joint angles for a chain of " +
                                std::to_string(rows_.size()));
  for (const double angle : q)
    if (!std::isfinite(angle)) throw std::invalid_argument("a joint angle is not finite");
}

Chain Chain::with(const ChainDeviation& deviation) const {
  if (!deviation.links.empty() && deviation.links.size() != rows_.size())
    throw std::invalid_argument("chain: deviations of " + std::to_string(deviation.links.size()) +
                                " links for a chain of " + std::to_string(rows_.size()));
  std::vector<DhRow> rows = rows_;
  for (std::size_t i = 0; i < deviation.links.size(); ++i) {
    const LinkDeviation& link = deviation.links[i];
    rows[i].a += link.a;
    rows[i].alpha += link.alpha;
    rows[i].beta += link.beta;
    rows[i].theta += rows[i].sign * link.zero_offset;
    rows[i].d += link.d;
  }
  return {base_, std::move(rows), tool_ * Eigen::Translation3d(deviation.tool)};
}

void Chain::step(std::size_t joint, double angle, Matrix3d& rotation, Vector3d& origin) const {
  const Link& link = links_[joint];
  const double c = std::cos(angle);
  const double s = rows_[joint].sign * std::sin(angle);
  Matrix3d turned;
  turned.col(0) = c * link.rotation.col(0) + s * link.rotation.col(1);
  turned.col(1) = c * link.rotation.col(1) - s * link.rotation.col(0);
  turned.col(2) = link.rotation.col(2);
  origin += rotation * link.translation;
  rotation = (rotation * turned).eval();
}

Isometry3d Chain::forward(std::span<const double> q) const {
  check(q);
  Matrix3d rotation = base_.linear();
  Vector3d origin = base_.translation();
  for (std::size_t i = 0; i < rows_.size(); ++i) step(i, q[i], rotation, origin);
  Isometry3d tip = Isometry3d::Identity();
  tip.linear() = rotation * tool_.linear();
  tip.translation() = origin + rotation * tool_.translation();
  return tip;
}

Vector3d Chain::tip(std::span<const double> q) const {
  check(q);
  Vector3d point = tool_.translation();
  for (std::size_t i = rows_.size(); i-- > 0;) {
    const double c = std::cos(q[i]);
    const double s = rows_[i].sign * std::sin(q[i]);
    const Vector3d turned(c * point.x() - s * point.y(), s * point.x() + c * point.y(), point.z());
    point = links_[i].translation + links_[i].rotation * turned;
  }
  return base_.translation() + base_.linear() * point;
}

ChainFrames Chain::frames(std::span<const double> q) const {
  check(q);
  ChainFrames frames;
  Matrix3d rotation = base_.linear();
  Vector3d origin = base_.translation();
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    step(i, q[i], rotation, origin);
    frames.rotation[i] = rotation;
    frames.origin[i] = origin;
  }
  frames.tip = Isometry3d::Identity();
  frames.tip.linear() = rotation * tool_.linear();
  frames.tip.translation() = origin + rotation * tool_.translation();
  return frames;
}

std::vector<JointAxis> Chain::joint_axes(std::span<const double> q) const {
  const ChainFrames at = frames(q);
  std::vector<JointAxis> axes;
  for (std::size_t i = 0; i < rows_.size(); ++i)
    axes.push_back({at.origin[i], rows_[i].sign * at.rotation[i].col(2)});
  return axes;
}

Jacobian Chain::jacobian(std::span<const double> q) const {
  const ChainFrames at = frames(q);
  Jacobian jacobian(6, joints());
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const Vector3d axis = rows_[i].sign * at.rotation[i].col(2);
    const auto column = static_cast<Eigen::Index>(i);
    jacobian.col(column).head<3>() = axis.cross(at.tip.translation() - at.origin[i]);
    jacobian.col(column).tail<3>() = axis;
  }
  return jacobian;
}

PositionColumns Chain::position_columns(std::span<const double> q) const {
  const ChainFrames at = frames(q);
  const Vector3d p = at.tip.translation();
  PositionColumns columns;
  for (JointColumns* each : {&columns.joint, &columns.a, &columns.d, &columns.alpha, &columns.beta})
    each->resize(3, joints());
  Matrix3d before = base_.linear();  // frame i-1
  Vector3d foot = base_.translation();
  for (std::size_t i = 0; i < rows_.size(); ++i) {
    const auto column = static_cast<Eigen::Index>(i);
    const Vector3d x = before.col(0);
    const Vector3d y = before * links_[i].tilt_axis;
    const Vector3d z = at.rotation[i].col(2);
    columns.a.col(column) = x;
    columns.alpha.col(column) = x.cross(p - foot);
    columns.beta.col(column) = y.cross(p - (foot + rows_[i].a * x));
    columns.d.col(column) = z;
    columns.joint.col(column) = rows_[i].sign * z.cross(p - at.origin[i]);
    before = at.rotation[i];
    foot = at.origin[i];
  }
  columns.tool = at.tip.linear();
  return columns;
}

}  // namespace ballbar
