// The evidence is the difference of two dense densities, for every subset; the search finds the best of all.

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <cmath>
#include <map>
#include <numbers>
#include <random>

#include "numerics/evidence_cases.hpp"
#include "numerics/evidence_search.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Groups = std::vector<int>;

/// ln of the density of y under N(0, covariance), in full.
double log_density(const VectorXd& y, const MatrixXd& covariance) {
  const Eigen::LLT<MatrixXd> factor(covariance);
  const MatrixXd l = factor.matrixL();
  const VectorXd z = l.triangularView<Eigen::Lower>().solve(y);
  return -0.5 * z.squaredNorm() - l.diagonal().array().log().sum() -
         0.5 * static_cast<double>(y.size()) * std::log(2.0 * std::numbers::pi);
}

MatrixXd dense_covariance(const EvidenceCase& c, const Groups& groups, double tau) {
  const MatrixXd b = c.baseline * c.prior_sd.asDiagonal();
  MatrixXd covariance = MatrixXd::Identity(c.y.size(), c.y.size()) + b * b.transpose();
  for (const int g : groups) covariance += tau * tau * c.columns(g) * c.columns(g).transpose();
  return covariance;
}

double dense_evidence(const EvidenceCase& c, const Groups& groups, double tau) {
  return log_density(c.y, dense_covariance(c, groups, tau)) - log_density(c.y, dense_covariance(c, {}, tau));
}

std::vector<Groups> all_subsets(int groups, std::size_t most) {
  std::vector<Groups> all;
  for (unsigned bits = 0; bits < (1U << static_cast<unsigned>(groups)); ++bits) {
    Groups set;
    for (int g = 0; g < groups; ++g)
      if (bits >> static_cast<unsigned>(g) & 1U) set.push_back(g);
    if (set.size() <= most) all.push_back(set);
  }
  return all;
}

TEST(Evidence, EqualsTheDenseDensitiesForEverySubset) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    EvidenceCase c = draw_case(random, 24, static_cast<Index>(seed % 4), 6, 3.0);
    c.y += c.columns(1).rowwise().sum();
    const double tau = 0.5 + 0.25 * (seed % 8);
    const EvidenceProblem problem = c.reduced();
    for (const Groups& set : all_subsets(6, 3)) {
      const double dense = dense_evidence(c, set, tau);
      EXPECT_NEAR(log_evidence(problem, set, tau), dense, 1e-8 * (1.0 + std::abs(dense)));
    }
    const VectorXd z = dense_covariance(c, {}, tau).llt().solve(c.y);
    EXPECT_NEAR(problem.chi2, c.y.dot(z), 1e-8 * problem.chi2);
  }
}

TEST(Evidence, PosteriorIsThatOfAllParametersTogether) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    EvidenceCase c = draw_case(random, 30, 3, 4, 5.0);
    c.y += 1.5 * c.columns(2).rowwise().sum();
    const EvidencePosterior found = evidence_posterior(c.reduced(), {2, 3}, 2.0);
    const Index p = found.mean.size();
    MatrixXd both(30, 3 + p);  // normal equations of baseline and groups with both priors
    both << c.baseline, c.candidates.rightCols(p);
    MatrixXd normal = both.transpose() * both;
    normal.diagonal().head(3) += c.prior_sd.cwiseAbs2().cwiseInverse();
    normal.diagonal().tail(p).array() += 0.25;
    const MatrixXd covariance = normal.inverse();
    const VectorXd mean = covariance * (both.transpose() * c.y);
    EXPECT_LT((found.mean - mean.tail(p)).norm(), 1e-7 * mean.norm());
    EXPECT_LT((found.covariance - covariance.bottomRightCorner(p, p)).norm(), 1e-7 * covariance.norm());
  }
}

TEST(EvidenceSearch, EqualsTheEnumerationOfAllSubsets) {
  int not_empty = 0;
  for (unsigned seed = 1; seed <= 60; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    EvidenceCase c = draw_case(random, 20, 2, 7, 4.0);
    for (unsigned planted = 0; planted < seed % 4; ++planted)
      c.y += c.columns(static_cast<int>(random() % 7)).rowwise().sum();
    const EvidenceResult found = search_evidence(c.reduced(), {2.0, 3});
    Groups best;
    double best_odds = 0.0, total = 0.0;
    VectorXd inclusion = VectorXd::Zero(7);
    std::map<Groups, double> odds;
    for (const Groups& set : all_subsets(7, 3)) {
      const double o = dense_evidence(c, set, 2.0) + static_cast<double>(set.size()) * std::log(0.5 / 7);
      odds[set] = o;
      if (o > best_odds) best = set, best_odds = o;
      total += std::exp(o);
      for (const int g : set) inclusion[g] += std::exp(o);
    }
    EXPECT_EQ(found.best().groups, best);
    EXPECT_LE(found.visited, static_cast<int>(odds.size()));
    std::size_t close = 0;
    for (const auto& [set, o] : odds) close += best_odds - o < kAlternative;
    EXPECT_EQ(found.hypotheses.size(), close) << "all that come close are listed";
    for (const Hypothesis& h : found.hypotheses) {
      EXPECT_NEAR(h.log_odds, odds.at(h.groups), 1e-8 * (1.0 + std::abs(h.log_odds)));
      EXPECT_NEAR(h.probability, std::exp(h.log_odds) / total, 0.01);
    }
    EXPECT_LT((found.inclusion - inclusion / total).lpNorm<Eigen::Infinity>(), 0.01);
    not_empty += !best.empty();
  }
  EXPECT_GE(not_empty, 30);
}

}  // namespace
}  // namespace ballbar
