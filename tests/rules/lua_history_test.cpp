// What `history` answers, against sums written out here and figures of the literature.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>
#include <sstream>

#include "numerics/trend.hpp"
#include "rules/past_records.hpp"
#include "rules/subjects.hpp"
#include "rules/test_records.hpp"

namespace ballbar {
namespace {

using test::days;
using test::value_of;

TEST(History, LooksBackOverTheLatestWithoutThePresentOne) {
  const std::vector<Record> seven = days({1, 2, 3, 4, 100, 6, 7});
  EXPECT_EQ(value_of("history.count('ovality_um')", seven), "6 nil nil");
  EXPECT_EQ(value_of("history.last('ovality_um')", seven), "6.0 nil nil");
  EXPECT_EQ(value_of("history.last('ovality_um', 6)", seven), "1.0 nil nil");
  EXPECT_EQ(value_of("history.last('ovality_um', 7)", seven), "nil nil nil");
  EXPECT_EQ(value_of("history.mean('ovality_um', 2)", seven), "53.0 nil nil");
  EXPECT_EQ(value_of("history.median('ovality_um')", seven), "3.5 nil nil");
  EXPECT_EQ(value_of("history.spread('ovality_um', 6) / 1.482602218505602", seven), "2.0 nil nil");
  EXPECT_EQ(value_of("history.spread('ovality_um')", days({1, 2, 3, 4, 5})), "nil nil nil") << "four earlier";
  EXPECT_EQ(value_of("history.percent('ovality_um', 28)", seven), "25.0 nil nil");
}

TEST(History, SlopesAreRobustAndSayWhenTheLimitIsReached) {
  const std::vector<Record> rising = days({10, 12, 14, 160, 18, 20, 22, 24, 26, 28});  // one outlier
  EXPECT_EQ(value_of("history.slope('ovality_um')", rising).substr(0, 4), "2.0 ");
  EXPECT_EQ(value_of("history.days_until('ovality_um', 48)", rising), "10.0 nil nil");
  EXPECT_EQ(value_of("history.days_until('ovality_um', 5)", rising), "inf nil nil") << "it moves away";
  EXPECT_EQ(value_of("history.slope('ovality_um')", days({1, 2, 3, 4})), "nil nil nil");
}

TEST(History, TheoryOfSensConfidenceHoldsInNineteenOfTwentyDraws) {
  std::mt19937_64 rng(5);
  std::normal_distribution<double> noise;
  int inside = 0;
  constexpr int kDraws = 2000;
  for (int draw = 0; draw < kDraws; ++draw) {
    std::vector<double> x, y;
    for (int i = 0; i < 20; ++i) x.push_back(i), y.push_back(0.3 * i + noise(rng));
    const auto fit = theil_sen(x, y);
    if (fit && fit->low <= 0.3 && 0.3 <= fit->high) ++inside;
  }
  EXPECT_NEAR(inside, 0.95 * kDraws, 0.02 * kDraws) << "seed 5";
}

// Each from as many values as docs/rules.md says, and not before; slopes count the present one.
TEST(History, EachFigureNeedsItsStatedNumberOfResults) {
  const auto with_earlier = [](std::size_t earlier) {
    std::vector<double> values;
    for (std::size_t i = 0; i <= earlier; ++i) values.push_back(10.0 + static_cast<double>(i * i));
    return days(values);
  };
  for (const auto& [expression, from] :
       std::vector<std::pair<std::string, std::size_t>>{{"history.mean('ovality_um')", 2},
                                                        {"history.median('ovality_um')", 3},
                                                        {"history.spread('ovality_um')", 5},
                                                        {"history.last('ovality_um', 4)", 4},
                                                        {"history.slope('ovality_um')", 4},
                                                        {"history.days_until('ovality_um', 1000)", 4}}) {
    EXPECT_EQ(value_of(expression, with_earlier(from - 1)), "nil nil nil") << expression;
    EXPECT_NE(value_of(expression, with_earlier(from)).substr(0, 3), "nil") << expression;
  }
  EXPECT_EQ(value_of("history.count('ovality_um')", with_earlier(0)), "0 nil nil");
  EXPECT_EQ(value_of("history.count('ovality_um')", with_earlier(250)), "200 nil nil") << "the latest";
  EXPECT_EQ(value_of("history.percent('ovality_um', 40)", with_earlier(0)), "25.0 nil nil");
}

TEST(History, FiguresOfTheLatestAreThoseOfASortedCopy) {
  std::mt19937_64 rng(9);
  std::normal_distribution<double> noise(50.0, 4.0);
  std::vector<double> all;
  for (int i = 0; i < 41; ++i) all.push_back(noise(rng));
  const auto middle = [](std::vector<double> v) {
    std::sort(v.begin(), v.end());
    return 0.5 * (v[(v.size() - 1) / 2] + v[v.size() / 2]);
  };
  const auto number = [&](const std::string& expression) {
    return std::stod(value_of(expression, days(all)));
  };
  for (const std::size_t n : {5u, 20u, 33u}) {
    const std::vector<double> latest(all.end() - 1 - static_cast<std::ptrdiff_t>(n), all.end() - 1);
    double sum = 0.0;
    for (const double v : latest) sum += v;
    std::vector<double> away;
    for (const double v : latest) away.push_back(std::abs(v - middle(latest)));
    const std::string last = "('ovality_um', " + std::to_string(n) + ")";
    EXPECT_NEAR(number("history.mean" + last), sum / static_cast<double>(n), 1e-9) << n << ", seed 9";
    EXPECT_NEAR(number("history.median" + last), middle(latest), 1e-9) << n << ", seed 9";
    EXPECT_NEAR(number("history.spread" + last), 1.4826 * middle(away), 1e-4) << n << ", seed 9";
  }
}

// Sen (1968): of the N slopes of all pairs in their order those of rank floor((N - C) / 2), ceil((N + C) / 2)
// + 1.
TEST(History, TheSlopeAndItsIntervalAreThoseOfAllPairs) {
  std::mt19937_64 rng(10);
  std::normal_distribution<double> noise;
  std::vector<double> y;
  constexpr int kN = 12;
  for (int i = 0; i < kN; ++i) y.push_back(100.0 + 0.7 * i + noise(rng));
  std::vector<double> slopes;
  for (int i = 0; i < kN; ++i)
    for (int j = i + 1; j < kN; ++j)
      slopes.push_back((y[static_cast<std::size_t>(j)] - y[static_cast<std::size_t>(i)]) / (j - i));
  std::sort(slopes.begin(), slopes.end());  // 66 of them
  const double width = 1.96 * std::sqrt(kN * (kN - 1) * (2.0 * kN + 5.0) / 18.0);
  const auto ranked = [&](double rank) { return slopes[static_cast<std::size_t>(rank) - 1]; };
  std::istringstream said(value_of("history.slope('ovality_um')", days(y)));
  double slope = 0.0, low = 0.0, high = 0.0;
  said >> slope >> low >> high;
  EXPECT_NEAR(slope, 0.5 * (slopes[32] + slopes[33]), 1e-9) << "seed 10";
  EXPECT_NEAR(low, ranked(std::floor((66.0 - width) / 2.0)), 1e-9) << "seed 10";
  EXPECT_NEAR(high, ranked(std::ceil((66.0 + width) / 2.0) + 1.0), 1e-9) << "seed 10";
}

TEST(History, MistakesAreErrorsWithASuggestion) {
  const std::vector<Record> two = days({1, 2});
  EXPECT_EQ(value_of("history.mean('ovalty_um')", two),
            "a circle has no 'ovalty_um'; did you mean 'ovality_um'?");
  EXPECT_EQ(value_of("history.maen('ovality_um')", two),
            "blocked function: history.maen; did you mean 'mean'?");
  EXPECT_EQ(value_of("history.slope('noise_um')", two), "this circle has no 'noise_um'");
  EXPECT_EQ(value_of("history.mean('ovality_um', 1000)", two), "so many results must be from 2 to 200");
  EXPECT_EQ(value_of("history.recent[1].ovalty_um", two),
            "a circle has no 'ovalty_um'; did you mean 'ovality_um'?");
  EXPECT_EQ(test::outcome([&] {
              judge(parse_rule(test::rule_source("x", "(function() history.recent[1].ovality_um = 1 end)()")),
                    two.back(), *std::make_unique<PastRecords>(two.back(), two, std::vector<std::int64_t>{}));
            }),
            "2: the history cannot be changed");
}

TEST(Subjects, AreWhatARunTells) {
  const auto kinds = [](const Record& record) {
    std::string all;
    for (const Record& subject : subjects_of(record))
      all += subject.kind + " " + std::to_string(subject.direction) + ", ";
    return all;
  };
  EXPECT_EQ(kinds(test::circle({{"ovality_um", 1.0}})), "circle 1, ");
  Record both = test::circle(
      {{"ovality_um", 1.0}, {"gap_rms_um", 2.0}, {"positional_tolerance_um", 3.0}, {"payload_kg", 4.0}});
  EXPECT_EQ(kinds(both), "circle 1, residual 1, test 0, ");
  const std::vector<Record> subjects = subjects_of(both);
  EXPECT_EQ(subjects[1].values,
            (std::map<std::string, Estimate>{{"gap_rms_um", {2.0, {}}}, {"payload_kg", {4.0, {}}}}));
  EXPECT_EQ(subjects[2].values, (std::map<std::string, Estimate>{{"positional_tolerance_um", {3.0, {}}},
                                                                 {"payload_kg", {4.0, {}}}}));
  both.status = "failed";
  EXPECT_EQ(kinds(both), "circle 1, ");
  EXPECT_DOUBLE_EQ(silence_record("r", "A", 5 * 3600'000'000LL, 0).values.at("hours_since_last").value, 5.0);
  EXPECT_DOUBLE_EQ(silence_record("r", "A", 0, 5).values.at("hours_since_last").value, 0.0)
      << "a clock ahead";
  EXPECT_DOUBLE_EQ(loss_record("r", 0, {8, 2, 0, 0}).values.at("failed_percent").value, 25.0);
}

TEST(Subjects, ADiagnosisIsJudgedByItsFindings) {
  GapRecord gap;
  gap.robot = "r1";
  gap.verdict = "explained";
  gap.rms_before = 10e-6;
  gap.rms_after = 6e-6;
  gap.left_out = {{"joint_zero_offset", "", 3, 1, 0.6, 40.0},
                  {"joint_lost_motion", "backlash", 2, 3, 0.2, 9.0}};
  const Rule rule = parse_rule(
      {"x.lua",
       "return { name = 'x', on = 'gap', needs = { 'remainder_rms_um' }, gives = { 'at' },\n"
       "when = function(result) for _, f in ipairs(result.findings) do if f.effect_kind == 'backlash' then\n"
       "return result.verdict == 'explained', { at = f.joint } end end return false end,\n"
       "text = '{effect} of {joint}, backlash of {at}, {explained_percent} % and {remainder_rms_um} um' }"});
  const Judgement said = judge(rule, gap_record(gap), {});
  EXPECT_EQ(said.text, "joint_zero_offset of 3, backlash of 2, 64 % and 6 um");
}

}  // namespace
}  // namespace ballbar
