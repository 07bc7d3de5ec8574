#include "numerics/interpolate.hpp"

#include <algorithm>
#include <limits>
#include <stdexcept>

namespace ballbar {
namespace {

using Eigen::Index;

/// The polynomial through samples [first, last), four at most, at t.
void lagrange(const Eigen::VectorXd& x, const Eigen::MatrixXd& values, Index first, Index last, double t,
              Eigen::Ref<Eigen::VectorXd> sum) {
  sum.setZero();
  for (Index i = first; i < last; ++i) {
    double weight = 1.0;
    for (Index j = first; j < last; ++j)
      if (j != i) weight *= (t - x[j]) / (x[i] - x[j]);
    sum += weight * values.col(i);
  }
}

/// The first index from which x is not less than t, beginning at a guess: times mostly rise.
Index first_not_less(const Eigen::VectorXd& x, double t, Index guess) {
  constexpr Index kSteps = 8;
  for (Index i = std::max<Index>(guess, 1), end = std::min(x.size(), i + kSteps); i < end; ++i)
    if (x[i - 1] < t && t <= x[i]) return i;
  return std::lower_bound(x.begin(), x.end(), t) - x.begin();
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
  Index after = 0;
  for (Index k = 0; k < at.size(); ++k) {
    const double t = at[k];
    if (n == 0 || !(t >= x[0]) || !(t <= x[n - 1])) continue;
    after = first_not_less(x, t, after);
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
    lagrange(x, values, first, last, t, result.col(k));
  }
  return result;
}

}  // namespace ballbar
