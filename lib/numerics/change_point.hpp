#pragma once
/// Since when: the place in a sequence of vectors after which their mean is another.

#include <Eigen/Core>
#include <optional>
#include <vector>

namespace ballbar {

/// One change of the mean, between vector first_after - 1 and first_after. Counted from 0.
struct ChangePoint {
  Eigen::Index first_after = 0;           ///< most likely: the first vector of the new level
  Eigen::Index earliest = 0, latest = 0;  ///< first_after lies in earliest .. latest at the stated level
  double t2 = 0.0;                        ///< Hotelling's T^2 of the two levels
  double p_value = 1.0;                   ///< that no place shows so much where nothing has changed, at most
  bool gradual = false;                   ///< an even slope fits better than a step
  Eigen::VectorXd step;                   ///< new mean minus old one
};

/// Fewest vectors on either side of a change: one alone may be an outlier.
inline constexpr Eigen::Index kLeastSide = 2;

/// How many components n vectors can carry: their common covariance is estimated from them.
Eigen::Index components_for(Eigen::Index vectors);

/// The most likely single change of normally distributed vectors of one unknown covariance. T^2 at each place
/// (Hotelling 1931), its p-value times the number of places (Bonferroni). The range is the shortest that
/// holds `level` of the posterior of the place, all places alike beforehand; means and covariance are
/// integrated out (flat, and Jeffreys' prior): ln p(k) = -p/2 ln(k (n - k)) - (n - 2)/2 ln|W_k|, W_k the
/// scatter within the two parts. Source: A. Sen, M. S. Srivastava, Ann. Statist. 3 (1975) 98-108 (Bayes
/// statistics of one change).
/// @param vectors  n x p, in sequence of time
/// @return nothing where n < 2 kLeastSide + p or the vectors do not scatter in all components
/// @throws std::invalid_argument for a value that is not finite or a level outside (0, 1)
std::optional<ChangePoint> most_likely_change(const Eigen::MatrixXd& vectors, double level = 0.95);

/// All changes with p_value < alpha, found by splitting at the most likely one and looking at both parts
/// again. In sequence; each of its own part.
std::vector<ChangePoint> changes(const Eigen::MatrixXd& vectors, double alpha = 0.01, double level = 0.95);

/// Regularized incomplete beta function I_x(a, b), 0 <= x <= 1, a, b > 0: the continued fraction of DLMF
/// 8.17.22 by Lentz's algorithm.
double incomplete_beta(double x, double a, double b);

}  // namespace ballbar
