// What was planted is named, what was not is not, and what cannot be told apart is said to be so.

#include "numerics/evidence_search.hpp"

#include <gtest/gtest.h>

#include <Eigen/Dense>
#include <algorithm>
#include <cmath>
#include <numeric>
#include <random>

#include "numerics/evidence_cases.hpp"

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;
using Groups = std::vector<int>;

Groups named(const EvidenceCase& c) { return search_evidence(c.reduced()).best().groups; }

TEST(EvidenceSearch, NamesWhatWasPlanted) {
  const int cases = 300;
  int exact = 0, missed = 0, planted_groups = 0;
  for (unsigned seed = 1; seed <= cases; ++seed) {
    std::mt19937_64 random(seed);
    EvidenceCase c = draw_case(random, 150, 5, 30, 20.0);
    Groups planted;
    while (planted.size() < 1 + seed % 4) {
      const int g = static_cast<int>(random() % 30);
      if (std::find(planted.begin(), planted.end(), g) != planted.end()) continue;
      planted.push_back(g);
      const double size = 0.5 + 0.1 * static_cast<double>(random() % 10);  // 10 to 28 of the noise
      c.y += (random() % 2 ? size : -size) * c.columns(g).rowwise().sum();
    }
    std::sort(planted.begin(), planted.end());
    const Groups found = named(c);
    exact += found == planted;
    planted_groups += static_cast<int>(planted.size());
    for (const int g : planted) missed += !std::binary_search(found.begin(), found.end(), g);
  }
  EXPECT_EQ(missed, 0) << "of " << planted_groups << ", seeds 1 to 300";
  EXPECT_GE(exact, 291) << "of 300, seeds 1 to 300";
}

TEST(EvidenceSearch, FindsNineGroupsAtOnce) {
  for (unsigned seed = 1; seed <= 20; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    EvidenceCase c = draw_case(random, 200, 4, 25, 30.0);
    for (int g = 0; g < 18; g += 2) c.y += c.columns(g).rowwise().sum();
    EXPECT_EQ(named(c), (Groups{0, 2, 4, 6, 8, 10, 12, 14, 16}));
  }
}

TEST(EvidenceSearch, NamesNothingWhereNothingIs) {
  const int cases = 400;
  int false_names = 0;
  for (unsigned seed = 1; seed <= cases; ++seed) {
    std::mt19937_64 random(seed);
    const EvidenceCase c = draw_case(random, 150, 5, 30, 20.0);
    false_names += !named(c).empty();
  }
  // A single column of norm 20 needs |z| > ~3.8, so 30 of them some 0.3 %: 1 in 400. Poisson: 6 is 4 sigma.
  EXPECT_LE(false_names, 6) << "of 400, seeds 1 to 400";
}

TEST(EvidenceSearch, FindsWhatCalibratingFirstWouldHaveSwallowed) {
  // The candidate is the baseline's column but for a hundredth: fitted first, the baseline takes all of it.
  for (unsigned seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    EvidenceCase c = draw_case(random, 150, 4, 10, 20.0);
    const VectorXd own = 20.0 * normal_matrix(random, 150, 1).normalized();
    c.candidates.col(c.begin(3)) = 3.0 * c.baseline.col(1) + own;
    EXPECT_GT(c.baseline.col(1).normalized().dot(c.candidates.col(c.begin(3)).normalized()), 0.99);
    c.y += c.candidates.col(c.begin(3));
    const EvidenceResult joint = search_evidence(c.reduced());
    EXPECT_EQ(joint.best().groups, (Groups{3}));
    EXPECT_NEAR(joint.posterior.mean[0], 1.0, 4.5 * std::sqrt(joint.posterior.covariance(0, 0)));

    EvidenceCase first = c;
    first.y -= c.baseline * c.baseline.householderQr().solve(c.y);
    first.baseline.resize(150, 0);
    first.prior_sd.resize(0);
    const EvidencePosterior after = evidence_posterior(first.reduced(), {3}, 2.0);
    EXPECT_LT(std::abs(after.mean[0]), 0.05) << "swallowed";
  }
}

TEST(EvidenceSearch, ReportsTwinsAsAClass) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    EvidenceCase c = draw_case(random, 150, 4, 12, 20.0);
    // 4 and 9 differ by the baseline alone, and a hair; 2 and 6 look alike only before the baseline.
    c.widths = Groups(12, 1);
    c.candidates.conservativeResize(Eigen::NoChange, 12);
    const VectorXd hair = normal_matrix(random, 150, 1).normalized();
    c.candidates.col(9) = 1.3 * c.candidates.col(4) + 0.2 * c.baseline.col(2) + 0.01 * hair;
    c.prior_sd[0] = 1e4;  // free: within its prior the baseline can be any of what they share
    const VectorXd big = 1000.0 * c.baseline.col(0);
    c.candidates.col(2) += big;
    c.candidates.col(6) += big;
    EXPECT_GT(c.candidates.col(2).normalized().dot(c.candidates.col(6).normalized()), 0.999);
    c.y += c.candidates.col(4);

    const EvidenceProblem problem = c.reduced();
    const auto twins = not_told_apart(resemblance(problem));
    for (int g = 0; g < 12; ++g) {
      const auto& found = twins[static_cast<std::size_t>(g)];
      EXPECT_EQ(found, g == 4 ? Groups{9} : g == 9 ? Groups{4} : Groups{}) << g;
    }
    const EvidenceResult result = search_evidence(problem);
    ASSERT_EQ(result.best().groups.size(), 1U);
    const auto listed = [&](int g) {
      return std::any_of(result.hypotheses.begin(), result.hypotheses.end(),
                         [&](const Hypothesis& h) { return h.groups == Groups{g}; });
    };
    EXPECT_TRUE(listed(4) && listed(9));
    EXPECT_NEAR(result.inclusion[4] + result.inclusion[9], 1.0, 0.05);
    EXPECT_NEAR(result.inclusion[4], 0.5, 0.2) << "neither is favoured but by its prior's width";
  }
}

TEST(EvidenceSearch, ComparesGroupsOfSeveralColumnsByTheirFirstCanonicalCorrelation) {
  std::mt19937_64 random(1);
  SCOPED_TRACE("seed 1");
  const MatrixXd x = 10.0 * normal_matrix(random, 500, 4);
  EvidenceCase c;
  c.y = VectorXd::Zero(500);
  c.baseline.resize(500, 0);
  c.widths = {2, 1, 2, 1, 2};
  c.candidates.resize(500, 8);
  // 0: x0, x1. 1: a mixture of them. 2: the same plane in other columns. 3: half in, half out. 4: apart.
  c.candidates << x.col(0), x.col(1), x.col(0) - 3 * x.col(1), x.col(0) + x.col(1), x.col(0) - 0.9 * x.col(1),
      x.col(0) + x.col(2), x.col(2), x.col(3);
  const MatrixXd alike = resemblance(c.reduced());
  EXPECT_NEAR(alike(0, 1), 1.0, 1e-9);
  EXPECT_NEAR(alike(0, 2), 1.0, 1e-9);
  EXPECT_NEAR(alike(0, 3), std::sqrt(0.5), 0.1);
  EXPECT_NEAR(alike(0, 4), 0.0, 0.15);
  EXPECT_EQ(alike, MatrixXd(alike.transpose()));
  EXPECT_EQ(not_told_apart(alike)[0], (Groups{1, 2}));
}

TEST(EvidenceSearch, SwapsOutADecoyThatCameFirst) {
  // Four planted groups, and twenty others that each look a little like their sum: without swaps the search
  // ends below the truth in several of these cases.
  for (unsigned seed = 1; seed <= 100; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    EvidenceCase c = draw_case(random, 60, 2, 24, 1.0);
    c.widths = Groups(24, 1);
    c.candidates = 60.0 * normal_matrix(random, 60, 24).colwise().normalized();
    const VectorXd sum = c.candidates.leftCols(4).rowwise().sum();
    for (Index g = 4; g < 24; ++g)
      c.candidates.col(g) = 0.7 * c.candidates.col(g) + 0.15 * sum + 0.15 * c.candidates.col(g % 4);
    c.y += sum;
    const EvidenceProblem problem = c.reduced();
    const double truth = log_evidence(problem, {0, 1, 2, 3}, 2.0) + 4 * std::log(0.5 / 24);
    EXPECT_GE(search_evidence(problem).best().log_odds, truth - 1e-6);
  }
}

TEST(EvidenceSearch, FindsNothingAlikeInWhatTheBaselineTakesWhole) {
  std::mt19937_64 random(4);
  SCOPED_TRACE("seed 4");
  EvidenceCase c = draw_case(random, 80, 2, 3, 20.0);
  c.widths = Groups(3, 1);
  c.candidates.conservativeResize(Eigen::NoChange, 3);
  c.prior_sd[0] = 1e8;
  c.candidates.col(0) = c.baseline.col(0);
  c.candidates.col(1) = -2.0 * c.baseline.col(0);
  const EvidenceProblem problem = c.reduced();
  EXPECT_LT(problem.gram(0, 0), 1e-12 * problem.raw_energy[0]);
  EXPECT_EQ(resemblance(problem).topRows(2).sum(), 2.0) << "each is like itself only";
  EXPECT_TRUE(search_evidence(problem).best().groups.empty());
}

TEST(EvidenceSearch, DoesNotCareForTheOrderOfTheGroups) {
  for (unsigned seed = 1; seed <= 40; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 random(seed);
    EvidenceCase c = draw_case(random, 100, 3, 20, 8.0);
    for (int g = 0; g < 3; ++g) c.y += 0.6 * c.columns(5 * g + 2).rowwise().sum();
    Groups order(20);
    std::iota(order.begin(), order.end(), 0);
    std::shuffle(order.begin(), order.end(), random);
    EvidenceCase other = c;
    Index at = 0;
    for (std::size_t i = 0; i < order.size(); ++i) {
      other.widths[i] = c.widths[static_cast<std::size_t>(order[i])];
      other.candidates.middleCols(at, other.widths[i]) = c.columns(order[i]);
      at += other.widths[i];
    }
    const EvidenceResult one = search_evidence(c.reduced()), two = search_evidence(other.reduced());
    ASSERT_EQ(one.hypotheses.size(), two.hypotheses.size());
    Groups back;
    for (const int g : two.best().groups) back.push_back(order[static_cast<std::size_t>(g)]);
    std::sort(back.begin(), back.end());
    EXPECT_EQ(back, one.best().groups);
    EXPECT_NEAR(one.best().log_odds, two.best().log_odds, 1e-8 * (1.0 + one.best().log_odds));
    for (int g = 0; g < 20; ++g)
      EXPECT_NEAR(two.inclusion[g], one.inclusion[order[static_cast<std::size_t>(g)]], 1e-7);
  }
}

TEST(EvidenceSearch, BearsNullDirectionsAndHugeColumns) {
  for (const double huge : {1.0, 1e3, 1e6, 1e9}) {
    SCOPED_TRACE("seed 5, factor " + std::to_string(huge));
    std::mt19937_64 random(5);
    EvidenceCase c = draw_case(random, 120, 4, 11, 20.0);
    c.widths = Groups(10, 1);
    c.widths[8] = 2;
    c.candidates.conservativeResize(Eigen::NoChange, 11);
    c.baseline.conservativeResize(Eigen::NoChange, 5);
    c.prior_sd.conservativeResize(5);
    c.baseline.col(4) = c.baseline.col(2);  // the baseline knows only a sum
    c.prior_sd[4] = 1.0;
    c.candidates.col(0).setZero();                                     // nothing
    c.candidates.col(1) = huge * c.baseline.col(0);                    // the baseline itself
    c.candidates.col(3) = c.candidates.col(2);                         // a copy
    c.candidates.col(5) = huge * c.candidates.col(4);                  // a larger copy
    c.candidates.col(9) = c.candidates.col(8);                         // a copy inside a group
    c.candidates.col(10) = c.candidates.col(6) + c.candidates.col(7);  // a sum
    c.y += c.candidates.col(2) + c.candidates.col(6);
    const EvidenceProblem problem = c.reduced();
    const EvidenceResult result = search_evidence(problem);
    for (const Hypothesis& h : result.hypotheses) EXPECT_TRUE(std::isfinite(h.log_odds));
    EXPECT_TRUE(result.inclusion.allFinite());
    EXPECT_LE(result.inclusion.maxCoeff(), 1.0 + 1e-12);
    EXPECT_TRUE(result.posterior.mean.allFinite() && result.posterior.covariance.allFinite());
    EXPECT_EQ(result.best().groups, (Groups{2, 6})) << "of two equals the lower number";
    const MatrixXd alike = resemblance(problem);
    EXPECT_TRUE(alike.allFinite());
    EXPECT_EQ(alike.row(0).sum(), 1.0) << "nothing resembles nothing";
    const auto twins = not_told_apart(alike);
    EXPECT_EQ(twins[2], Groups{3});
    EXPECT_EQ(twins[4], Groups{5});
    Groups all(10);
    std::iota(all.begin(), all.end(), 0);
    EXPECT_TRUE(std::isfinite(log_evidence(problem, all, 2.0)));
  }
}

TEST(EvidenceSearch, SaysSoWhereThereIsNothingToSearch) {
  std::mt19937_64 random(3);
  EvidenceCase c = draw_case(random, 10, 2, 3, 5.0);
  EvidenceCase none = c;
  none.widths.clear();
  none.candidates.resize(10, 0);
  const EvidenceResult result = search_evidence(none.reduced());
  EXPECT_TRUE(result.best().groups.empty());
  EXPECT_EQ(result.best().probability, 1.0);
  EXPECT_EQ(result.posterior.mean.size(), 0);
  EXPECT_EQ(search_evidence(c.reduced(), {2.0, 0}).visited, 1);

  const EvidenceProblem problem = c.reduced();
  EXPECT_THROW(log_evidence(problem, {0, 0}, 2.0), std::invalid_argument);
  EXPECT_THROW(log_evidence(problem, {3}, 2.0), std::invalid_argument);
  EXPECT_THROW(search_evidence(problem, {0.0, 3}), std::invalid_argument);
  EXPECT_THROW(search_evidence(problem, {2.0, -1}), std::invalid_argument);
  EvidenceCase bad = c;
  bad.widths.push_back(1);
  EXPECT_THROW(bad.reduced(), std::invalid_argument);
  bad = c;
  bad.y[3] = std::nan("");
  EXPECT_THROW(bad.reduced(), std::invalid_argument);
  bad = c;
  bad.prior_sd[0] = -1.0;
  EXPECT_THROW(bad.reduced(), std::invalid_argument);
  bad = c;
  bad.y.conservativeResize(9);
  EXPECT_THROW(bad.reduced(), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
