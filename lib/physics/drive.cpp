#include "physics/drive.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <functional>
#include <span>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kStride = 4;      // samples from one node to the next
constexpr double kSmooth = 1e-3;  // of a row's largest value: what twice the stride may miss
constexpr double kLeastScale =
    1e-2;  // of the largest of all rows: below it a row is small whatever its shape

std::span<const double> column(const MatrixXd& m, Index k) {
  return {m.col(k).data(), static_cast<std::size_t>(m.rows())};
}

/// Weights of four abscissae in the cubic at t (Lagrange).
std::array<double, 4> weights(const std::array<double, 4>& x, double t) {
  std::array<double, 4> weight{};
  for (std::size_t i = 0; i < 4; ++i) {
    weight[i] = 1.0;
    for (std::size_t j = 0; j < 4; ++j)
      if (j != i) weight[i] *= (t - x[j]) / (x[i] - x[j]);
  }
  return weight;
}

/// What `exact` gives at each sample (rows x n), worked out at every fourth one and in between where a cubic
/// through them would not do: where twice the stride misses a node by more than kSmooth. What the cubic gives
/// is then some 16 times as near.
MatrixXd along(const VectorXd& time, Index rows, const std::function<VectorXd(Index)>& exact) {
  const Index n = time.size();
  MatrixXd all(rows, n);
  if (n < 8 * kStride) {
    for (Index k = 0; k < n; ++k) all.col(k) = exact(k);
    return all;
  }
  std::vector<Index> node;
  for (Index k = 0; k < n - 1; k += kStride) node.push_back(k);
  node.push_back(n - 1);
  const auto nodes = static_cast<Index>(node.size());
  for (const Index k : node) all.col(k) = exact(k);
  VectorXd largest = VectorXd::Zero(rows);
  for (const Index k : node) largest = largest.cwiseMax(all.col(k).cwiseAbs());
  const VectorXd allowed = kSmooth * largest.cwiseMax(kLeastScale * largest.maxCoeff());
  const auto cubic = [&](Index first, Index step, Index k) -> VectorXd {
    std::array<double, 4> x{};
    for (std::size_t i = 0; i < 4; ++i)
      x[i] = time[node[static_cast<std::size_t>(first + static_cast<Index>(i) * step)]];
    const std::array<double, 4> weight = weights(x, time[k]);
    VectorXd sum = VectorXd::Zero(rows);
    for (std::size_t i = 0; i < 4; ++i)
      sum += weight[i] * all.col(node[static_cast<std::size_t>(first + static_cast<Index>(i) * step)]);
    return sum;
  };
  std::vector<bool> rough(node.size(), false);
  for (Index i = 1; i < nodes; i += 2) {
    const Index most = nodes - 7 - (nodes - 1) % 2;  // even, with three even nodes behind it
    const Index first = std::clamp<Index>(i - 3, 0, most);
    const Index k = node[static_cast<std::size_t>(i)];
    rough[static_cast<std::size_t>(i)] =
        ((cubic(first, 2, k) - all.col(k)).cwiseAbs().array() > allowed.array()).any();
  }
  for (Index i = 0; i + 1 < nodes; ++i) {
    const Index first = std::clamp<Index>(i - 1, 0, nodes - 4);
    const bool straight =
        std::none_of(rough.begin() + first, rough.begin() + first + 4, [](bool r) { return r; });
    for (Index k = node[static_cast<std::size_t>(i)] + 1; k < node[static_cast<std::size_t>(i + 1)]; ++k)
      all.col(k) = straight ? cubic(first, 1, k) : exact(k);
  }
  return all;
}

}  // namespace

const Derivatives& Loads::rates() {
  if (!rates_) rates_ = derivatives(motor_);
  return *rates_;
}

MatrixXd Loads::torque_of(const std::vector<Body>& bodies) {
  const Derivatives& rate = rates();
  return along(motor_.time, motor_.q.rows(), [&](Index k) -> VectorXd {
    return joint_torques(chain_, bodies, column(motor_.q, k), column(rate.speed, k),
                         column(rate.acceleration, k));
  });
}

const MatrixXd& Loads::torque() {
  if (!torque_) torque_ = torque_of(bodies_);
  return *torque_;
}

const MatrixXd& Loads::torque(int variant,
                              const std::function<std::vector<Body>(const std::vector<Body>&)>& change) {
  const auto known = variants_.find(variant);
  if (known != variants_.end()) return known->second;
  return variants_[variant] = torque_of(change(bodies_));
}

const VectorXd& Loads::inertia(int joint) {
  const auto known = inertia_.find(joint);
  if (known != inertia_.end()) return known->second;
  const VectorXd rest = VectorXd::Zero(motor_.q.rows());
  const VectorXd unit = VectorXd::Unit(motor_.q.rows(), joint - 1);
  return inertia_[joint] = along(motor_.time, 1, [&](Index k) -> VectorXd {
                             const auto q = column(motor_.q, k);
                             return VectorXd::Constant(1, joint_torques(chain_, bodies_, q, column(rest, 0),
                                                                        column(unit, 0))(joint - 1) -
                                                              gravity_torques(chain_, bodies_, q)(joint - 1));
                           }).transpose();
}

bool Loads::hold_for(const Motion& motor, const Chain& chain, const std::vector<Body>& bodies) const {
  constexpr double kNear = 3e-4;      // [rad] and [m]
  constexpr double kSameTime = 1e-6;  // [s]
  if (motor.q.rows() != motor_.q.rows() || motor.q.cols() != motor_.q.cols()) return false;
  if (motor.q.size() > 0) {
    const auto since_begin = [](const Motion& motion) -> VectorXd {
      return motion.time.array() - motion.time[0];
    };
    if (!((since_begin(motor) - since_begin(motor_)).cwiseAbs().maxCoeff() < kSameTime)) return false;
    if (!((motor.q - motor_.q).cwiseAbs().maxCoeff() < kNear)) return false;
  }
  const bool same_bodies = std::equal(
      bodies.begin(), bodies.end(), bodies_.begin(), bodies_.end(), [](const Body& a, const Body& b) {
        return a.joint == b.joint && a.mass == b.mass && a.com == b.com && a.inertia == b.inertia;
      });
  if (!same_bodies || chain.rows().size() != chain_.rows().size()) return false;
  for (std::size_t i = 0; i < chain.rows().size(); ++i) {
    const DhRow& a = chain.rows()[i];
    const DhRow& b = chain_.rows()[i];
    for (const double by : {a.theta - b.theta, a.alpha - b.alpha, a.beta - b.beta, a.a - b.a, a.d - b.d})
      if (!(std::abs(by) < kNear)) return false;
  }
  return true;
}

}  // namespace ballbar
