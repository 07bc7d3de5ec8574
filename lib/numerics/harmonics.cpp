#include "numerics/harmonics.hpp"

#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <complex>
#include <stdexcept>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

MatrixXd columns_of(const VectorXd& angle, int order) {
  MatrixXd columns(angle.size(), Index{2} * order + 1);
  columns.col(0).setOnes();
  for (Index i = 0; i < angle.size(); ++i) {
    const std::complex<double> turn(std::cos(angle[i]), std::sin(angle[i]));
    std::complex<double> power = turn;
    for (Index k = 1; k <= order; ++k, power *= turn) {
      columns(i, 2 * k - 1) = power.real();
      columns(i, 2 * k) = power.imag();
    }
  }
  return columns;
}

/// Inverts the triangle column by column and stops at the last order whose leading block still passes. The
/// variances of the model of p columns are the row sums of squares of the leading p x p block, so they only
/// grow with p.
int highest_order(const MatrixXd& r, Index samples, MatrixXd& r_inverse) {
  const double worst_mean = HarmonicBasis::kWorstDilution / std::sqrt(static_cast<double>(samples));
  const double worst = worst_mean * std::sqrt(2.0);
  const Index largest = r.cols();
  r_inverse = MatrixXd::Zero(largest, largest);
  VectorXd variance = VectorXd::Zero(largest);
  int order = -1;
  for (Index p = 0; p < largest; ++p) {
    r_inverse(p, p) = 1.0 / r(p, p);
    for (Index row = p - 1; row >= 0; --row)
      r_inverse(row, p) =
          -r.row(row).segment(row + 1, p - row).dot(r_inverse.col(p).segment(row + 1, p - row)) / r(row, row);
    variance.head(p + 1) += r_inverse.col(p).head(p + 1).cwiseAbs2();
    const bool whole_order = p % 2 == 0;  // cos and sin of an order come together
    if (!whole_order) continue;
    // Negated, so that a NaN from a singular triangle is refused too.
    if (!(variance[0] <= worst_mean * worst_mean) || !(variance.head(p + 1).maxCoeff() <= worst * worst))
      break;
    order = static_cast<int>(p / 2);
  }
  return order;
}

}  // namespace

HarmonicBasis::HarmonicBasis(const VectorXd& angle, int max_order) : samples_(angle.size()) {
  if (max_order < 0) throw std::invalid_argument("harmonics: max_order is negative");
  if (!angle.allFinite()) throw std::invalid_argument("harmonics: an angle is not finite");
  if (samples_ < 2) return;
  const int possible = static_cast<int>(std::min<Index>(max_order, (samples_ - 2) / 2));
  columns_ = columns_of(angle, possible);
  // Householder without pivoting: the leading columns of Q and R are those of the smaller models.
  const Eigen::HouseholderQR<MatrixXd> qr(columns_);
  MatrixXd r_inverse;
  order_ = highest_order(qr.matrixQR().topRows(columns_.cols()), samples_, r_inverse);
  const Index p = Index{2} * order_ + 1;
  columns_.conservativeResize(Eigen::NoChange, p);
  r_inverse_ = r_inverse.topLeftCorner(p, p);
  q_ = MatrixXd::Identity(samples_, p);
  q_.applyOnTheLeft(qr.householderQ());
}

VectorXd HarmonicBasis::coefficients(const VectorXd& value) const {
  if (value.size() != samples_) throw std::invalid_argument("harmonics: angles and values differ in number");
  if (order_ < 0) return {};
  const VectorXd projected = q_.transpose() * value;
  return r_inverse_.triangularView<Eigen::Upper>() * projected;
}

HarmonicFit HarmonicBasis::fit(const VectorXd& value) const {
  HarmonicFit fit;
  fit.coefficients = coefficients(value);
  if (!value.allFinite()) throw std::invalid_argument("harmonics: a value is not finite");
  if (order_ < 0) return fit;
  fit.status = FitStatus::kOk;
  fit.order = order_;
  fit.residual = value - columns_ * fit.coefficients;
  fit.residual_sd = std::sqrt(fit.residual.squaredNorm() / static_cast<double>(samples_ - columns_.cols()));
  fit.inflation = autocorrelation_inflation(fit.residual);
  const MatrixXd unit = r_inverse_ * r_inverse_.transpose();
  fit.covariance = fit.residual_sd * fit.residual_sd * fit.inflation * unit;
  return fit;
}

HarmonicFit fit_harmonics(const VectorXd& angle, const VectorXd& value, int max_order) {
  return HarmonicBasis(angle, max_order).fit(value);
}

double autocorrelation_inflation(const VectorXd& residual) {
  const double power = residual.squaredNorm();
  if (power <= 0.0) return 1.0;
  double inflation = 1.0;
  for (Index lag = 1; lag < residual.size(); ++lag) {
    const Index pairs = residual.size() - lag;
    const double correlation = residual.head(pairs).dot(residual.tail(pairs)) / power;
    if (!(correlation > 0.0)) break;
    inflation += 2.0 * correlation;
  }
  return inflation;
}

}  // namespace ballbar
