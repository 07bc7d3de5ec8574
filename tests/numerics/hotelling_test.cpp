#include "numerics/hotelling.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <limits>
#include <random>
#include <vector>

namespace ballbar {
namespace {

using Eigen::Matrix2d;
using Eigen::Vector2d;
using Vectors = std::vector<Vector2d>;

/// T^2 the long way: no matrix, no Eigen algebra.
double t2_by_loops(const Vectors& series, const Vectors& baseline) {
  const auto mean = [](const Vectors& all, int k) {
    double sum = 0.0;
    for (const Vector2d& v : all) sum += v[k];
    return sum / static_cast<double>(all.size());
  };
  double xx = 0.0, yy = 0.0, xy = 0.0;
  for (const Vectors* all : {&series, &baseline})
    for (const Vector2d& v : *all) {
      const double dx = v[0] - mean(*all, 0), dy = v[1] - mean(*all, 1);
      xx += dx * dx, yy += dy * dy, xy += dx * dy;
    }
  const double n1 = static_cast<double>(series.size()), n2 = static_cast<double>(baseline.size());
  const double nu = n1 + n2 - 2;
  const double dx = mean(series, 0) - mean(baseline, 0), dy = mean(series, 1) - mean(baseline, 1);
  const double det = (xx * yy - xy * xy) / (nu * nu);
  return n1 * n2 / (n1 + n2) * (dx * dx * yy / nu - 2 * dx * dy * xy / nu + dy * dy * xx / nu) / det;
}

/// Correlated and of unequal spread, as harmonics are.
Vectors draw(std::mt19937& random, int count, const Vector2d& centre = Vector2d::Zero()) {
  std::normal_distribution<double> normal;
  Vectors all;
  for (int i = 0; i < count; ++i) {
    const double u = normal(random), w = normal(random);
    all.push_back(centre + Vector2d(2.0 * u + 0.3 * w, 0.8 * u + 0.5 * w));
  }
  return all;
}

TEST(Hotelling, HasTheFiguresThatOneCanDoByHand) {
  // Deviations from the mean (2, 3): (-2, -2) (1, 1) (0, -2) (1, 3); sums of products 6, 8, 18;
  // determinant 44.
  const Vectors four{{0, 1}, {3, 4}, {2, 1}, {3, 6}};
  const VectorSample sample = sample_of(four);
  EXPECT_NEAR((sample.mean - Vector2d(2, 3)).norm(), 0.0, 1e-15);
  Matrix2d scatter;
  scatter << 6, 8, 8, 18;
  EXPECT_NEAR((*sample.covariance * 3 - scatter).norm(), 0.0, 1e-14);
  EXPECT_NEAR((*sample.covariance_of_mean() * 12 - scatter).norm(), 0.0, 1e-14);
  const auto test = hotelling_one_sample(four, Vector2d::Zero());
  ASSERT_TRUE(test);
  EXPECT_EQ(test->dof, 3);
  EXPECT_NEAR(test->t2, 12.0 * (4 * 18 - 2 * 6 * 8 + 9 * 6) / 44.0, 1e-12);
}

TEST(Hotelling, EqualsPlainLoopsForTwoSamplesOfAnySize) {
  for (unsigned seed = 1; seed <= 50; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const Vectors series = draw(random, 1 + static_cast<int>(seed % 6), {0.5, -1.0});
    const Vectors baseline = draw(random, 4 + static_cast<int>(seed % 7));
    const auto test = hotelling_two_sample(series, baseline);
    ASSERT_TRUE(test);
    EXPECT_NEAR(test->t2, t2_by_loops(series, baseline), 1e-9 * (1.0 + test->t2));
    EXPECT_EQ(test->dof, static_cast<int>(series.size() + baseline.size()) - 2);
    EXPECT_NEAR(hotelling_two_sample(baseline, series)->t2, test->t2, 1e-9 * (1.0 + test->t2));
  }
}

TEST(Hotelling, HasTheLimitsOfTheTablesOfF) {
  // F(2, m) at 5 % and 1 %, from any table of F; T^2 = 2 nu / (nu - 1) F with m = nu - 1.
  struct Row {
    int m;
    double five, one;
  };
  for (const Row& row : {Row{2, 19.00, 99.00}, Row{3, 9.552, 30.82}, Row{4, 6.944, 18.00},
                         Row{5, 5.786, 13.27}, Row{8, 4.459, 8.649}, Row{10, 4.103, 7.559},
                         Row{20, 3.493, 5.849}, Row{60, 3.150, 4.977}, Row{120, 3.072, 4.787}}) {
    const int nu = row.m + 1;
    const double to_f = (nu - 1) / (2.0 * nu);
    EXPECT_NEAR(t2_limit(0.05, nu) * to_f, row.five, 0.0006) << row.m;
    EXPECT_NEAR(t2_limit(0.01, nu) * to_f, row.one, 0.006) << row.m;
    EXPECT_NEAR(t2_p_value(t2_limit(0.05, nu), nu), 0.05, 1e-12);
  }
  EXPECT_DOUBLE_EQ(t2_p_value(0.0, 5), 1.0);
}

TEST(Hotelling, HasThePValueOfTheDensityOfFIntegrated) {
  for (const int nu : {3, 4, 8, 18})
    for (const double t2 : {0.5, 3.0, 9.0}) {
      const double m = nu - 1, f = t2 * m / (2.0 * nu);
      // Density of F(2, m): (1 + 2 x / m)^-((m + 2) / 2), from the gamma functions of the general one.
      const double scale =
          std::exp(std::lgamma((2 + m) / 2) - std::lgamma(1.0) - std::lgamma(m / 2)) * (2 / m);
      double below = 0.0;
      const int steps = 20000;
      for (int i = 0; i < steps; ++i) {
        const double x = f * (i + 0.5) / steps;
        below += scale * std::pow(1 + 2 * x / m, -(2 + m) / 2) * f / steps;
      }
      EXPECT_NEAR(t2_p_value(t2, nu), 1.0 - below, 1e-7) << nu << " " << t2;
    }
}

TEST(Hotelling, AgreesWithAllPermutationsOfTheLabels) {
  // Which share of the ways to call 5 of 10 vectors "series" gives a T^2 as large: 252 ways, no theory.
  int compared = 0;
  for (unsigned seed = 1; seed <= 12; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937 random(seed);
    const Vectors series = draw(random, 5, {0.3 * seed, 0.0}), baseline = draw(random, 5);
    Vectors all = series;
    all.insert(all.end(), baseline.begin(), baseline.end());
    const auto test = hotelling_two_sample(series, baseline);
    std::vector<int> label{0, 0, 0, 0, 0, 1, 1, 1, 1, 1};
    int as_large = 0, ways = 0;
    do {
      Vectors one, other;
      for (std::size_t i = 0; i < all.size(); ++i) (label[i] == 0 ? one : other).push_back(all[i]);
      as_large += t2_by_loops(one, other) >= test->t2 * (1 - 1e-12);
      ++ways;
    } while (std::next_permutation(label.begin(), label.end()));
    ASSERT_EQ(ways, 252);
    const double exact = static_cast<double>(as_large) / ways;
    EXPECT_NEAR(test->p_value, exact, 0.02 + 0.35 * exact);
    compared += exact > 0.02 && exact < 0.98;
  }
  EXPECT_GE(compared, 5) << "most of the cases must lie where the p-value says something";
}

TEST(Hotelling, RaisesAFalseAlarmAsOftenAsItSays) {
  const int cases = 2000;
  struct Kind {
    int series, baseline;
  };
  for (const Kind& kind : {Kind{5, 5}, Kind{1, 10}, Kind{3, 20}}) {
    int alarms = 0, one_sample = 0;
    for (unsigned seed = 1; seed <= cases; ++seed) {
      std::mt19937 random(seed);
      const Vectors series = draw(random, kind.series), baseline = draw(random, kind.baseline);
      alarms += hotelling_two_sample(series, baseline)->p_value < 0.05;
      one_sample += hotelling_one_sample(baseline, Vector2d::Zero())->p_value < 0.05;
    }
    // 100 expected; binomial standard deviation 9.7, four of them.
    EXPECT_NEAR(alarms, 100, 39) << kind.series << " against " << kind.baseline;
    EXPECT_NEAR(one_sample, 100, 39) << kind.baseline;
  }
}

TEST(Hotelling, SeesATurnOfTheVectorThatItsLengthDoesNotShow) {
  std::mt19937 random(7);
  std::normal_distribution<double> normal(0.0, 0.2);
  Vectors before, after;
  for (int i = 0; i < 5; ++i) {
    before.emplace_back(174 + normal(random), -63 + normal(random));
    after.emplace_back(-63 + normal(random), 174 + normal(random));  // the same length
  }
  EXPECT_NEAR(sample_of(before).mean.norm(), sample_of(after).mean.norm(), 1.0);
  EXPECT_LT(hotelling_two_sample(after, before)->p_value, 1e-9);
}

TEST(Hotelling, SaysSoWhereNothingCanBeSaid) {
  const Vectors one{{1, 2}}, two{{1, 2}, {2, 2}}, flat{{0, 0}, {1, 2}, {2, 4}, {3, 6}}, none;
  EXPECT_FALSE(sample_of(one).covariance);
  EXPECT_FALSE(sample_of(one).covariance_of_mean());
  EXPECT_FALSE(hotelling_one_sample(two, Vector2d::Zero())) << "one degree of freedom cannot fill a plane";
  EXPECT_FALSE(hotelling_one_sample(flat, Vector2d(9, 0))) << "scatter in one direction only";
  EXPECT_FALSE(hotelling_one_sample(none, Vector2d::Zero()));
  EXPECT_FALSE(hotelling_two_sample(one, two));
  EXPECT_FALSE(hotelling_two_sample(none, flat));
  EXPECT_THROW(sample_of(none), std::invalid_argument);
  EXPECT_THROW(sample_of(Vectors{{std::nan(""), 0}}), std::invalid_argument);
  EXPECT_THROW(t2_limit(0.0, 5), std::invalid_argument);
  EXPECT_THROW(t2_p_value(-1.0, 5), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
