#include "kinematics/inverse.hpp"

#include <Eigen/Eigenvalues>
#include <Eigen/LU>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/units.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::Isometry3d;
using Eigen::Matrix3d;
using Eigen::Vector3d;
using Vector6d = Eigen::Matrix<double, 6, 1>;
using Matrix6d = Eigen::Matrix<double, 6, 6>;

constexpr int kMaxIterations = 80;
constexpr double kMaxTurn = 0.6;      // [rad] of a joint in one step: Newton's method is blind further away
constexpr double kMinDamping = 1e-6;  // keeps the equations solvable at singularities
constexpr double kMaxDamping = 1e3;   // smaller steps than that lead nowhere

/// Inside this file all angles are chain angles.
struct Attempt {
  JointVector q;
  Vector6d error;  ///< [m], [rad] what is left to the pose
  bool there = false;
};

std::span<const double> view(const JointVector& q) { return {q.data(), static_cast<std::size_t>(q.size())}; }

Vector6d error_at(const Chain& chain, const Isometry3d& pose, const JointVector& q) {
  const Isometry3d tip = chain.forward(view(q));
  Vector6d error;
  error << pose.translation() - tip.translation(), rotation_between(tip.linear(), pose.linear());
  return error;
}

bool is_there(const Vector6d& error, const IkOptions& options) {
  return error.head<3>().norm() <= options.position && error.tail<3>().norm() <= options.rotation;
}

JointVector damped_step(const Jacobian& jacobian, const Vector6d& error, double damping) {
  Matrix6d normal = jacobian * jacobian.transpose();
  normal.diagonal().array() += damping * damping;
  JointVector step = jacobian.transpose() * normal.ldlt().solve(error);
  const double largest = step.cwiseAbs().maxCoeff();
  if (largest > kMaxTurn) step *= kMaxTurn / largest;
  return step;
}

/// Undamped steps, while they help: down to rounding.
void polish(const Chain& chain, const Isometry3d& pose, Attempt& attempt) {
  for (int k = 0; k < 3; ++k) {
    const Jacobian jacobian = chain.jacobian(view(attempt.q));
    JointVector q = attempt.q;
    if (chain.joints() == 6)
      q += Matrix6d(jacobian).partialPivLu().solve(attempt.error);
    else
      q += jacobian.completeOrthogonalDecomposition().solve(attempt.error);
    if (!q.allFinite() || (q - attempt.q).cwiseAbs().maxCoeff() > 1e-3) return;
    const Vector6d error = error_at(chain, pose, q);
    if (!(error.norm() < attempt.error.norm())) return;
    attempt.q = q;
    attempt.error = error;
  }
}

Attempt solve_from(const Chain& chain, const Isometry3d& pose, const JointVector& seed,
                   const IkOptions& options) {
  if (!pose.matrix().allFinite()) throw std::invalid_argument("inverse: the pose is not finite");
  Attempt attempt{seed, error_at(chain, pose, seed), false};
  double damping = 0.03;
  Jacobian jacobian = chain.jacobian(view(seed));
  for (int k = 0; k < kMaxIterations && damping < kMaxDamping && !is_there(attempt.error, options); ++k) {
    const JointVector q = attempt.q + damped_step(jacobian, attempt.error, damping);
    const Vector6d error = error_at(chain, pose, q);
    if (error.norm() < attempt.error.norm()) {
      // Damping in step with what is left keeps the last steps quadratic.
      damping = std::max(kMinDamping, std::min(0.2 * damping, 0.1 * error.norm()));
      attempt.q = q;
      attempt.error = error;
      jacobian = chain.jacobian(view(q));
    } else {
      damping = std::max(4.0 * damping, 1e-3);
    }
  }
  attempt.there = is_there(attempt.error, options);
  if (attempt.there) polish(chain, pose, attempt);
  return attempt;
}

double smallest_singular_value(const Chain& chain, const JointVector& q) {
  const Jacobian jacobian = chain.jacobian(view(q));
  const Matrix6d normal = jacobian * jacobian.transpose();
  const Vector6d squares =
      Eigen::SelfAdjointEigenSolver<Matrix6d>(normal, Eigen::EigenvaluesOnly).eigenvalues();
  return std::sqrt(std::max(0.0, squares(6 - std::min(6, chain.joints()))));
}

/// @return from 1, 0 = none. Rounding at the limit itself does not count.
int joint_past_limit(const RobotModel& model, const JointVector& q) {
  for (Index i = 0; i < q.size(); ++i) {
    const JointLimit& limit = model.limits()[static_cast<std::size_t>(i)];
    if (q(i) < limit.lower - 1e-9 || q(i) > limit.upper + 1e-9) return static_cast<int>(i) + 1;
  }
  return 0;
}

/// Whole turns that bring each joint into its limits, and there as near to the reference as can be.
void unwind(const RobotModel& model, const JointVector& reference, JointVector& q) {
  for (Index i = 0; i < q.size(); ++i) {
    const JointLimit& limit = model.limits()[static_cast<std::size_t>(i)];
    const double nearest = q(i) + kTurn * std::round((reference(i) - q(i)) / kTurn);
    q(i) = nearest;
    for (const double turn : {kTurn, -kTurn})
      if ((q(i) < limit.lower || q(i) > limit.upper) && nearest + turn >= limit.lower &&
          nearest + turn <= limit.upper)
        q(i) = nearest + turn;
  }
}

IkResult result_of(const RobotModel& model, const Attempt& attempt, const IkOptions& options) {
  IkResult result;
  result.q.assign(attempt.q.data(), attempt.q.data() + attempt.q.size());
  model.from_chain(result.q);
  result.smallest_singular_value = smallest_singular_value(model.chain(), attempt.q);
  result.position_error = attempt.error.head<3>().norm();
  result.rotation_error = attempt.error.tail<3>().norm();
  if (!attempt.there) return result;
  result.joint = joint_past_limit(model, attempt.q);
  result.status = result.joint > 0                                    ? IkStatus::kLimit
                  : result.smallest_singular_value < options.singular ? IkStatus::kSingular
                                                                      : IkStatus::kOk;
  return result;
}

JointVector chain_angles(const RobotModel& model, std::span<const double> q) {
  if (q.size() != static_cast<std::size_t>(model.joints()))
    throw std::invalid_argument("inverse: " + std::to_string(q.size()) + " joint angles for a chain of " +
                                std::to_string(model.joints()));
  JointVector angles = Eigen::Map<const Eigen::VectorXd>(q.data(), model.joints());
  model.to_chain({angles.data(), q.size()});
  return angles;
}

/// Postures that fill the joints' ranges evenly: Halton's sequence, one prime a joint.
JointVector start_posture(const RobotModel& model, int number) {
  constexpr int kPrimes[kMaxChainJoints] = {2, 3, 5, 7, 11, 13, 17, 19, 23, 29, 31, 37, 41, 43, 47, 53};
  JointVector q(model.joints());
  for (Index i = 0; i < q.size(); ++i) {
    double fraction = 0.0;
    double part = 1.0;
    for (int n = number; n > 0; n /= kPrimes[i]) {
      part /= kPrimes[i];
      fraction += part * (n % kPrimes[i]);
    }
    const JointLimit& limit = model.limits()[static_cast<std::size_t>(i)];
    const double lower = std::max(limit.lower, -kPi);
    const double upper = std::min(limit.upper, kPi);
    q(i) = lower + fraction * std::max(0.0, upper - lower);
  }
  return q;
}

/// The best so far: within limits before past them, then the nearest to the reference; where none is there,
/// the least error.
class Choice {
 public:
  Choice(const RobotModel& model, const JointVector& reference) : model_(model), reference_(reference) {}

  void offer(Attempt attempt) {
    if (attempt.there) unwind(model_, reference_, attempt.q);
    const int rank = !attempt.there ? 2 : joint_past_limit(model_, attempt.q) > 0 ? 1 : 0;
    const double distance =
        attempt.there ? (attempt.q - reference_).squaredNorm() : attempt.error.squaredNorm();
    // Two starts that find one solution must not differ by their rounding.
    if (rank < rank_ || (rank == rank_ && distance < distance_ * (1.0 - 1e-9))) {
      rank_ = rank;
      distance_ = distance;
      best_ = attempt;
    }
  }

  const Attempt& best() const { return best_; }

 private:
  const RobotModel& model_;
  const JointVector& reference_;
  Attempt best_;
  int rank_ = 3;
  double distance_ = std::numeric_limits<double>::infinity();
};

}  // namespace

Isometry3d tool_pose(const Vec3& position, const Vec3& rpy) {
  using Eigen::AngleAxisd;
  Isometry3d pose = Isometry3d::Identity();
  pose.translation() = Vector3d(position[0], position[1], position[2]);
  pose.linear() = (AngleAxisd(rpy[2], Vector3d::UnitZ()) * AngleAxisd(rpy[1], Vector3d::UnitY()) *
                   AngleAxisd(rpy[0], Vector3d::UnitX()))
                      .toRotationMatrix();
  return pose;
}

Vector3d rotation_between(const Matrix3d& from, const Matrix3d& to) {
  Eigen::Quaterniond turn(Matrix3d(to * from.transpose()));
  if (turn.w() < 0) turn.coeffs() = -turn.coeffs();
  const double sine = turn.vec().norm();  // of half the angle; linear in it, so that nothing is lost near 0
  if (sine < 1e-12) return 2.0 * turn.vec();
  return 2.0 * std::atan2(sine, turn.w()) / sine * turn.vec();
}

IkResult inverse_near(const RobotModel& model, const Isometry3d& X_BT, std::span<const double> seed,
                      const IkOptions& options) {
  return result_of(model, solve_from(model.chain(), X_BT, chain_angles(model, seed), options), options);
}

IkResult inverse(const RobotModel& model, const Isometry3d& X_BT, std::span<const double> reference,
                 const IkOptions& options) {
  const std::vector<double> zero(static_cast<std::size_t>(model.joints()), 0.0);
  const JointVector wanted =
      chain_angles(model, reference.empty() ? std::span<const double>(zero) : reference);
  Choice choice(model, wanted);
  choice.offer(solve_from(model.chain(), X_BT, wanted, options));
  for (int k = 1; k <= options.starts; ++k)
    choice.offer(solve_from(model.chain(), X_BT, start_posture(model, k), options));
  return result_of(model, choice.best(), options);
}

PathResult solve_path(const RobotModel& model, std::span<const Isometry3d> poses,
                      std::span<const double> reference, const IkOptions& options) {
  PathResult path;
  path.q = Eigen::MatrixXd::Zero(model.joints(), static_cast<Index>(poses.size()));
  path.smallest_singular_value = std::numeric_limits<double>::infinity();
  std::vector<double> former;
  for (std::size_t i = 0; i < poses.size(); ++i) {
    IkResult next = i == 0 ? inverse(model, poses[i], reference, options)
                           : inverse_near(model, poses[i], former, options);
    const auto move = [&] {
      return (chain_angles(model, next.q) - chain_angles(model, former)).cwiseAbs().maxCoeff();
    };
    if (i > 0 && next.status != IkStatus::kUnreachable && move() > options.step)
      next.status = IkStatus::kSingular;
    if (next.status != IkStatus::kOk) {
      path.status = next.status;
      path.index = static_cast<int>(i);
      path.joint = next.status == IkStatus::kLimit ? next.joint : 0;
      path.smallest_singular_value = next.smallest_singular_value;
      return path;
    }
    path.smallest_singular_value = std::min(path.smallest_singular_value, next.smallest_singular_value);
    path.q.col(static_cast<Index>(i)) = Eigen::Map<const Eigen::VectorXd>(next.q.data(), model.joints());
    former = std::move(next.q);
  }
  return path;
}

}  // namespace ballbar
