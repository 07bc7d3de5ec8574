#pragma once
/// Records along an arc as uncorrelated numbers of unit variance: cosine coefficients over the standard
/// deviation of their noise.

#include <Eigen/Core>
#include <memory>

namespace ballbar {

/// A record along an arc as a sum of cosines: y(x) = sum c_k phi_k(x), x = 0 .. 1 along the arc,
/// phi_0 = sqrt(1/n), phi_k = sqrt(2/n) cos(pi k x), k = 0..K where K/2 cycles on the arc are the most that
/// is asked for, and K < n. Cosines need no record that closes: an arc is as good as a lap, and a drift leaks
/// into few of them. With n places in the middles of n equal parts the transform is orthonormal (DCT-II):
/// white noise of variance v gives coefficients of variance v each. Source: N. Ahmed, T. Natarajan, K. R.
/// Rao, IEEE Trans. Computers C-23 (1974) 90-93.
class CosineTransform {
 public:
  /// @param samples        n >= 1 places
  /// @param turns          length of the arc in turns: 1 for a lap
  /// @param max_frequency  >= 0 [cycles per turn]
  /// @throws std::invalid_argument
  CosineTransform(Eigen::Index samples, double turns, double max_frequency);

  Eigen::Index samples() const { return samples_; }
  double turns() const { return turns_; }
  /// One per coefficient [cycles per turn]: k/2 over turns.
  const Eigen::VectorXd& frequency() const { return frequency_; }

  /// Of values in the middles of n equal parts of the arc.
  /// @param values  n x m, a record per column @return (K + 1) x m
  /// @throws std::invalid_argument for another number of samples
  Eigen::MatrixXd operator()(const Eigen::MatrixXd& values) const;

  /// Values at the n places of these coefficients: what lies above the highest frequency is not in them.
  /// @param coefficients  K + 1 @return n
  /// @throws std::invalid_argument for another number of coefficients
  Eigen::VectorXd inverse(const Eigen::VectorXd& coefficients) const;

  /// Of values at uneven places: the least-squares coefficients, each value weighed with its share of the
  /// arc, by three steps of their iteration, which converges as fast as the places are even. Where there are
  /// far more values than coefficients, neighbours are averaged first and the loss is made good.
  /// @param x       places, rising, inside 0 .. 1, at least 2.2 per coefficient and none far from its
  /// neighbours
  /// @param values  one per place
  /// @return K + 1
  /// @throws std::invalid_argument for other sizes, too few values or places that do not rise
  Eigen::VectorXd fit(const Eigen::VectorXd& x, const Eigen::VectorXd& values) const;

 private:
  Eigen::Index samples_;
  double turns_;
  Eigen::VectorXd frequency_;
  struct Tables;
  std::shared_ptr<const Tables> tables_;  ///< of the fast transform
};

/// Values that CosineTransform::fit() asks for, per coefficient.
inline constexpr double kValuesPerCoefficient = 2.2;

/// Coefficients over the standard deviation of their noise: where `variance` is that of the values' noise,
/// the result has noise of unit variance ("whitened: unit variance", physics-gap.md 5, step 1). Columns of a
/// model are whitened by the same call as the data.
/// @param values    n x m
/// @param variance  one per coefficient, > 0 [unit of the values, squared]
/// @throws std::invalid_argument for other sizes, or a variance that is not above zero or not finite
Eigen::MatrixXd whiten(const CosineTransform& transform, const Eigen::MatrixXd& values,
                       const Eigen::VectorXd& variance);

}  // namespace ballbar
