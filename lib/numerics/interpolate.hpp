#pragma once
/// Values between samples.

#include <Eigen/Core>

namespace ballbar {

enum class Interpolation {
  kLinear,  ///< for what may step: no value beyond its two neighbours
  kCubic,   ///< for what is smooth: the cubic through the two samples on either side (Lagrange), the nearest
            ///< four at the ends; through fewer where there are no more
};

/// Columns of `values` at other abscissae.
/// @param x       n abscissae, strictly rising
/// @param values  m x n
/// @param at      k abscissae, any sequence
/// @param widest  samples further apart than this are not joined
/// @return m x k; NaN outside [x_0, x_n-1] and inside intervals wider than `widest`
/// @throws std::invalid_argument where x does not rise or sizes differ
Eigen::MatrixXd interpolate(const Eigen::VectorXd& x, const Eigen::MatrixXd& values,
                            const Eigen::VectorXd& at, double widest, Interpolation kind);

}  // namespace ballbar
