#include "numerics/resolved_fit.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <stdexcept>

#include "numerics/harmonics.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr double kMoved = 0.1;

/// Columns that one unknown direction moves belong together.
std::vector<std::vector<int>> groups_of(const MatrixXd& unknown) {
  std::vector<int> owner(static_cast<std::size_t>(unknown.rows()));
  std::iota(owner.begin(), owner.end(), 0);
  std::vector<bool> moved(owner.size(), false);
  for (Index k = 0; k < unknown.cols(); ++k) {
    int first = -1;
    for (std::size_t j = 0; j < owner.size(); ++j) {
      if (std::abs(unknown(static_cast<Index>(j), k)) < kMoved) continue;
      moved[j] = true;
      if (first < 0) first = owner[j];
      const int other = owner[j];
      std::replace(owner.begin(), owner.end(), other, first);
    }
  }
  std::vector<std::vector<int>> groups;
  for (std::size_t j = 0; j < owner.size(); ++j) {
    if (!moved[j]) continue;
    const auto same = [&](const std::vector<int>& g) {
      return owner[static_cast<std::size_t>(g[0])] == owner[j];
    };
    const auto found = std::find_if(groups.begin(), groups.end(), same);
    if (found == groups.end())
      groups.push_back({static_cast<int>(j)});
    else
      found->push_back(static_cast<int>(j));
  }
  return groups;
}

}  // namespace

bool ResolvedFit::told_apart(int column) const {
  return std::none_of(groups.begin(), groups.end(), [&](const std::vector<int>& group) {
    return std::find(group.begin(), group.end(), column) != group.end();
  });
}

ResolvedFit fit_resolved(const MatrixXd& columns, const VectorXd& value, const VectorXd& weight) {
  const Index n = columns.rows();
  const Index p = columns.cols();
  if (value.size() != n || weight.size() != n || n <= p)
    throw std::invalid_argument("fit: columns, values and weights differ in number, or are too few");
  if (!columns.allFinite() || !value.allFinite() || !weight.allFinite() || weight.minCoeff() < 0.0)
    throw std::invalid_argument("fit: a column, a value or a weight is not finite, or a weight is negative");
  const VectorXd root = weight.cwiseSqrt();
  MatrixXd scaled = root.asDiagonal() * columns;
  VectorXd size = scaled.colwise().norm();
  for (double& s : size)
    if (!(s > 0.0)) s = 1.0;
  scaled = scaled * size.cwiseInverse().asDiagonal();
  const VectorXd weighted = root.cwiseProduct(value);

  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(scaled.transpose() * scaled);
  const VectorXd& strength = eigen.eigenvalues();  // rising
  Index hidden = 0;
  while (hidden < p && !(strength[hidden] > 1.0 / (kWorstColumnDilution * kWorstColumnDilution))) ++hidden;
  const MatrixXd known = eigen.eigenvectors().rightCols(p - hidden);
  const VectorXd inverse = strength.tail(p - hidden).cwiseInverse();

  ResolvedFit fit;
  fit.basis = scaled * (known * inverse.cwiseSqrt().asDiagonal());
  const MatrixXd back = size.cwiseInverse().asDiagonal() * known * inverse.cwiseSqrt().asDiagonal();
  fit.coefficients = back * (fit.basis.transpose() * weighted);
  fit.residual = value - columns * fit.coefficients;
  fit.groups = groups_of(eigen.eigenvectors().leftCols(hidden));
  const VectorXd left = root.cwiseProduct(fit.residual);
  const auto counted = static_cast<double>((weight.array() > 0.0).count());
  fit.inflation = autocorrelation_inflation(left);
  const double variance = left.squaredNorm() / std::max(1.0, counted - static_cast<double>(p - hidden));
  fit.covariance = variance * fit.inflation * back * back.transpose();
  for (const std::vector<int>& group : fit.groups)
    for (const int j : group) {
      fit.covariance.row(j).setZero();
      fit.covariance.col(j).setZero();
    }
  return fit;
}

}  // namespace ballbar
