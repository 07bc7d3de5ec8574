#include "numerics/whitening.hpp"

#include <algorithm>
#include <cmath>
#include <complex>
#include <numbers>
#include <stdexcept>
#include <unsupported/Eigen/FFT>
#include <vector>

namespace ballbar {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

namespace {

/// Means of so many neighbours, which leave a share of each frequency.
struct Blocks {
  VectorXd x, y;
  double width = 0.0;  ///< of the arc; 0: single values
};

Blocks averaged(const VectorXd& x, const VectorXd& y, Index size) {
  if (size < 2) return {x, y, 0.0};
  const Index n = x.size() / size;
  Blocks blocks{VectorXd(n), VectorXd(n), 0.0};
  for (Index b = 0; b < n; ++b) {
    const Index count = b + 1 == n ? x.size() - b * size : size;
    blocks.x[b] = x.segment(b * size, count).mean();
    blocks.y[b] = y.segment(b * size, count).mean();
  }
  blocks.width = static_cast<double>(size) * (x[x.size() - 1] - x[0]) / static_cast<double>(x.size() - 1);
  return blocks;
}

/// Share of the arc that each place stands for.
VectorXd shares(const VectorXd& x) {
  const Index n = x.size();
  VectorXd share(n);
  for (Index i = 0; i < n; ++i) {
    const double from = i == 0 ? 0.0 : (x[i - 1] + x[i]) / 2.0;
    const double to = i + 1 == n ? 1.0 : (x[i] + x[i + 1]) / 2.0;
    share[i] = to - from;
  }
  return share;
}

}  // namespace

/// J. Makhoul, IEEE Trans. ASSP 28 (1980) 27-34: even places forwards, odd ones backwards, one FFT.
struct CosineTransform::Tables {
  Eigen::FFT<double> fft;                  ///< with its plan made
  std::vector<std::complex<double>> turn;  ///< of each coefficient
};

CosineTransform::CosineTransform(Index samples, double turns, double max_frequency)
    : samples_(samples), turns_(turns) {
  if (samples < 1 || !std::isfinite(turns) || !(turns > 0.0) || !(max_frequency >= 0.0))
    throw std::invalid_argument("transform: no samples, no turn or a negative frequency");
  // The rounding of turns must not cost the last one.
  const auto highest = static_cast<Index>(
      std::min(static_cast<double>(samples - 1), std::floor(2.0 * max_frequency * turns * (1 + 1e-9))));
  frequency_ = VectorXd::LinSpaced(highest + 1, 0.0, 0.5 * static_cast<double>(highest) / turns);
  if (samples == 1) return;
  const auto tables = std::make_shared<Tables>();
  for (Index k = 0; k <= highest; ++k)
    tables->turn.push_back(
        std::polar(std::sqrt((k == 0 ? 1.0 : 2.0) / static_cast<double>(samples)),
                   -std::numbers::pi * static_cast<double>(k) / (2.0 * static_cast<double>(samples))));
  const std::vector<std::complex<double>> nothing(static_cast<std::size_t>(samples));
  std::vector<std::complex<double>> spectrum;
  tables->fft.fwd(spectrum, nothing);
  tables_ = tables;
}

VectorXd CosineTransform::inverse(const VectorXd& coefficients) const {
  if (coefficients.size() != frequency_.size())
    throw std::invalid_argument("transform: another number of coefficients");
  const auto n = static_cast<double>(samples_);
  VectorXd values(samples_);
  for (Index i = 0; i < samples_; ++i) {
    // cos(k x) by its recurrence in k.
    const double x = std::numbers::pi * (static_cast<double>(i) + 0.5) / n, twice = 2.0 * std::cos(x);
    double before = std::cos(x), now = 1.0, sum = coefficients[0] / std::sqrt(2.0);
    for (Index k = 1; k < coefficients.size(); ++k) {
      const double next = twice * now - before;
      before = now;
      now = next;
      sum += coefficients[k] * now;
    }
    values[i] = std::sqrt(2.0 / n) * sum;
  }
  return values;
}

MatrixXd CosineTransform::operator()(const MatrixXd& values) const {
  if (values.rows() != samples_) throw std::invalid_argument("transform: another number of samples");
  const Index n = samples_, rows = frequency_.size();
  MatrixXd coefficients(rows, values.cols());
  if (n == 1) return values;
  Eigen::FFT<double> fft = tables_->fft;
  const auto turn = [&](Index k) { return tables_->turn[static_cast<std::size_t>(k)]; };
  std::vector<std::complex<double>> folded(static_cast<std::size_t>(n)), spectrum;
  const auto at = [&](Index k) { return spectrum[static_cast<std::size_t>(k)]; };
  for (Index column = 0; column < values.cols();) {
    // Two real records at once, as real and imaginary part; what is not finite stays with its own.
    const bool two = column + 1 < values.cols() && values.middleCols(column, 2).allFinite();
    const auto value = [&](Index i) {
      return std::complex<double>(values(i, column), two ? values(i, column + 1) : 0.0);
    };
    for (Index i = 0; 2 * i < n; ++i) folded[static_cast<std::size_t>(i)] = value(2 * i);
    for (Index i = 0; 2 * i + 1 < n; ++i) folded[static_cast<std::size_t>(n - 1 - i)] = value(2 * i + 1);
    fft.fwd(spectrum, folded);
    if (!two) {
      for (Index k = 0; k < rows; ++k) coefficients(k, column) = (turn(k) * at(k)).real();
      ++column;
      continue;
    }
    for (Index k = 0; k < rows; ++k) {
      const std::complex<double> here = at(k), mirrored = std::conj(at(k == 0 ? 0 : n - k));
      coefficients(k, column) = 0.5 * (turn(k) * (here + mirrored)).real();
      coefficients(k, column + 1) = 0.5 * (turn(k) * (here - mirrored)).imag();
    }
    column += 2;
  }
  return coefficients;
}

VectorXd CosineTransform::fit(const VectorXd& x, const VectorXd& values) const {
  constexpr int kSteps = 3;
  const Index count = frequency_.size();
  const auto enough = static_cast<Index>(std::ceil(kValuesPerCoefficient * static_cast<double>(count)));
  if (x.size() != values.size() || x.size() < std::max<Index>(enough, 2))
    throw std::invalid_argument("transform: too few values");
  if (!x.allFinite() || !values.allFinite() || !(x.minCoeff() >= 0.0) || !(x.maxCoeff() <= 1.0))
    throw std::invalid_argument("transform: places outside the arc");
  for (Index i = 1; i < x.size(); ++i)
    if (!(x[i] > x[i - 1])) throw std::invalid_argument("transform: places must rise");
  const Blocks blocks = averaged(x, values, x.size() / enough);
  const VectorXd share = shares(blocks.x);
  const VectorXd cosine = 2.0 * (std::numbers::pi * blocks.x.array()).cos();

  VectorXd c = VectorXd::Zero(count);
  VectorXd left = blocks.y;
  VectorXd before(left.size()), now(left.size()), next(left.size()), sum(left.size());
  for (int step = 0; step < kSteps; ++step) {
    const VectorXd weighed = share.cwiseProduct(left);
    sum.setZero();
    before = (std::numbers::pi * blocks.x.array()).cos();  // cos(-1 pi x)
    now.setOnes();
    for (Index k = 0; k < count; ++k) {
      const double more = (k == 0 ? 1.0 : 2.0) * weighed.dot(now);
      c[k] += more;
      if (step + 1 < kSteps) sum += more * now;
      next = cosine.cwiseProduct(now) - before;  // cos((k + 1) pi x)
      before.swap(now);
      now.swap(next);
    }
    left -= sum;
  }
  for (Index k = 0; k < count; ++k) {
    const double half = std::numbers::pi * frequency_[k] * turns_ * blocks.width;
    const double kept = half > 0.0 ? std::sin(half) / half : 1.0;
    c[k] *= std::sqrt(static_cast<double>(samples_) / (k == 0 ? 1.0 : 2.0)) / kept;
  }
  return c;
}

MatrixXd whiten(const CosineTransform& transform, const MatrixXd& values, const VectorXd& variance) {
  if (variance.size() != transform.frequency().size() || !variance.allFinite() ||
      !(variance.minCoeff() > 0.0))
    throw std::invalid_argument("whitening: a variance above zero for every coefficient is needed");
  return variance.cwiseSqrt().cwiseInverse().asDiagonal() * transform(values);
}

}  // namespace ballbar
