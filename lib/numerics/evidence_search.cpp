#include "numerics/evidence_search.hpp"

#include <Eigen/Cholesky>
#include <Eigen/Eigenvalues>
#include <Eigen/QR>
#include <algorithm>
#include <cmath>
#include <limits>
#include <map>
#include <stdexcept>
#include <utility>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Groups = std::vector<int>;

constexpr double kPriorInclusion = 0.5;  // expected number of groups, roughly

std::vector<Index> columns_of(const EvidenceProblem& problem, const Groups& groups) {
  std::vector<Index> columns;
  for (const int g : groups)
    for (Index c = problem.begin[static_cast<std::size_t>(g)];
         c < problem.begin[static_cast<std::size_t>(g) + 1]; ++c)
      columns.push_back(c);
  return columns;
}

void check(const EvidenceProblem& problem, Groups groups, double prior_sd) {
  std::sort(groups.begin(), groups.end());
  if (!groups.empty() && (groups.front() < 0 || groups.back() >= problem.groups()))
    throw std::invalid_argument("evidence: no such group");
  if (std::adjacent_find(groups.begin(), groups.end()) != groups.end())
    throw std::invalid_argument("evidence: a group twice in a set");
  if (!(prior_sd > 0.0) || !std::isfinite(prior_sd))
    throw std::invalid_argument("evidence: a prior standard deviation above zero is needed");
}

/// 1/2 |z|^2 - ln |L| of the factor L of A and z = L^-1 b.
double evidence_of(const Eigen::LLT<MatrixXd>& factor, const VectorXd& z) {
  return 0.5 * z.squaredNorm() - factor.matrixLLT().diagonal().array().log().sum();
}

/// A set whose matrix rounding has made indefinite is not chosen.
double finite(double evidence) {
  return std::isfinite(evidence) ? evidence : -std::numeric_limits<double>::infinity();
}

class Search {
 public:
  Search(const EvidenceProblem& problem, const EvidenceOptions& options)
      : problem_(problem),
        a_(options.prior_sd * options.prior_sd * problem.gram),
        b_(options.prior_sd * problem.projection),
        log_prior_(std::log(kPriorInclusion / std::max(1, problem.groups()))) {
    a_.diagonal().array() += 1.0;
    visited_.emplace(Groups{}, 0.0);
    const auto most = static_cast<std::size_t>(std::min(options.max_groups, problem.groups()));
    std::vector<Groups> beam{{}};
    for (std::size_t size = 1; size <= most; ++size) beam = next_level(beam, size);
  }

  /// Every visited set with its log evidence.
  const std::map<Groups, double>& visited() const { return visited_; }
  double log_odds(const Groups& groups, double evidence) const {
    return evidence + static_cast<double>(groups.size()) * log_prior_;
  }

 private:
  using Level = std::map<Groups, double>;

  std::vector<Groups> next_level(const std::vector<Groups>& beam, std::size_t size) {
    const bool wide = size <= 3;
    Level level;
    for (const Groups& base : beam) extend(base, level);
    for (const Groups& set : best_of(level, wide ? 4 : 1))
      for (std::size_t i = 0; i < set.size(); ++i) {
        Groups base = set;
        base.erase(base.begin() + static_cast<std::ptrdiff_t>(i));
        extend(base, level);
      }
    visited_.insert(level.begin(), level.end());
    return best_of(level, wide ? 10 : 3);
  }

  static std::vector<Groups> best_of(const Level& level, std::size_t count) {
    std::vector<std::pair<double, Groups>> order;  // a map is in sequence: equals stay so
    for (const auto& [groups, evidence] : level) order.emplace_back(evidence, groups);
    std::stable_sort(order.begin(), order.end(),
                     [](const auto& one, const auto& other) { return one.first > other.first; });
    std::vector<Groups> best;
    for (std::size_t i = 0; i < std::min(count, order.size()); ++i) best.push_back(order[i].second);
    return best;
  }

  /// The base and each one more group: the base is factored once, each group adds one small block.
  void extend(const Groups& base, Level& level) const {
    const std::vector<Index> inside = columns_of(problem_, base);
    const Eigen::LLT<MatrixXd> factor(a_(inside, inside));
    const MatrixXd cross = factor.matrixL().solve(MatrixXd(a_(inside, Eigen::all)));
    const VectorXd z = factor.matrixL().solve(VectorXd(b_(inside)));
    const double evidence = evidence_of(factor, z);
    for (int g = 0; g < problem_.groups(); ++g) {
      if (std::binary_search(base.begin(), base.end(), g)) continue;
      Groups groups = base;
      groups.insert(std::upper_bound(groups.begin(), groups.end(), g), g);
      if (level.count(groups) > 0) continue;
      const Index at = problem_.begin[static_cast<std::size_t>(g)];
      const Index width = problem_.width(g);
      const auto v = cross.middleCols(at, width);
      if (width == 1) {
        const double left = std::max(1.0, a_(at, at) - v.squaredNorm());  // A - I has no negative eigenvalue
        const double w = b_[at] - v.col(0).dot(z);
        level.emplace(std::move(groups), finite(evidence + 0.5 * w * w / left - 0.5 * std::log(left)));
        continue;
      }
      const Eigen::LLT<MatrixXd> block(a_.block(at, at, width, width) - v.transpose() * v);
      const VectorXd w = block.matrixL().solve(b_.segment(at, width) - v.transpose() * z);
      level.emplace(std::move(groups), finite(evidence + evidence_of(block, w)));
    }
  }

  const EvidenceProblem& problem_;
  MatrixXd a_;
  VectorXd b_;
  double log_prior_;
  std::map<Groups, double> visited_;
};

/// Per group: columns x rank, which makes the group's columns orthonormal. Nothing where rounding rules.
MatrixXd orthonormaliser(const EvidenceProblem& problem, int group) {
  constexpr double kRoundingOfEnergy = 1e-12, kDependent = 1e-10;
  const Index at = problem.begin[static_cast<std::size_t>(group)];
  const Index width = problem.width(group);
  const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(problem.gram.block(at, at, width, width));
  const double largest = eigen.eigenvalues()[width - 1];
  if (!(largest > kRoundingOfEnergy * problem.raw_energy.segment(at, width).sum())) return MatrixXd(width, 0);
  Index rank = 0;
  while (rank < width && eigen.eigenvalues()[width - 1 - rank] > kDependent * largest) ++rank;
  return eigen.eigenvectors().rightCols(rank) *
         eigen.eigenvalues().tail(rank).cwiseSqrt().cwiseInverse().asDiagonal();
}

}  // namespace

Index EvidenceProblem::width(int group) const {
  const auto g = static_cast<std::size_t>(group);
  return begin[g + 1] - begin[g];
}

EvidenceProblem eliminate_baseline(const VectorXd& y, const MatrixXd& baseline, const VectorXd& prior_sd,
                                   const MatrixXd& candidates, const std::vector<int>& widths) {
  const Index n = y.size(), k = baseline.cols(), p = candidates.cols();
  EvidenceProblem problem;
  problem.begin.push_back(0);
  for (const int width : widths) {
    if (width < 1) throw std::invalid_argument("evidence: a group without columns");
    problem.begin.push_back(problem.begin.back() + width);
  }
  if ((k > 0 && baseline.rows() != n) || prior_sd.size() != k || (p > 0 && candidates.rows() != n) ||
      problem.begin.back() != p)
    throw std::invalid_argument("evidence: rows, priors or groups differ in number");
  if (!y.allFinite() || !baseline.allFinite() || !prior_sd.allFinite() || !candidates.allFinite() ||
      (prior_sd.array() < 0.0).any())
    throw std::invalid_argument("evidence: a value is not finite, or a prior is negative");

  MatrixXd left(n + k, p + 1);  // candidates and y; the lower rows meet the prior's in the factorisation
  left.topLeftCorner(n, p) = candidates;
  left.topRightCorner(n, 1) = y;
  left.bottomRows(k).setZero();
  problem.raw_energy = left.leftCols(p).colwise().squaredNorm();
  if (k > 0) {
    MatrixXd stacked(n + k, k);
    stacked.topRows(n) = baseline * prior_sd.asDiagonal();
    stacked.bottomRows(k).setIdentity();
    // Q'(X over 0) without its first k rows has the Gram matrix X'X - (U'X)'(U'X), but as a sum of squares:
    // it keeps its digits where the baseline takes nearly all, and never has a negative eigenvalue.
    const Eigen::HouseholderQR<MatrixXd> qr(stacked);
    left.applyOnTheLeft(qr.householderQ().adjoint());
  }
  const auto rest = left.bottomRows(n);
  MatrixXd gram = MatrixXd::Zero(p + 1, p + 1);
  gram.selfadjointView<Eigen::Lower>().rankUpdate(rest.transpose());
  gram.triangularView<Eigen::StrictlyUpper>() = gram.transpose();
  problem.gram = gram.topLeftCorner(p, p);
  problem.projection = gram.topRightCorner(p, 1);
  problem.chi2 = gram(p, p);
  return problem;
}

double log_evidence(const EvidenceProblem& problem, const Groups& groups, double prior_sd) {
  check(problem, groups, prior_sd);
  const std::vector<Index> columns = columns_of(problem, groups);
  MatrixXd a = prior_sd * prior_sd * problem.gram(columns, columns);
  a.diagonal().array() += 1.0;
  const Eigen::LLT<MatrixXd> factor(a);
  return evidence_of(factor, factor.matrixL().solve(VectorXd(prior_sd * problem.projection(columns))));
}

EvidencePosterior evidence_posterior(const EvidenceProblem& problem, const Groups& groups, double prior_sd) {
  check(problem, groups, prior_sd);
  const std::vector<Index> columns = columns_of(problem, groups);
  const auto p = static_cast<Index>(columns.size());
  MatrixXd a = prior_sd * prior_sd * problem.gram(columns, columns);
  a.diagonal().array() += 1.0;
  EvidencePosterior posterior;
  posterior.covariance = prior_sd * prior_sd * a.llt().solve(MatrixXd::Identity(p, p));
  posterior.mean = posterior.covariance * problem.projection(columns);
  return posterior;
}

EvidenceResult search_evidence(const EvidenceProblem& problem, const EvidenceOptions& options) {
  check(problem, {}, options.prior_sd);
  if (options.max_groups < 0) throw std::invalid_argument("evidence: a negative number of groups");
  const Search search(problem, options);
  EvidenceResult result;
  result.visited = static_cast<int>(search.visited().size());
  double best = 0.0;
  for (const auto& [groups, evidence] : search.visited())
    best = std::max(best, search.log_odds(groups, evidence));
  result.inclusion = VectorXd::Zero(problem.groups());
  double total = 0.0;
  for (const auto& [groups, evidence] : search.visited()) {
    const double log_odds = search.log_odds(groups, evidence);
    const double weight = std::exp(log_odds - best);
    total += weight;
    for (const int g : groups) result.inclusion[g] += weight;
    if (best - log_odds < kAlternative) result.hypotheses.push_back({groups, evidence, log_odds, weight});
  }
  result.inclusion /= total;
  for (Hypothesis& h : result.hypotheses) h.probability /= total;
  std::stable_sort(
      result.hypotheses.begin(), result.hypotheses.end(),
      [](const Hypothesis& one, const Hypothesis& other) { return one.log_odds > other.log_odds; });
  result.posterior = evidence_posterior(problem, result.best().groups, options.prior_sd);
  return result;
}

MatrixXd resemblance(const EvidenceProblem& problem) {
  const int count = problem.groups();
  std::vector<MatrixXd> unit;
  unit.reserve(static_cast<std::size_t>(count));
  for (int g = 0; g < count; ++g) unit.push_back(orthonormaliser(problem, g));
  MatrixXd alike = MatrixXd::Identity(count, count);
  for (int g = 0; g < count; ++g)
    for (int h = 0; h < g; ++h) {
      const MatrixXd& one = unit[static_cast<std::size_t>(g)];
      const MatrixXd& other = unit[static_cast<std::size_t>(h)];
      if (one.cols() == 0 || other.cols() == 0) continue;
      const auto cross =
          problem.gram.block(problem.begin[static_cast<std::size_t>(g)],
                             problem.begin[static_cast<std::size_t>(h)], one.rows(), other.rows());
      const MatrixXd both = one.transpose() * cross * other;
      const Eigen::SelfAdjointEigenSolver<MatrixXd> eigen(
          both.rows() < both.cols() ? MatrixXd(both * both.transpose()) : MatrixXd(both.transpose() * both),
          Eigen::EigenvaluesOnly);
      const double largest = eigen.eigenvalues()[eigen.eigenvalues().size() - 1];
      alike(g, h) = alike(h, g) = std::sqrt(std::clamp(largest, 0.0, 1.0));
    }
  return alike;
}

std::vector<std::vector<int>> not_told_apart(const MatrixXd& resemblance) {
  std::vector<std::vector<int>> twins(static_cast<std::size_t>(resemblance.rows()));
  for (Index g = 0; g < resemblance.rows(); ++g)
    for (Index h = 0; h < resemblance.cols(); ++h)
      if (g != h && resemblance(g, h) > kNotToldApart)
        twins[static_cast<std::size_t>(g)].push_back(static_cast<int>(h));
  return twins;
}

}  // namespace ballbar
