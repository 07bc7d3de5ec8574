#include "baseline.hpp"

#include <cmath>

namespace blind {
namespace {

constexpr double kTurnBy = 1e-6;  // [rad] for differences
constexpr int kOffsets = 4;  // of joints 2 to 5; joint 1 turns robot and ball alike, joint 6 the ball alone

/// Number of each test's set-up: tests with the same centre share it.
std::vector<int> setups(const Plan& plan) {
  std::vector<int> of;
  int next = 0;
  for (std::size_t i = 0; i < plan.tests.size(); ++i) {
    int found = -1;
    for (std::size_t k = 0; k < i; ++k)
      if (plan.tests[k].centre_mm == plan.tests[i].centre_mm) found = of[k];
    of.push_back(found < 0 ? next++ : found);
  }
  return of;
}

}  // namespace

std::vector<std::size_t> kept(const Test& test) {
  const Sampling s = sampling(test);
  const int stride = 4 * s.joints_per_turn / kPerTurn;
  std::vector<std::size_t> at;
  for (int i = s.before; i < s.before + s.arc; i += stride) at.push_back(static_cast<std::size_t>(i));
  return at;
}

Baseline::Baseline(const Plan& plan, const std::vector<const std::vector<Joints>*>& asked) : plan_(plan) {
  const std::vector<int> setup = setups(plan);
  Eigen::Index rows = 0;
  int last = 0;
  for (const Recording& r : plan.recordings)
    if (!r.held_out) {
      rows += static_cast<Eigen::Index>(kept(plan.tests[static_cast<std::size_t>(r.test)]).size());
      last = std::max(last, setup[static_cast<std::size_t>(r.test)]);
    }
  Eigen::MatrixXd columns = Eigen::MatrixXd::Zero(rows, kOffsets + 3 * (last + 1) + 1);
  const Deviations none;
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < plan.recordings.size(); ++i) {
    if (plan.recordings[i].held_out) continue;
    const auto which = static_cast<std::size_t>(plan.recordings[i].test);
    const Vector3d centre = 1e-3 * plan.tests[which].centre_mm;
    for (const std::size_t k : kept(plan.tests[which])) {
      Joints q = (*asked[i])[k];
      const Vector3d way = tool_point(q, none) - centre;
      for (int j = 0; j < kOffsets; ++j) {
        const auto joint = static_cast<std::size_t>(j + 1);
        q[joint] += kTurnBy;
        columns(row, j) = ((tool_point(q, none) - centre).norm() - way.norm()) / kTurnBy;
        q[joint] -= kTurnBy;
      }
      columns.block<1, 3>(row, kOffsets + 3 * setup[which]) = -way.normalized().transpose();
      columns(row, columns.cols() - 1) = 1.0;
      ++row;
    }
  }
  // Columns that the plan cannot tell apart (one flat circle: height of the ball) are few and weak: rank
  // revealing.
  columns.colwise().normalize();
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> qr(columns);
  span_ = qr.householderQ() * Eigen::MatrixXd::Identity(rows, qr.rank());
}

double Baseline::left_um(const std::vector<std::vector<double>>& with,
                         const std::vector<std::vector<double>>& without) const {
  Eigen::VectorXd change(span_.rows());
  Eigen::Index row = 0;
  for (std::size_t i = 0; i < plan_.recordings.size(); ++i)
    if (!plan_.recordings[i].held_out)
      for (const std::size_t k : kept(plan_.tests[static_cast<std::size_t>(plan_.recordings[i].test)]))
        change(row++) = with[i][k] - without[i][k];
  change -= span_ * (span_.transpose() * change);
  return 1e6 * change.norm() / std::sqrt(static_cast<double>(change.size()));
}

}  // namespace blind
