#include "gap/pose_model.hpp"

#include <algorithm>
#include <cmath>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

/// Straight between knots: at most two of them are not 0. @param at  0 to 1
void hats(double at, int knots, double* pattern) {
  std::fill(pattern, pattern + knots, 0.0);
  const double place = std::clamp(at, 0.0, 1.0) * (knots - 1);
  const int left = std::min(static_cast<int>(place), knots - 2);
  pattern[left] = 1.0 - (place - left);
  pattern[left + 1] = place - left;
}

double grown(const PoseTerm& term, const PoseRow& row) { return -std::expm1(-row.time / term.setting); }

bool is_geometry(PoseEffect effect) { return effect <= PoseEffect::kLinkBeta; }

double LinkDeviation::*member_of(PoseEffect effect) {
  switch (effect) {
    case PoseEffect::kLinkA:
      return &LinkDeviation::a;
    case PoseEffect::kLinkD:
      return &LinkDeviation::d;
    case PoseEffect::kLinkAlpha:
      return &LinkDeviation::alpha;
    case PoseEffect::kLinkBeta:
      return &LinkDeviation::beta;
    default:
      return &LinkDeviation::zero_offset;
  }
}

const JointColumns& columns_of(PoseEffect effect, const PositionColumns& columns) {
  switch (effect) {
    case PoseEffect::kLinkA:
      return columns.a;
    case PoseEffect::kLinkD:
      return columns.d;
    case PoseEffect::kLinkAlpha:
      return columns.alpha;
    case PoseEffect::kLinkBeta:
      return columns.beta;
    default:
      return columns.joint;
  }
}

/// Rows of the table whose lengths grow.
bool grows(const PoseTerm& term, Index row) { return row >= 1 && (term.joint == 0 || row == term.joint); }

/// What is not an angle, as columns in the base frame (or of the reading).
void place_columns(const PoseTerm& term, const PoseRow& row, const Chain& chain, const PoseGeometry& at,
                   bool lengths, Eigen::Ref<MatrixXd> out) {
  const Index size = out.rows();
  switch (term.effect) {
    case PoseEffect::kJump:
      if (row.row < term.setting) return;
      if (lengths)
        out(0, 0) = 1.0;
      else
        out = at.axes;
      return;
    case PoseEffect::kDrift:
      out = row.time * at.axes.topRows(size);
      return;
    case PoseEffect::kTimeCurve: {
      double pattern[kTimeKnots];
      hats(row.order, kTimeKnots, pattern);
      for (int k = 0; k < kTimeKnots; ++k)
        out.middleCols(3 * Index{k}, 3) = pattern[k] * at.axes.topRows(size);
      return;
    }
    case PoseEffect::kGrowth:
      for (std::size_t i = 0; i < chain.rows().size(); ++i) {
        const auto j = static_cast<Index>(i);
        if (grows(term, j))
          out.col(0) += grown(term, row) * (chain.rows()[i].a * at.columns.a.col(j).head(size) +
                                            chain.rows()[i].d * at.columns.d.col(j).head(size));
      }
      return;
    default:
      return;
  }
}

/// Movement of the point by effects that are neither angle nor length, in the base frame; the reading's own
/// jump in `reading`.
Vector3d displacement(const PoseState& state, const PoseRow& row, bool lengths, double& reading) {
  Vector3d moved = Vector3d::Zero();
  const double* value = state.values.data();
  for (const PoseTerm& term : state.terms) {
    const Vector3d three = term.width >= 3 ? Vector3d(value[0], value[1], value[2]) : Vector3d::Zero();
    if (term.effect == PoseEffect::kDrift) moved += row.time * three;
    if (term.effect == PoseEffect::kJump && row.row >= term.setting) {
      if (lengths)
        reading += value[0];
      else
        moved += three;
    }
    if (term.effect == PoseEffect::kTimeCurve) {
      double pattern[kTimeKnots];
      hats(row.order, kTimeKnots, pattern);
      for (int k = 0; k < kTimeKnots; ++k)
        moved += pattern[k] * Eigen::Map<const Vector3d>(value + 3 * static_cast<std::ptrdiff_t>(k));
    }
    value += term.width;
  }
  return moved;
}

JointVector link_angles(const PoseState& state, const PoseRow& row) {
  JointVector q = row.q + row.known;
  double pattern[kAngleKnots];
  const double* value = state.values.data();
  for (const PoseTerm& term : state.terms) {
    const Index first = term.joint == 0 ? 0 : term.joint - 1;
    const Index last = term.joint == 0 ? q.size() - 1 : first;
    if (!is_geometry(term.effect))
      for (Index j = first; j <= last && angle_pattern(term, row, j, pattern); ++j)
        for (int k = 0; k < term.width; ++k) q[j] += pattern[k] * value[k];
    value += term.width;
  }
  return q;
}

/// The chain with the state's geometry, one per tool; grown by what time has made of it where there is any.
Chain chain_of(const Chain& nominal, const PoseState& state, std::size_t tool, const PoseRow* row) {
  ChainDeviation deviation;
  deviation.tool = state.tools[tool];
  deviation.links.resize(static_cast<std::size_t>(nominal.joints()));
  const double* value = state.values.data();
  for (const PoseTerm& term : state.terms) {
    if (is_geometry(term.effect))
      deviation.links[static_cast<std::size_t>(term.joint - 1)].*member_of(term.effect) += *value;
    if (row != nullptr && term.effect == PoseEffect::kGrowth)
      for (std::size_t i = 0; i < deviation.links.size(); ++i)
        if (grows(term, static_cast<Index>(i))) {
          deviation.links[i].a += *value * grown(term, *row) * nominal.rows()[i].a;
          deviation.links[i].d += *value * grown(term, *row) * nominal.rows()[i].d;
        }
    value += term.width;
  }
  return nominal.with(deviation);
}

}  // namespace

int PoseState::nuisance(bool lengths) const {
  return static_cast<int>(lengths ? 3 * fixed.size() : 6 * frames.size()) +
         3 * static_cast<int>(tools.size());
}

bool angle_pattern(const PoseTerm& term, const PoseRow& row, Index j, double* pattern) {
  switch (term.effect) {
    case PoseEffect::kCompliance:
      pattern[0] = -row.torque[j];
      return true;
    case PoseEffect::kEccentricity:
      pattern[0] = std::sin(row.q[j]);
      pattern[1] = std::cos(row.q[j]);
      return true;
    case PoseEffect::kRipple:
      pattern[0] = std::sin(term.setting * row.q[j]);
      pattern[1] = std::cos(term.setting * row.q[j]);
      return true;
    case PoseEffect::kRippleRate:
      pattern[0] = row.q[j] * std::cos(term.setting * row.q[j] + term.setting2);
      return true;
    case PoseEffect::kLostMotion:
      pattern[0] = -0.5 * row.direction;
      return true;
    case PoseEffect::kLostMotionMove:
      pattern[0] = -0.5 * row.approach[j];
      return true;
    case PoseEffect::kReadbackMove:
      pattern[0] = row.move[j];
      return true;
    case PoseEffect::kReadbackCommand:
      pattern[0] = row.command[j];
      return true;
    case PoseEffect::kReadbackTime:
      pattern[0] = row.speed[j];
      return true;
    case PoseEffect::kAngleCurve:
      hats((row.q[j] - term.setting) / (term.setting2 - term.setting), kAngleKnots, pattern);
      return true;
    default:
      return false;
  }
}

VectorXd PoseModel::residual(const std::vector<PoseRow>& rows, const PoseState& state) const {
  return residual(rows, state, nullptr);
}

VectorXd PoseModel::residual(const std::vector<PoseRow>& rows, const PoseState& state,
                             std::vector<PoseGeometry>* geometry) const {
  const bool growing = std::any_of(state.terms.begin(), state.terms.end(),
                                   [](const PoseTerm& t) { return t.effect == PoseEffect::kGrowth; });
  std::vector<Chain> chains;
  for (std::size_t tool = 0; tool < state.tools.size(); ++tool)
    chains.push_back(chain_of(chain_, state, tool, nullptr));
  if (geometry != nullptr) geometry->resize(rows.size());
  const int size = per_row();
  VectorXd residual(size * static_cast<Index>(rows.size()));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const PoseRow& row = rows[i];
    const auto tool = static_cast<std::size_t>(row.tool), set_up = static_cast<std::size_t>(row.frame);
    const JointVector q = link_angles(state, row);
    const std::span<const double> angles(q.data(), static_cast<std::size_t>(q.size()));
    const Chain grown_chain = growing ? chain_of(chain_, state, tool, &row) : chain_;
    const Chain& chain = growing ? grown_chain : chains[tool];
    double jump = 0.0;
    const Vector3d point = chain.forward(angles).translation() + displacement(state, row, lengths_, jump);
    PoseGeometry at;
    if (lengths_) {
      const Vector3d way = point - state.fixed[set_up];
      const double length = std::max(way.norm(), 1e-9);
      at.tip = Vector3d(length + jump, 0.0, 0.0);
      at.axes.setZero();
      at.axes.row(0) = way.transpose() / length;
      residual[static_cast<Index>(i)] = row.length - at.tip.x();
    } else {
      at.axes = state.frames[set_up].linear();
      at.arm = at.axes * point;
      at.tip = at.arm + state.frames[set_up].translation();
      residual.segment<3>(3 * static_cast<Index>(i)) = row.point - at.tip;
    }
    if (geometry == nullptr) continue;
    at.columns = chain.position_columns(angles);
    for (JointColumns* each :
         {&at.columns.joint, &at.columns.a, &at.columns.d, &at.columns.alpha, &at.columns.beta})
      *each = (at.axes * *each).eval();
    at.columns.tool = (at.axes * at.columns.tool).eval();
    (*geometry)[i] = at;
  }
  return residual;
}

MatrixXd PoseModel::nuisance_columns(const std::vector<PoseRow>& rows, const PoseState& state,
                                     const std::vector<PoseGeometry>& geometry) const {
  const Index size = per_row(), per_set_up = lengths_ ? 3 : 6;
  const auto set_ups = static_cast<Index>(lengths_ ? state.fixed.size() : state.frames.size());
  MatrixXd columns = MatrixXd::Zero(size * static_cast<Index>(rows.size()), state.nuisance(lengths_));
  for (std::size_t i = 0; i < rows.size(); ++i) {
    const Index top = size * static_cast<Index>(i), left = per_set_up * rows[i].frame;
    const PoseGeometry& at = geometry[i];
    if (lengths_) {
      columns.block(top, left, 1, 3) = -at.axes.topRows(1);
    } else {  // rotation of the frame on the left: w x arm
      columns.block<3, 3>(top, left) << 0.0, at.arm.z(), -at.arm.y(), -at.arm.z(), 0.0, at.arm.x(),
          at.arm.y(), -at.arm.x(), 0.0;
      columns.block<3, 3>(top, left + 3).setIdentity();
    }
    columns.block(top, per_set_up * set_ups + 3 * Index{rows[i].tool}, size, 3) =
        at.columns.tool.topRows(size);
  }
  return columns;
}

MatrixXd PoseModel::term_columns(const std::vector<PoseRow>& rows, const PoseTerm& term,
                                 const std::vector<PoseGeometry>& geometry) const {
  const Index size = per_row();
  MatrixXd columns = MatrixXd::Zero(size * static_cast<Index>(rows.size()), term.width);
  double pattern[kAngleKnots];
  for (std::size_t i = 0; i < rows.size(); ++i) {
    auto out = columns.middleRows(size * static_cast<Index>(i), size);
    if (is_geometry(term.effect)) {
      out.col(0) = columns_of(term.effect, geometry[i].columns).col(term.joint - 1).head(size);
      continue;
    }
    const Index first = term.joint == 0 ? 0 : term.joint - 1;
    const Index last = term.joint == 0 ? rows[i].q.size() - 1 : first;
    bool angle = false;
    for (Index j = first; j <= last && angle_pattern(term, rows[i], j, pattern); ++j) {
      angle = true;
      out += geometry[i].columns.joint.col(j).head(size) *
             Eigen::Map<const Eigen::RowVectorXd>(pattern, term.width);
    }
    if (!angle) place_columns(term, rows[i], chain_, geometry[i], lengths_, out);
  }
  return columns;
}

PoseState PoseModel::moved(const PoseState& state, const VectorXd& step) const {
  PoseState moved = state;
  Index at = 0;
  for (Eigen::Isometry3d& frame : moved.frames) {
    if (lengths_) break;
    const Vector3d turn = step.segment<3>(at);
    if (turn.norm() > 0.0) {
      frame.linear() =
          (Eigen::AngleAxisd(turn.norm(), turn.normalized()).toRotationMatrix() * frame.linear()).eval();
    }
    frame.translation() += step.segment<3>(at + 3);
    at += 6;
  }
  for (Vector3d& fixed : moved.fixed) {
    if (!lengths_) break;
    fixed += step.segment<3>(at);
    at += 3;
  }
  for (Vector3d& tool : moved.tools) {
    tool += step.segment<3>(at);
    at += 3;
  }
  for (double& value : moved.values) value += step[at++];
  return moved;
}

}  // namespace ballbar
