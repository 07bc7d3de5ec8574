// Changes of known place and size in vectors of a generator of its own; a Monte Carlo of nothing; closed
// forms.

#include "numerics/change_point.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

/// Correlated normal vectors whose mean goes over by `shift` standard deviations at `first_after`.
MatrixXd drawn(std::mt19937& random, Index n, Index p, Index first_after, double shift) {
  std::normal_distribution<double> normal;
  MatrixXd mix = MatrixXd::NullaryExpr(p, p, [&] { return normal(random); });
  mix += 2.0 * MatrixXd::Identity(p, p);
  VectorXd direction = VectorXd::NullaryExpr(p, [&] { return normal(random); });
  direction.normalize();
  MatrixXd rows(n, p);
  for (Index i = 0; i < n; ++i) {
    VectorXd z = VectorXd::NullaryExpr(p, [&] { return normal(random); });
    if (i >= first_after) z += shift * direction;
    rows.row(i) = (mix * z).transpose();
  }
  return rows;
}

TEST(IncompleteBeta, AgreesWithSumsOfBinomials) {
  // I_x(a, n - a + 1) is the chance of at least a successes in n draws of chance x.
  for (const double x : {0.01, 0.2, 0.5, 0.77, 0.999}) {
    constexpr int kDraws = 12;
    for (int a = 1; a <= kDraws; ++a) {
      double sum = 0.0;
      for (int k = a; k <= kDraws; ++k)
        sum += std::exp(std::lgamma(kDraws + 1.0) - std::lgamma(k + 1.0) - std::lgamma(kDraws - k + 1.0)) *
               std::pow(x, k) * std::pow(1.0 - x, kDraws - k);
      EXPECT_NEAR(incomplete_beta(x, a, kDraws - a + 1.0), sum, 1e-12) << x << " " << a;
    }
  }
  EXPECT_NEAR(incomplete_beta(0.3, 0.5, 0.5), 2.0 / std::acos(-1.0) * std::asin(std::sqrt(0.3)), 1e-13);
  EXPECT_THROW(incomplete_beta(1.1, 1.0, 1.0), std::invalid_argument);
}

TEST(ChangePoint, IsFoundWhereItIs) {
  std::mt19937 random(1);
  SCOPED_TRACE("seed 1");
  const std::optional<ChangePoint> change = most_likely_change(drawn(random, 30, 4, 17, 12.0));
  ASSERT_TRUE(change);
  EXPECT_EQ(change->first_after, 17);
  EXPECT_EQ(change->earliest, 17);
  EXPECT_EQ(change->latest, 17);
  EXPECT_LT(change->p_value, 1e-6);
  EXPECT_FALSE(change->gradual);
}

TEST(ChangePoint, OfTwoComponentsHasTheTSquaredOfTheBook) {
  // Worked by hand: means (0, 0) and (2, 0), scatter within diag(4, 4), nu = 6: T^2 = 4*4/8 * 6 * 4/8... in
  // units of S = W / 6.
  MatrixXd rows(8, 2);
  rows << 1, 0, -1, 0, 0, 1, 0, -1, 11, 0, 9, 0, 10, 1, 10, -1;
  const std::optional<ChangePoint> change = most_likely_change(rows);
  ASSERT_TRUE(change);
  EXPECT_EQ(change->first_after, 4);
  EXPECT_NEAR(change->t2, 2.0 * 100.0 / (4.0 / 6.0), 1e-9);
  EXPECT_NEAR(change->p_value, 5.0 * std::pow(1.0 + change->t2 / 6.0, -2.5), 1e-12) << "closed for p = 2";
  EXPECT_NEAR(change->step[0], 10.0, 1e-12);
}

TEST(ChangePoint, AnEvenDriftIsSaidToBeGradual) {
  std::mt19937 random(2);
  MatrixXd rows = drawn(random, 40, 3, 40, 0.0);
  for (Index i = 0; i < 40; ++i) rows.row(i).array() += 0.5 * static_cast<double>(i);
  const std::optional<ChangePoint> change = most_likely_change(rows);
  ASSERT_TRUE(change);
  EXPECT_TRUE(change->gradual);
}

TEST(ChangePoint, OfTooFewVectorsIsNotLookedFor) {
  std::mt19937 random(3);
  EXPECT_FALSE(most_likely_change(drawn(random, 6, 4, 3, 10.0)));
  EXPECT_FALSE(most_likely_change(MatrixXd::Ones(20, 2))) << "nothing scatters";
  EXPECT_TRUE(changes(drawn(random, 4, 8, 2, 10.0)).empty());
  MatrixXd bad = drawn(random, 20, 2, 9, 3.0);
  bad(3, 1) = std::nan("");
  EXPECT_THROW(most_likely_change(bad), std::invalid_argument);
  EXPECT_THROW(most_likely_change(drawn(random, 20, 2, 9, 3.0), 1.0), std::invalid_argument);
}

TEST(ChangePoint, SeveralAreFoundInSequence) {
  std::mt19937 random(4);
  MatrixXd rows = drawn(random, 60, 3, 60, 0.0);
  rows.middleRows(20, 40).col(0).array() += 40.0;
  rows.middleRows(45, 15).col(1).array() -= 60.0;
  const std::vector<ChangePoint> found = changes(rows);
  ASSERT_EQ(found.size(), 2u);
  EXPECT_EQ(found[0].first_after, 20);
  EXPECT_EQ(found[1].first_after, 45);
}

/// Share of draws in which something is found, and of those in which the range holds the place.
struct Shares {
  double found = 0.0, covered = 0.0, length = 0.0;
};

Shares shares(unsigned seed, int draws, Index n, Index p, double shift, bool changes_at_all) {
  std::mt19937 random(seed);
  Shares shares;
  for (int i = 0; i < draws; ++i) {
    std::uniform_int_distribution<Index> place(kLeastSide, n - kLeastSide);
    const Index at = changes_at_all ? place(random) : n;
    const std::optional<ChangePoint> change = most_likely_change(drawn(random, n, p, at, shift));
    if (!change) continue;
    if (!(change->p_value < 0.01)) continue;
    shares.found += 1.0;
    shares.covered += change->earliest <= at && at <= change->latest;
    shares.length += static_cast<double>(change->latest - change->earliest + 1);
  }
  shares.covered /= std::max(1.0, shares.found);
  shares.length /= std::max(1.0, shares.found);
  shares.found /= draws;
  return shares;
}

TEST(ChangePoint, RangesHoldThePlaceAndNothingIsRarelyFoundInNothing) {
  constexpr unsigned kSeed = 77;
  SCOPED_TRACE("seed 77");
  const Shares weak = shares(kSeed, 400, 24, 4, 3.0, true), strong = shares(kSeed, 400, 24, 4, 5.0, true);
  EXPECT_GT(weak.covered, 0.93);
  EXPECT_GT(strong.covered, 0.93);
  EXPECT_GT(strong.found, 0.9);
  EXPECT_LT(strong.length, 3.0);
  EXPECT_GT(weak.length, strong.length) << "what is weak is not placed as well";
  EXPECT_LT(shares(kSeed, 400, 24, 4, 0.0, false).found, 0.02) << "asked for is 0.01 at most";
}

// scripts/proof since
TEST(DISABLED_Long, CoverageOfTheRange) {
  for (const Index n : {12, 24, 48, 96})
    for (const double shift : {1.5, 2.5, 4.0, 8.0}) {
      const Index p = std::min<Index>(components_for(n), 18);
      const Shares with = shares(1000 + static_cast<unsigned>(n), 2000, n, p, shift, true);
      const Shares without = shares(2000 + static_cast<unsigned>(n), 2000, n, p, 0.0, false);
      std::printf(
          "runs %3d, components %2d, change %.1f sd: range holds %.3f, runs in it %.1f, found %.3f; nothing: "
          "%.4f\n",
          static_cast<int>(n), static_cast<int>(p), shift, with.covered, with.length, with.found,
          without.found);
      // Of smaller ones only those are found that chance has made large, and moved.
      if (shift >= 4.0) {
        EXPECT_GT(with.covered, 0.95);
      }
      EXPECT_LE(without.found, 0.0125);
    }
}

}  // namespace
}  // namespace ballbar
