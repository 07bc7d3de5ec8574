// What `history` says of a result against the baseline, against sums written out here.

#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <random>
#include <sstream>

#include "rules/test_records.hpp"

namespace ballbar {
namespace {

using test::days;
using test::value_of;

/// The numbers of a text; nil is NaN.
std::array<double, 3> numbers(const std::string& text) {
  std::array<double, 3> found{};
  std::istringstream words(text);
  std::string word;
  for (double& number : found) number = words >> word && word != "nil" ? std::stod(word) : std::nan("");
  return found;
}

TEST(Baseline, ChartsCompareWithTheBaseline) {
  // Baseline 9, 11: mean 10, sd sqrt(2). Since then 12, 14, and now 13.
  const std::vector<Record> five = days({9, 11, 12, 14, 13});
  const std::string two = "baseline_runs = 2,\n";
  EXPECT_EQ(value_of("history.baseline('ovality_um')", five, two), "10.0 1.4142135623731 2.0");
  const double sd = std::sqrt(2.0);
  double up = 0.0;
  for (const double v : {12.0, 14.0, 13.0}) up = std::max(0.0, up + (v - 10.0) / sd - 0.5);
  EXPECT_NEAR(std::stod(value_of("history.cusum('ovality_um', 0.5)", five, two)), up, 1e-12);
  double level = 10.0;
  for (const double v : {12.0, 14.0, 13.0}) level = 0.2 * v + 0.8 * level;
  EXPECT_NEAR(std::stod(value_of("history.ewma('ovality_um')", five, two)), level, 1e-12);
  EXPECT_EQ(value_of("history.cusum('ovality_um')", five, "baseline_runs = 5,\n"), "nil nil nil")
      << "the baseline is not complete";
  EXPECT_EQ(value_of("history.cusum('ovality_um')", days({5, 5, 5, 9}), two), "nil nil nil")
      << "a baseline without scatter knows no standard deviation";
}

TEST(Baseline, NothingIsSaidUntilItIsComplete) {
  const auto after = [](std::size_t earlier) {
    std::vector<Record> records = days(std::vector<double>(earlier + 1, 0.0));
    for (std::size_t i = 0; i < records.size(); ++i) {
      records[i].values["ovality_um"] = {10.0 + static_cast<double>(i % 3), {}};
      records[i].values["ovality_cos_um"] = {static_cast<double>(i % 3), {}};
      records[i].values["ovality_sin_um"] = {static_cast<double>(i % 2), {}};
    }
    return records;
  };
  for (const char* expression :
       {"history.baseline('ovality_um')", "history.ewma('ovality_um')", "history.cusum('ovality_um')",
        "history.distance('ovality')", "history.vector_cusum('ovality')"}) {
    EXPECT_EQ(value_of(expression, after(9)), "nil nil nil") << expression << ": ten unless the rule says";
    EXPECT_NE(value_of(expression, after(10)).substr(0, 3), "nil") << expression;
    EXPECT_EQ(value_of(expression, after(16), "baseline_runs = 17,\n"), "nil nil nil") << expression;
    EXPECT_NE(value_of(expression, after(17), "baseline_runs = 17,\n").substr(0, 3), "nil") << expression;
  }
}

// Ten runs of 9 and 11 in turn: mean 10, variance 10/9. Then a drift, upwards and back below.
TEST(Baseline, ChartsAreThoseOfRobertsAndPage) {
  std::vector<double> all{9, 11, 9, 11, 9, 11, 9, 11, 9, 11};
  const std::vector<double> since{10.5, 13, 14, 12, 8, 6, 5};
  all.insert(all.end(), since.begin(), since.end());
  const double sd = std::sqrt(10.0 / 9.0);
  for (const double k : {1.5, 0.25}) {
    double up = 0.0, down = 0.0;
    for (const double v : since) {
      up = std::max(0.0, up + (v - 10.0) / sd - k);
      down = std::max(0.0, down - (v - 10.0) / sd - k);
    }
    const std::string with = k == 1.5 ? ")" : ", 0.25)";
    const auto said = numbers(value_of("history.cusum('ovality_um'" + with, days(all)));
    EXPECT_NEAR(said[0], up, 1e-9) << k;
    EXPECT_NEAR(said[1], down, 1e-9) << k;
    EXPECT_GT(down, 0.0);
  }
  for (const double w : {0.2, 0.7}) {
    // The level is a weighted sum of all, so its variance is that of the weights, squared.
    double level = 0.0, squares = 0.0, rest = 1.0;
    for (std::size_t i = since.size(); i-- > 0; rest *= 1.0 - w) {
      level += w * rest * since[i];
      squares += w * w * rest * rest;
    }
    level += rest * 10.0;
    const std::string with = w == 0.2 ? ")" : ", 0.7)";
    const auto said = numbers(value_of("history.ewma('ovality_um'" + with, days(all)));
    EXPECT_NEAR(said[0], level, 1e-9) << w;
    EXPECT_NEAR(said[1], (level - 10.0) / (sd * std::sqrt(squares)), 1e-9) << w;
  }
}

TEST(Baseline, DistanceOfAVectorIsThatOfMahalanobis) {
  std::vector<Record> records;
  const std::vector<std::pair<double, double>> tips{{2, 0}, {-2, 0}, {0, 1}, {0, -1}, {0, 0}, {4, 1.5}};
  for (const auto& [x, y] : tips) {
    records.push_back(
        test::circle({{"ovality_um", std::hypot(x, y)}, {"ovality_cos_um", x}, {"ovality_sin_um", y}}));
    records.back().started_us = static_cast<std::int64_t>(records.size()) * test::kRecordDayUs;
  }
  // Covariance of the first five: diag(8, 2) / 4.
  const std::string said = value_of("history.distance('ovality')", records, "baseline_runs = 5,\n");
  EXPECT_NEAR(std::stod(said), std::sqrt(16.0 / 2.0 + 2.25 / 0.5), 1e-9) << said;
  const double length = std::sqrt(16.0 / 2.0 + 2.25 / 0.5) - 1.5;
  EXPECT_NEAR(std::stod(value_of("history.vector_cusum('ovality')", records, "baseline_runs = 5,\n")), length,
              1e-9);
  EXPECT_EQ(value_of("history.distance('noise')", records),
            "'noise' is no vector of a circle: \"ovality\", \"harmonic3\", \"gap_harmonic2\" ...");
}

/// Five tips with covariance diag(2, 0.5), mean 0; then others.
std::vector<Record> tips(const std::vector<std::pair<double, double>>& since) {
  std::vector<std::pair<double, double>> all{{2, 0}, {-2, 0}, {0, 1}, {0, -1}, {0, 0}};
  all.insert(all.end(), since.begin(), since.end());
  std::vector<Record> records;
  for (const auto& [x, y] : all) {
    records.push_back(
        test::circle({{"ovality_um", std::hypot(x, y)}, {"ovality_cos_um", x}, {"ovality_sin_um", y}}));
    records.back().started_us = static_cast<std::int64_t>(records.size()) * test::kRecordDayUs;
  }
  return records;
}

// F of 2 and d degrees of freedom is above f with the chance (1 + 2 f / d)^(-d / 2).
TEST(Baseline, TheChanceOfADistanceIsThatOfHotelling) {
  const auto one = numbers(value_of("history.distance('ovality')", tips({{4, 1.5}}), "baseline_runs = 5,\n"));
  const double squared = 16.0 / 2.0 + 2.25 / 0.5;
  const double t2 = squared * 5.0 / 6.0;
  EXPECT_NEAR(one[1], std::pow(1.0 + t2 / 4.0, -1.5), 1e-9);
  EXPECT_NEAR(one[2], std::hypot(4.0, 1.5), 1e-9) << "um";
  // Two of them, (3, 1) and (5, 1): mean (4, 1), their own scatter adds 2 to the sum of squares of x.
  const auto two =
      numbers(value_of("history.distance('ovality', 2)", tips({{3, 1}, {5, 1}}), "baseline_runs = 5,\n"));
  const double pooled = 16.0 / ((8.0 + 2.0) / 5.0) + 1.0 / (2.0 / 5.0);
  EXPECT_NEAR(two[0], std::sqrt(pooled), 1e-9);
  EXPECT_NEAR(two[1], std::pow(1.0 + pooled * 10.0 / 7.0 / 5.0, -2.0), 1e-9);
  EXPECT_NEAR(two[2], std::hypot(4.0, 1.0), 1e-9);
  EXPECT_EQ(value_of("history.distance('ovality', 2)", tips({{3, 1}}), "baseline_runs = 5,\n"), "nil nil nil")
      << "two since the baseline are not there yet";
}

TEST(Baseline, TheSumOfAVectorIsThatOfCrosier) {
  const std::vector<std::pair<double, double>> since{{1, 0.2}, {3, 1}, {2, -0.5}, {-6, 0.1}, {4, 2}};
  for (const double k : {1.5, 0.5}) {
    double x = 0.0, y = 0.0;
    for (const auto& [dx, dy] : since) {
      x += dx;
      y += dy;
      const double length = std::sqrt(x * x / 2.0 + y * y / 0.5);
      const double left = length <= k ? 0.0 : 1.0 - k / length;
      x *= left;
      y *= left;
    }
    const std::string with = k == 1.5 ? ")" : ", 0.5)";
    EXPECT_NEAR(
        numbers(value_of("history.vector_cusum('ovality'" + with, tips(since), "baseline_runs = 5,\n"))[0],
        std::sqrt(x * x / 2.0 + y * y / 0.5), 1e-9)
        << k;
  }
}

TEST(Baseline, IsWhatTheRuleSays) {
  std::vector<Record> six = days({1, 3, 11, 13, 21, 23, 50});
  for (std::size_t i = 2; i < 4; ++i) six[i].series = "second";
  const auto mean_of = [&](const std::string& which, const std::vector<std::int64_t>& marks_us = {}) {
    return numbers(value_of("history.baseline('ovality_um')", six,
                            "baseline_runs = 2, baseline = '" + which + "',\n", marks_us))[0];
  };
  EXPECT_EQ(mean_of("series"), 2.0);
  EXPECT_EQ(mean_of("series second"), 12.0);
  EXPECT_EQ(mean_of("first"), 2.0);
  EXPECT_EQ(mean_of("calibration"), 2.0) << "where there was none";
  EXPECT_EQ(mean_of("calibration", {2 * test::kRecordDayUs + 1}), 12.0);
  EXPECT_EQ(mean_of("calibration", {2 * test::kRecordDayUs + 1, 5 * test::kRecordDayUs}), 22.0);
  EXPECT_TRUE(std::isnan(mean_of("calibration", {6 * test::kRecordDayUs}))) << "one run since then";
}

}  // namespace
}  // namespace ballbar
