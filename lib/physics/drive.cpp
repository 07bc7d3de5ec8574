#include "physics/drive.hpp"

#include <span>

namespace ballbar {
namespace {

constexpr double kInertiaStep =
    0.02;  // [s] between poses at which an inertia is worked out; links move little in it

std::span<const double> column(const Eigen::MatrixXd& m, Eigen::Index k) {
  return {m.col(k).data(), static_cast<std::size_t>(m.rows())};
}

}  // namespace

const Derivatives& Drive::rates() {
  if (!rates_) rates_ = derivatives(motor_);
  return *rates_;
}

const Eigen::MatrixXd& Drive::torque() {
  if (torque_) return *torque_;
  const Derivatives& rate = rates();
  Eigen::MatrixXd torque(motor_.q.rows(), motor_.q.cols());
  for (Eigen::Index k = 0; k < torque.cols(); ++k)
    torque.col(k) = joint_torques(chain_, bodies_, column(motor_.q, k), column(rate.speed, k),
                                  column(rate.acceleration, k));
  torque_ = std::move(torque);
  return *torque_;
}

Eigen::VectorXd Drive::inertia(int joint) {
  const Eigen::Index n = motor_.q.cols();
  const Eigen::VectorXd rest = Eigen::VectorXd::Zero(motor_.q.rows());
  const Eigen::VectorXd unit = Eigen::VectorXd::Unit(motor_.q.rows(), joint - 1);
  const auto at = [&](Eigen::Index k) {
    const auto q = column(motor_.q, k);
    return joint_torques(chain_, bodies_, q, column(rest, 0), column(unit, 0))(joint - 1) -
           gravity_torques(chain_, bodies_, q)(joint - 1);
  };
  Eigen::VectorXd inertia(n);
  if (n == 0) return inertia;
  inertia(0) = at(0);
  for (Eigen::Index from = 0; from < n - 1;) {
    Eigen::Index to = from + 1;
    while (to < n - 1 && motor_.time(to) - motor_.time(from) < kInertiaStep) ++to;
    inertia(to) = at(to);
    const double span = motor_.time(to) - motor_.time(from);
    for (Eigen::Index k = from + 1; k < to; ++k)
      inertia(k) =
          inertia(from) + (inertia(to) - inertia(from)) * (motor_.time(k) - motor_.time(from)) / span;
    from = to;
  }
  return inertia;
}

}  // namespace ballbar
