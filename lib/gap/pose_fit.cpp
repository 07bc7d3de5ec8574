#include "gap/pose_fit.hpp"

#include <Eigen/Cholesky>
#include <Eigen/QR>
#include <Eigen/SVD>
#include <algorithm>
#include <cmath>
#include <set>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::Vector3d;
using Eigen::VectorXd;

constexpr double kSetUpPrior = 1.0;  // [m], [rad] about where a step begins: only to keep the steps finite
constexpr int kMostPoseSteps = 12;
constexpr double kSmallStep = 1e-4;  // of the standard deviation of the readings
constexpr double kLeastSd = 1e-9;    // [m]

Eigen::Isometry3d rigid_fit(const std::vector<Vector3d>& from, const std::vector<Vector3d>& to) {
  Vector3d centre_from = Vector3d::Zero(), centre_to = Vector3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i) {
    centre_from += from[i] / static_cast<double>(from.size());
    centre_to += to[i] / static_cast<double>(to.size());
  }
  Eigen::Matrix3d cross = Eigen::Matrix3d::Zero();
  for (std::size_t i = 0; i < from.size(); ++i)
    cross += (to[i] - centre_to) * (from[i] - centre_from).transpose();
  const Eigen::JacobiSVD<Eigen::Matrix3d> svd(cross, Eigen::ComputeFullU | Eigen::ComputeFullV);
  Vector3d sign(1.0, 1.0, (svd.matrixU() * svd.matrixV().transpose()).determinant() < 0.0 ? -1.0 : 1.0);
  Eigen::Isometry3d pose = Eigen::Isometry3d::Identity();
  pose.linear() = svd.matrixU() * sign.asDiagonal() * svd.matrixV().transpose();
  pose.translation() = centre_to - pose.linear() * centre_from;
  return pose;
}

/// |p|^2 - 2 p.f + |f|^2 = L^2, linear in f and |f|^2.
Vector3d trilaterated(const std::vector<Vector3d>& points, const std::vector<double>& lengths) {
  MatrixXd a(static_cast<Index>(points.size()), 4);
  VectorXd b(a.rows());
  for (Index i = 0; i < a.rows(); ++i) {
    const auto k = static_cast<std::size_t>(i);
    a.row(i) << 2.0 * points[k].transpose(), -1.0;
    b[i] = points[k].squaredNorm() - lengths[k] * lengths[k];
  }
  return a.colPivHouseholderQr().solve(b).head<3>();
}

/// Largest effect of a step on a reading.
double size_of(const MatrixXd& columns, const VectorXd& step) {
  return columns.rows() == 0 ? 0.0 : (columns * step).cwiseAbs().maxCoeff();
}

}  // namespace

double crowding(const std::vector<PoseRow>& rows, const VectorXd& residual) {
  constexpr double kMostCorrelation = 0.99;
  const double shared = std::sqrt(static_cast<double>(rows.size()) / places_of(rows));
  const bool moving = std::any_of(rows.begin(), rows.end(),
                                  [](const PoseRow& r) { return r.speed.cwiseAbs().maxCoeff() > 0.0; });
  const Index per_row = residual.size() / static_cast<Index>(rows.size());
  const double all = residual.squaredNorm();
  if (!moving || !(all > 0.0)) return shared;
  const Index rest = residual.size() - per_row;
  const double r = std::clamp(residual.head(rest).dot(residual.tail(rest)) / all, 0.0, kMostCorrelation);
  return shared * std::sqrt((1.0 + r) / (1.0 - r));
}

int places_of(const std::vector<PoseRow>& rows) {
  std::set<int> places;
  for (const PoseRow& row : rows) places.insert(row.place);
  return static_cast<int>(places.size());
}

double pose_rms(const VectorXd& residual, int per_row) {
  return residual.size() == 0
             ? 0.0
             : std::sqrt(residual.squaredNorm() / (static_cast<double>(residual.size()) / per_row));
}

double pose_median(const VectorXd& residual, int per_row) {
  std::vector<double> sizes;
  for (Index i = 0; i < residual.size(); i += per_row) sizes.push_back(residual.segment(i, per_row).norm());
  if (sizes.empty()) return 0.0;
  std::nth_element(sizes.begin(), sizes.begin() + static_cast<std::ptrdiff_t>(sizes.size() / 2), sizes.end());
  return sizes[sizes.size() / 2];
}

VectorXd prior_weights(const PoseState& state, bool lengths) {
  const int nuisance = state.nuisance(lengths);
  VectorXd weights(nuisance + static_cast<Index>(state.values.size()));
  weights.head(nuisance).setConstant(1.0 / (kSetUpPrior * kSetUpPrior));
  Index at = nuisance;
  for (const PoseTerm& term : state.terms)
    for (int k = 0; k < term.width; ++k) weights[at++] = std::pow(kPosePrior * term.typical, -2);
  return weights;
}

MatrixXd pose_columns(const PoseModel& model, const std::vector<PoseRow>& rows, const PoseState& state,
                      const std::vector<PoseGeometry>& geometry) {
  const int nuisance = state.nuisance(model.lengths());
  MatrixXd columns(model.per_row() * static_cast<Index>(rows.size()),
                   nuisance + static_cast<Index>(state.values.size()));
  columns.leftCols(nuisance) = model.nuisance_columns(rows, state, geometry);
  Index at = nuisance;
  for (const PoseTerm& term : state.terms) {
    columns.middleCols(at, term.width) = model.term_columns(rows, term, geometry);
    at += term.width;
  }
  return columns;
}

PoseState start_poses(const PoseModel& model, const PoseRows& rows) {
  PoseState state;
  state.tools.assign(rows.tools.size(), Vector3d::Zero());
  for (std::size_t f = 0; f < rows.frames.size(); ++f) {
    std::vector<Vector3d> tips, points;
    std::vector<double> lengths;
    for (const PoseRow& row : rows.rows) {
      if (row.frame != static_cast<int>(f)) continue;
      const JointVector q = row.q + row.known;
      tips.push_back(model.chain().forward({q.data(), static_cast<std::size_t>(q.size())}).translation());
      points.push_back(row.point);
      lengths.push_back(row.length);
    }
    if (model.lengths())
      state.fixed.push_back(trilaterated(tips, lengths));
    else
      state.frames.push_back(rigid_fit(tips, points));
  }
  return state;
}

PoseFit fit_poses(const PoseModel& model, const std::vector<PoseRow>& rows, const PoseState& start,
                  double least_sd) {
  PoseFit fit;
  fit.state = start;
  const auto values = static_cast<Index>(start.values.size());
  const VectorXd weights = prior_weights(start, model.lengths());
  for (int step_number = 0; step_number < kMostPoseSteps; ++step_number) {
    std::vector<PoseGeometry> geometry;
    fit.residual = model.residual(rows, fit.state, &geometry);
    const MatrixXd columns = pose_columns(model, rows, fit.state, geometry);
    const auto readings = static_cast<double>(fit.residual.size());
    const double dof = std::max(readings / 4.0, readings - static_cast<double>(columns.cols()));
    fit.sd = crowding(rows, fit.residual) *
             std::max({least_sd, kLeastSd, std::sqrt(fit.residual.squaredNorm() / dof)});
    MatrixXd normal = MatrixXd::Zero(columns.cols(), columns.cols());
    normal.selfadjointView<Eigen::Lower>().rankUpdate(columns.transpose(), 1.0 / (fit.sd * fit.sd));
    normal.diagonal() += weights;
    VectorXd right = columns.transpose() * fit.residual / (fit.sd * fit.sd);
    right.tail(values) -=
        weights.tail(values).cwiseProduct(Eigen::Map<const VectorXd>(fit.state.values.data(), values));
    const Eigen::LLT<MatrixXd> factor(normal.selfadjointView<Eigen::Lower>());
    const VectorXd step = factor.solve(right);
    fit.covariance =
        factor.solve(MatrixXd::Identity(columns.cols(), columns.cols())).bottomRightCorner(values, values);
    fit.state = model.moved(fit.state, step);
    if (step_number > 0 && size_of(columns, step) < kSmallStep * fit.sd) break;
  }
  fit.residual = model.residual(rows, fit.state);
  return fit;
}

PoseState fit_set_ups(const PoseModel& model, const std::vector<PoseRow>& rows, const PoseState& state) {
  PoseState fitted = state;
  for (int step_number = 0; step_number < kMostPoseSteps; ++step_number) {
    std::vector<PoseGeometry> geometry;
    const VectorXd residual = model.residual(rows, fitted, &geometry);
    const MatrixXd columns = model.nuisance_columns(rows, fitted, geometry);
    const double scale = std::pow(
        std::max(kLeastSd, std::sqrt(residual.squaredNorm() / static_cast<double>(residual.size()))), 2);
    MatrixXd normal = columns.transpose() * columns / scale;
    normal.diagonal().array() += 1.0 / (kSetUpPrior * kSetUpPrior);
    VectorXd step = VectorXd::Zero(columns.cols() + static_cast<Index>(state.values.size()));
    step.head(columns.cols()) = normal.llt().solve(columns.transpose() * residual / scale);
    fitted = model.moved(fitted, step);
    if (size_of(columns, step.head(columns.cols())) < 1e-9) break;
  }
  return fitted;
}

}  // namespace ballbar
