#include <algorithm>
#include <cmath>

#include "gap/pose_search.hpp"

namespace ballbar {
namespace {

using Eigen::Index;

// Sizes on a sound robot, of which the prior is twice as wide.
constexpr double kOffset = 2e-3, kTwist = 1e-3;  // [rad]
constexpr double kLength = 0.5e-3;               // [m]
constexpr double kBending = 1e-3;                // [rad] at the largest torque of the rows
constexpr double kRunOut = 0.3e-3;               // [rad] eccentricity
constexpr double kPlay = 0.12e-3;                // [rad] full width
constexpr double kFraction = 2e-3, kAge = 3e-3;  // of a move; [s]
constexpr double kDriftInAll = 0.1e-3;           // [m] from the first row to the last
constexpr double kStrain = 2e-4;
constexpr double kAngleStep = 0.05e-3, kTimeStep = 5e-5;  // [rad], [m] of a knot of a curve
constexpr double kNearlyParallel = 0.0873;                // [rad] 5 deg
constexpr double kLeastTorque = 0.05;                     // [Nm] spread below which there is nothing to bend

struct Range {
  double least = 0.0, most = 0.0;
  double width() const { return most - least; }
};

template <typename Of>
Range range_of(const std::vector<PoseRow>& rows, Of of) {
  Range range{of(rows.front()), of(rows.front())};
  for (const PoseRow& row : rows) {
    range.least = std::min(range.least, of(row));
    range.most = std::max(range.most, of(row));
  }
  return range;
}

void add_joint_terms(const std::vector<PoseRow>& rows, const PoseRows& all, Index j,
                     std::vector<PoseTerm>& terms) {
  const int joint = static_cast<int>(j) + 1;
  const Range torque = range_of(rows, [&](const PoseRow& r) { return r.torque[j]; });
  const Range angle = range_of(rows, [&](const PoseRow& r) { return r.q[j]; });
  const double load = std::max(std::abs(torque.least), std::abs(torque.most));
  if (torque.width() > kLeastTorque)
    terms.push_back({PoseEffect::kCompliance, joint, 0.0, 0.0, kBending / load, 1});
  if (angle.width() > 0.2) terms.push_back({PoseEffect::kEccentricity, joint, 0.0, 0.0, kRunOut, 2});
  if (all.directed) terms.push_back({PoseEffect::kLostMotion, joint, 0.0, 0.0, kPlay, 1});
  if (range_of(rows, [&](const PoseRow& r) { return r.approach[j]; }).width() > 1.5)
    terms.push_back({PoseEffect::kLostMotionMove, joint, 0.0, 0.0, kPlay, 1});
  if (all.moving)
    terms.push_back({PoseEffect::kReadbackTime, joint, 0.0, 0.0, kAge, 1});
  else if (range_of(rows, [&](const PoseRow& r) { return r.move[j]; }).width() > 0.01)
    terms.push_back({PoseEffect::kReadbackMove, joint, 0.0, 0.0, kFraction, 1});
  if (range_of(rows, [&](const PoseRow& r) { return r.command[j]; }).width() > 1e-6)
    terms.push_back({PoseEffect::kReadbackCommand, joint, 0.0, 0.0, 0.5, 1});
}

}  // namespace

std::vector<PoseTerm> geometry_terms(const Chain& chain) {
  std::vector<PoseTerm> terms;
  for (int joint = 1; joint <= chain.joints(); ++joint) {
    const DhRow& row = chain.rows()[static_cast<std::size_t>(joint - 1)];
    terms.push_back({PoseEffect::kZeroOffset, joint, 0.0, 0.0, kOffset, 1});
    terms.push_back({PoseEffect::kLinkA, joint, 0.0, 0.0, kLength, 1});
    terms.push_back({PoseEffect::kLinkD, joint, 0.0, 0.0, kLength, 1});
    terms.push_back({PoseEffect::kLinkAlpha, joint, 0.0, 0.0, kTwist, 1});
    if (std::abs(std::sin(row.alpha)) < std::sin(kNearlyParallel))
      terms.push_back({PoseEffect::kLinkBeta, joint, 0.0, 0.0, kTwist, 1});
  }
  return terms;
}

std::vector<PoseTerm> effect_candidates(const PoseRows& all, const std::vector<PoseRow>& rows) {
  std::vector<PoseTerm> terms;
  for (Index j = 0; j < rows.front().q.size(); ++j) add_joint_terms(rows, all, j, terms);
  if (all.moving)
    terms.push_back({PoseEffect::kReadbackTime, 0, 0.0, 0.0, kAge, 1});
  else
    terms.push_back({PoseEffect::kReadbackMove, 0, 0.0, 0.0, kFraction, 1});
  if (all.commanded) terms.push_back({PoseEffect::kReadbackCommand, 0, 0.0, 0.0, 0.5, 1});
  const double span = all.timed ? range_of(rows, [](const PoseRow& r) { return r.time; }).width() : 0.0;
  if (span > 0.0) terms.push_back({PoseEffect::kDrift, 0, 0.0, 0.0, kDriftInAll / span, 3});
  for (const double minutes : {5.0, 20.0, 60.0, 180.0})
    if (span > minutes * 60.0)
      for (const int joint : {0, 2, 3})
        if (joint < rows.front().q.size())
          terms.push_back({PoseEffect::kGrowth, joint, minutes * 60.0, 0.0, kStrain, 1});
  return terms;
}

std::vector<PoseTerm> curve_candidates(const std::vector<PoseRow>& rows) {
  std::vector<PoseTerm> terms;
  if (rows.size() < 4 * std::size_t{kAngleKnots}) return terms;
  for (Index j = 0; j < rows.front().q.size(); ++j) {
    const Range angle = range_of(rows, [&](const PoseRow& r) { return r.q[j]; });
    if (angle.width() > 0.2)
      terms.push_back({PoseEffect::kAngleCurve, static_cast<int>(j) + 1, angle.least, angle.most, kAngleStep,
                       kAngleKnots});
  }
  terms.push_back({PoseEffect::kTimeCurve, 0, 0.0, 0.0, kTimeStep, 3 * kTimeKnots});
  return terms;
}

}  // namespace ballbar
