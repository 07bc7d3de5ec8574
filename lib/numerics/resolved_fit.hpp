#pragma once
/// Linear least squares that says which of its columns the samples do not tell apart.

#include <Eigen/Core>
#include <vector>

namespace ballbar {

/// value = columns x coefficients + residual.
struct ResolvedFit {
  Eigen::VectorXd
      coefficients;            ///< p; of columns not told apart: the shortest that fit, of no meaning singly
  Eigen::MatrixXd covariance;  ///< p x p, inflation included; zero for columns not told apart
  std::vector<std::vector<int>> groups;  ///< columns that only a sum of them is known of, each group rising
  Eigen::VectorXd residual;              ///< n
  double inflation = 1.0;                ///< >= 1, factor on the covariance for correlated residuals
  Eigen::MatrixXd basis;  ///< n x rank, orthonormal: what the columns span, times the root of the weights

  bool told_apart(int column) const;
};

/// A direction of the coefficients counts as unknown where the samples give it a variance more than
/// kWorstColumnDilution^2 times that of a single column of the same size. A column that such a direction
/// moves by a tenth or more is not told apart from the others that it moves. A column of zeros is a group by
/// itself.
/// @param columns  n x p, n > p
/// @param weight   n values >= 0
/// @throws std::invalid_argument for other sizes or a value that is not finite
ResolvedFit fit_resolved(const Eigen::MatrixXd& columns, const Eigen::VectorXd& value,
                         const Eigen::VectorXd& weight);

inline constexpr double kWorstColumnDilution = 20.0;

}  // namespace ballbar
