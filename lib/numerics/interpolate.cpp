#include "numerics/interpolate.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace ballbar {
namespace {

using Eigen::Index;

/// The polynomial through samples [first, last) at t.
Eigen::VectorXd lagrange(const Eigen::VectorXd& x, const Eigen::MatrixXd& values, Index first, Index last,
                         double t) {
  Eigen::VectorXd sum = Eigen::VectorXd::Zero(values.rows());
  for (Index i = first; i < last; ++i) {
    double weight = 1.0;
    for (Index j = first; j < last; ++j)
      if (j != i) weight *= (t - x[j]) / (x[i] - x[j]);
    sum += weight * values.col(i);
  }
  return sum;
}

}  // namespace

Eigen::MatrixXd interpolate(const Eigen::VectorXd& x, const Eigen::MatrixXd& values,
                            const Eigen::VectorXd& at, double widest, Interpolation kind) {
  const Index points = kind == Interpolation::kLinear ? 2 : 4;
  const Index n = x.size();
  if (values.cols() != n) throw std::invalid_argument("interpolate: one column of values per abscissa");
  for (Index i = 1; i < n; ++i)
    if (!(x[i] > x[i - 1])) throw std::invalid_argument("interpolate: the abscissae do not rise");
  Eigen::MatrixXd result =
      Eigen::MatrixXd::Constant(values.rows(), at.size(), std::numeric_limits<double>::quiet_NaN());
  for (Index k = 0; k < at.size(); ++k) {
    const double t = at[k];
    if (n == 0 || !(t >= x[0]) || !(t <= x[n - 1])) continue;
    const Index after = std::lower_bound(x.begin(), x.end(), t) - x.begin();
    if (x[after] == t) {
      result.col(k) = values.col(after);
      continue;
    }
    if (x[after] - x[after - 1] > widest) continue;
    Index first = after - 1;  // grown on both sides, but not across a hole
    Index last = after + 1;
    const auto joined = [&](Index i) { return i > 0 && i < n && x[i] - x[i - 1] <= widest; };
    if (last - first < points && joined(last)) ++last;
    while (last - first < points && joined(first)) --first;
    while (last - first < points && joined(last)) ++last;
    result.col(k) = lagrange(x, values, first, last, t);
  }
  return result;
}

}  // namespace ballbar
