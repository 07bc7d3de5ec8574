#include "numerics/change_point.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Scatter about the least-squares combination of columns.
MatrixXd scatter(const MatrixXd& vectors, const MatrixXd& columns) {
  const MatrixXd normal = columns.transpose() * columns;
  const MatrixXd left = vectors - columns * normal.ldlt().solve(columns.transpose() * vectors);
  return left.transpose() * left;
}

/// ln of the determinant; nothing where the vectors do not scatter in all components.
std::optional<double> log_determinant(const MatrixXd& scatter) {
  const Eigen::LLT<MatrixXd> root(scatter);
  if (root.info() != Eigen::Success) return std::nullopt;
  const VectorXd diagonal = MatrixXd(root.matrixL()).diagonal();
  if (!(diagonal.minCoeff() > 0.0)) return std::nullopt;
  return 2.0 * diagonal.array().log().sum();
}

/// Step at `first_after`.
MatrixXd step_columns(Index n, Index first_after) {
  MatrixXd columns = MatrixXd::Zero(n, 2);
  columns.col(0).head(first_after).setOnes();
  columns.col(1).tail(n - first_after).setOnes();
  return columns;
}

/// P(T^2 >= t2), p components, nu degrees of freedom: 1 / (1 + T^2 / nu) is Beta((nu - p + 1) / 2, p / 2).
double p_value(double t2, Index components, Index dof) {
  return incomplete_beta(static_cast<double>(dof) / (static_cast<double>(dof) + t2),
                         static_cast<double>(dof - components + 1) / 2.0,
                         static_cast<double>(components) / 2.0);
}

void split(const MatrixXd& vectors, Index begin, Index end, double alpha, double level,
           std::vector<ChangePoint>& found) {
  const Index p = std::min(vectors.cols(), components_for(end - begin));
  if (p < 1) return;
  std::optional<ChangePoint> change = most_likely_change(vectors.block(begin, 0, end - begin, p), level);
  if (!change || !(change->p_value < alpha)) return;
  change->first_after += begin;
  change->earliest += begin;
  change->latest += begin;
  change->step = vectors.middleRows(change->first_after, end - change->first_after).colwise().mean() -
                 vectors.middleRows(begin, change->first_after - begin).colwise().mean();
  split(vectors, begin, change->first_after, alpha, level, found);
  const Index place = change->first_after;
  found.push_back(std::move(*change));
  split(vectors, place, end, alpha, level, found);
}

}  // namespace

double incomplete_beta(double x, double a, double b) {
  if (!(x >= 0.0 && x <= 1.0 && a > 0.0 && b > 0.0))
    throw std::invalid_argument("incomplete beta: x outside 0 .. 1, or a, b not above zero");
  if (x == 0.0 || x == 1.0) return x;
  if (x > (a + 1.0) / (a + b + 2.0)) return 1.0 - incomplete_beta(1.0 - x, b, a);
  constexpr double kTiny = 1e-300;
  const auto away = [](double v) { return std::abs(v) < kTiny ? kTiny : v; };
  double c = 1.0, d = 1.0 / away(1.0 - (a + b) * x / (a + 1.0)), f = d;
  for (int m = 1; m < 500; ++m) {
    const double even = m * (b - m) * x / ((a + 2.0 * m - 1.0) * (a + 2.0 * m));
    d = 1.0 / away(1.0 + even * d);
    c = away(1.0 + even / c);
    f *= c * d;
    const double odd = -(a + m) * (a + b + m) * x / ((a + 2.0 * m) * (a + 2.0 * m + 1.0));
    d = 1.0 / away(1.0 + odd * d);
    c = away(1.0 + odd / c);
    f *= c * d;
    if (std::abs(c * d - 1.0) < 1e-15) break;
  }
  const double front =
      a * std::log(x) + b * std::log1p(-x) + std::lgamma(a + b) - std::lgamma(a) - std::lgamma(b);
  return std::exp(front) * f / a;
}

Index components_for(Index vectors) { return std::max<Index>(0, (vectors - 2) / 3); }

std::optional<ChangePoint> most_likely_change(const MatrixXd& vectors, double level) {
  const Index n = vectors.rows(), p = vectors.cols();
  if (!(level > 0.0 && level < 1.0)) throw std::invalid_argument("change: a level between 0 and 1");
  if (!vectors.allFinite()) throw std::invalid_argument("change: a value that is not finite");
  if (p < 1 || n < 2 * kLeastSide + p) return std::nullopt;
  const Index dof = n - 2;
  const double half = static_cast<double>(dof) / 2.0;
  ChangePoint change;
  VectorXd likelihood = VectorXd::Constant(n, -std::numeric_limits<double>::infinity());
  double best_scatter = 0.0;
  change.t2 = -1.0;
  for (Index k = kLeastSide; k + kLeastSide <= n; ++k) {
    const MatrixXd within = scatter(vectors, step_columns(n, k));
    const std::optional<double> size = log_determinant(within);
    if (!size) return std::nullopt;
    const auto before = static_cast<double>(k), after = static_cast<double>(n - k);
    likelihood[k] = -0.5 * static_cast<double>(p) * std::log(before * after) - half * *size;
    const VectorXd step = vectors.bottomRows(n - k).colwise().mean() - vectors.topRows(k).colwise().mean();
    const double t2 = before * after / static_cast<double>(n) * static_cast<double>(dof) *
                      step.dot(within.llt().solve(step));
    if (t2 <= change.t2) continue;
    change.t2 = t2;
    change.first_after = k;
    change.step = step;
    best_scatter = *size;
  }
  const auto places = static_cast<double>(n - 2 * kLeastSide + 1);
  change.p_value = std::min(1.0, places * p_value(change.t2, p, dof));

  VectorXd posterior = (likelihood.array() - likelihood.maxCoeff()).exp();
  posterior /= posterior.sum();
  std::vector<Index> places_by_odds;
  for (Index k = kLeastSide; k + kLeastSide <= n; ++k) places_by_odds.push_back(k);
  std::stable_sort(places_by_odds.begin(), places_by_odds.end(),
                   [&](Index a, Index b) { return posterior[a] > posterior[b]; });
  change.earliest = change.latest = change.first_after;
  double held = 0.0;
  for (const Index k : places_by_odds) {
    change.earliest = std::min(change.earliest, k);
    change.latest = std::max(change.latest, k);
    if ((held += posterior[k]) >= level) break;
  }

  MatrixXd slope(n, 2);
  slope.col(0).setOnes();
  slope.col(1) = VectorXd::LinSpaced(n, -1.0, 1.0);
  const std::optional<double> even = log_determinant(scatter(vectors, slope));
  change.gradual = even && *even < best_scatter;
  return change;
}

std::vector<ChangePoint> changes(const MatrixXd& vectors, double alpha, double level) {
  std::vector<ChangePoint> found;
  split(vectors, 0, vectors.rows(), alpha, level, found);
  return found;
}

}  // namespace ballbar
