// What `history` answers, against sums written out here and figures of the literature.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <random>

#include "numerics/trend.hpp"
#include "rules/past_records.hpp"
#include "rules/subjects.hpp"
#include "rules/test_records.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kDayUs = 86'400'000'000;

// Circles a day apart with these ovalities; the last one is being judged.
std::vector<Record> days(const std::vector<double>& ovality_um) {
  std::vector<Record> records;
  for (std::size_t i = 0; i < ovality_um.size(); ++i) {
    records.push_back(test::circle({{"ovality_um", ovality_um[i]}}));
    records.back().started_us = static_cast<std::int64_t>(i + 1) * kDayUs;
  }
  return records;
}

// What an expression of a rule comes to, as text.
std::string value_of(const std::string& expression, std::vector<Record> records,
                     const std::string& more = "") {
  const Rule rule = parse_rule(
      test::rule_source("x",
                        "(function() local a, b, c = " + expression +
                            " error(tostring(a) .. ' ' .. tostring(b) .. ' ' .. tostring(c), 0) end)()",
                        more));
  const Record now = records.back();
  PastRecords past(now, records, {});
  const std::string said = test::outcome([&] { judge(rule, now, past); });
  return said.substr(said.find(' ') + 1);
}

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

TEST(History, ChartsCompareWithTheBaseline) {
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

TEST(History, DistanceOfAVectorIsThatOfMahalanobis) {
  std::vector<Record> records;
  const std::vector<std::pair<double, double>> tips{{2, 0}, {-2, 0}, {0, 1}, {0, -1}, {0, 0}, {4, 1.5}};
  for (const auto& [x, y] : tips) {
    records.push_back(
        test::circle({{"ovality_um", std::hypot(x, y)}, {"ovality_cos_um", x}, {"ovality_sin_um", y}}));
    records.back().started_us = static_cast<std::int64_t>(records.size()) * kDayUs;
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
