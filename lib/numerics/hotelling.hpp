#pragma once
/// Hotelling's T^2 of two-component vectors: has the mean moved by more than the scatter explains?

#include <Eigen/Core>
#include <optional>
#include <span>

namespace ballbar {

/// Mean and scatter of n vectors.
struct VectorSample {
  std::size_t count = 0;
  Eigen::Vector2d mean = Eigen::Vector2d::Zero();             ///< [unit of the vectors]
  std::optional<Eigen::Matrix2d> covariance;                  ///< of a single vector, over n - 1; from two on
  std::optional<Eigen::Matrix2d> covariance_of_mean() const;  ///< covariance / n
};

/// @throws std::invalid_argument for no vectors, or one that is not finite
VectorSample sample_of(std::span<const Eigen::Vector2d> vectors);

struct T2Test {
  double t2 = 0.0;       ///< squared distance of the means in units of its own covariance
  int dof = 0;           ///< degrees of freedom of the covariance, nu
  double p_value = 1.0;  ///< chance of a T^2 as large or larger where nothing has moved
};

/// One sample against a vector that is known without error: T^2 = n (m - h)' S^-1 (m - h), nu = n - 1
/// (Hotelling 1931; metrology.md 2). The vectors are taken as independent and normally distributed.
/// @return nothing for fewer than three vectors, or where they do not scatter in both directions
std::optional<T2Test> hotelling_one_sample(std::span<const Eigen::Vector2d> vectors,
                                           const Eigen::Vector2d& known);

/// A series against a baseline of the same scatter: T^2 = n1 n2 / (n1 + n2) d' S^-1 d, d the difference of
/// the means, S the pooled covariance, nu = n1 + n2 - 2. A series of one is a single new value against the
/// baseline.
/// @return nothing where nu < 2, one of both is empty, or they do not scatter in both directions
std::optional<T2Test> hotelling_two_sample(std::span<const Eigen::Vector2d> series,
                                           std::span<const Eigen::Vector2d> baseline);

/// P(T^2 >= t2) for two components: (1 + t2 / nu)^(-(nu - 1) / 2). For 1 / (1 + T^2 / nu) is Wilks' lambda,
/// which for two components and one difference is Beta((nu - 1) / 2, 1); the same as 2 nu / (nu - 1) F(2,
/// nu - 1). Closed, so that no tables of F are needed.
/// @throws std::invalid_argument for t2 < 0 or dof < 2
double t2_p_value(double t2, int dof);

/// The T^2 that is exceeded with probability alpha where nothing has moved: nu (alpha^(-2 / (nu - 1)) - 1).
/// @throws std::invalid_argument for alpha outside (0, 1] or dof < 2
double t2_limit(double alpha, int dof);

}  // namespace ballbar
