// Two years of circles, made here from nothing but normal noise and a stated change, through the shipped
// rules. What a change is worth is known, so it is known when an alarm is late, early or false.
// `scripts/proof rules` runs the long ones.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>
#include <random>

#include "rules/rule_files.hpp"
#include "rules/rule_set.hpp"
#include "rules/subjects.hpp"
#include "rules/test_records.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kFourHoursUs = 14'400'000'000;
constexpr int kTwoYears = 4380;  // runs, six a day
constexpr double kSdUm = 0.5;    // of each figure from run to run

/// What one circle shows, as the change has made it; in standard deviations from the healthy machine.
struct Change {
  double cos_sd = 0.0, sin_sd = 0.0;  // of the ovality vector
  double hysteresis_sd = 0.0, gap_sd = 0.0;
  double payload_kg = 3.0;
};

Record circle_of(int run, const Change& change, std::mt19937_64& rng) {
  std::normal_distribution<double> noise(0.0, kSdUm);
  const double x = 60.0 + change.cos_sd * kSdUm + noise(rng);
  const double y = change.sin_sd * kSdUm + noise(rng);
  Record record = test::circle({{"ovality_cos_um", x},
                                {"ovality_sin_um", y},
                                {"ovality_um", std::hypot(x, y)},
                                {"eccentricity_um", 30.0 + noise(rng)},
                                {"eccentricity_x_um", 30.0},
                                {"eccentricity_y_um", 0.0},
                                {"circular_error_um", 300.0 + noise(rng)},
                                {"noise_um", 0.6 + 0.1 * noise(rng)},
                                {"positional_tolerance_um", 80.0 + noise(rng)},
                                {"hysteresis_um", 12.0 + change.hysteresis_sd * kSdUm + noise(rng)},
                                {"gap_rms_um", 9.0 + change.gap_sd * kSdUm + noise(rng)},
                                {"payload_kg", change.payload_kg}});
  record.started_us = (run + 1) * kFourHoursUs;
  record.source = "bar";
  return record;
}

/// All that was measured, however long ago; only the windows are shown.
class LongPast : public Past {
 public:
  void add(const Record& record) {
    shown_.erase("recent");
    for (auto& [which, columns] : columns_) columns.clear();
    labels_.push_back(record);
    labels_.back().values.clear();
    for (const auto& [name, estimate] : record.values) values_[name].push_back(estimate.value);
  }
  const std::vector<Record>& window(const std::string& which) override {
    std::vector<Record>& shown = shown_[which];
    const auto [begin, end] = range(which);
    if (shown.size() != end - begin)
      shown.assign(labels_.begin() + static_cast<std::ptrdiff_t>(begin),
                   labels_.begin() + static_cast<std::ptrdiff_t>(end));
    return shown;
  }
  const std::vector<double>& column(const std::string& which, const std::string& name) override {
    const auto [begin, end] = range(which);
    const std::vector<double>& all = values_[name];
    std::vector<double>& column = columns_[which][name];
    if (!column.empty()) return column;
    column.assign(all.begin() + static_cast<std::ptrdiff_t>(begin),
                  all.begin() + static_cast<std::ptrdiff_t>(end));
    return column;
  }

 private:
  std::pair<std::size_t, std::size_t> range(const std::string& which) const {
    const std::size_t size = labels_.size();
    if (which == "recent") return {size - std::min(size, kPastRecent), size};
    return {0, std::min(size, kPastFirst)};
  }
  std::vector<Record> labels_;
  std::map<std::string, std::vector<double>> values_;
  std::map<std::string, std::vector<Record>> shown_;
  std::map<std::string, std::map<std::string, std::vector<double>>> columns_;
};

RuleSet shipped(const std::string& only = "") {
  const std::filesystem::path folder = std::filesystem::path(BALLBAR_SOURCE_DIR) / "scripts" / "rules";
  if (only.empty()) return RuleSet::load(folder).rules;
  return RuleSet::load({read_rule_file(folder / (only + ".lua"))}).rules;
}

/// Runs 0.. until an alarm fires. @return the run, or -1
int first_alarm(const RuleSet& rules, int runs, unsigned seed, const std::function<Change(int)>& change,
                std::string* what = nullptr) {
  std::mt19937_64 rng(seed);
  std::map<std::string, LongPast> pasts;
  std::vector<AlarmStatus> states;
  for (int run = 0; run < runs; ++run) {
    for (const Record& subject : subjects_of(circle_of(run, change(run), rng))) {
      LongPast& past = pasts[subject.kind];
      const EvaluateResult result = rules.evaluate(subject, past, states, subject.started_us);
      for (const RuleError& error : result.errors) ADD_FAILURE() << to_string(error);
      for (const AlarmStatus& status : result.statuses) {
        std::erase_if(states, [&](const AlarmStatus& s) { return s.key == status.key; });
        states.push_back(status);
        if (status.state != AlarmState::kFiring) continue;
        if (what != nullptr) *what = status.key.rule + ": " + status.text;
        return run;
      }
      past.add(subject);
    }
  }
  return -1;
}

struct Scenario {
  const char* name;
  const char* rule;
  std::function<Change(double size_sd)> shape;
};

const std::vector<Scenario>& scenarios() {
  static const std::vector<Scenario> all{
      {"drifting joint zero", "ovality_drift",
       [](double d) {
         return Change{0.8 * d, 0.6 * d, 0, 0, 3.0};
       }},
      // The amplitude is 120 sd and stays: only the axis turns.
      {"phase only", "ovality_drift",
       [](double d) {
         const double angle = 2.0 * std::asin(d / 240.0);
         return Change{120.0 * std::cos(angle) - 120.0, 120.0 * std::sin(angle), 0, 0, 3.0};
       }},
      {"growing backlash", "hysteresis_growing",
       [](double d) {
         return Change{0, 0, d, 0, 3.0};
       }},
      {"what no model explains", "residual_growing", [](double d) {
         return Change{0, 0, 0, d, 3.0};
       }}};
  return all;
}

/// Of `draws` machines: how many were found no later than five runs after the change has reached 3 sd, and
/// how many had a false alarm before it began. `rate_sd` per run; infinite: a step of 3 sd.
struct Found {
  int in_time = 0, false_alarms = 0, latest = -1000;
};
Found find(const Scenario& scenario, double rate_sd, int draws, int begin) {
  const RuleSet rules = shipped(scenario.rule);
  const bool step = std::isinf(rate_sd);
  const int reached = begin + (step ? 0 : static_cast<int>(std::ceil(3.0 / rate_sd)));
  Found found;
  for (int draw = 0; draw < draws; ++draw) {
    const int alarm = first_alarm(rules, reached + 40, 1000u + static_cast<unsigned>(draw), [&](int run) {
      if (run < begin) return scenario.shape(0.0);
      return scenario.shape(step ? 3.0 : rate_sd * (run - begin));
    });
    const int late = alarm < 0 ? 1000 : alarm - reached + 1;  // the run that reaches 3 sd is the first
    found.false_alarms += alarm >= 0 && alarm < begin;
    found.in_time += late <= 5;
    found.latest = std::max(found.latest, late);
  }
  return found;
}

TEST(TwoYears, AHealthyMachineIsSilent) {
  std::string what;
  EXPECT_EQ(first_alarm(
                shipped(), 1000, 7, [](int) { return Change{}; }, &what),
            -1)
      << what << ", seed 7";
}

TEST(TwoYears, EveryDriftIsFoundWithinFiveRunsOfThreeStandardDeviations) {
  constexpr int kDraws = 5;
  for (const Scenario& scenario : scenarios()) {
    const Found found = find(scenario, 0.1, kDraws, 150);
    EXPECT_EQ(found.in_time, kDraws) << scenario.name << ", seeds from 1000";
    EXPECT_EQ(found.false_alarms, 0) << scenario.name;
  }
}

TEST(TwoYears, ARemasteringIsFoundAtOnceAndANewSeriesIsANewBaseline) {
  const RuleSet rules = shipped("ovality_drift");
  const auto remastered = [](int run) { return Change{run >= 300 ? 50.0 : 0.0, 0.0, 0.0, 0.0, 3.0}; };
  EXPECT_EQ(first_alarm(rules, 400, 3, remastered), 301) << "25 um: at the second circle";
}

TEST(DISABLED_LongTwoYears, TenThousandHealthyRunsRaiseNoAlarm) {
  int alarms = 0;
  constexpr int kMachines = 5;
  for (unsigned seed = 1; seed <= kMachines; ++seed) {
    std::string what;
    const int alarm = first_alarm(
        shipped(), 10'000, seed, [](int) { return Change{}; }, &what);
    if (alarm >= 0) std::printf("seed %u: run %d: %s\n", seed, alarm, what.c_str());
    alarms += alarm >= 0;
  }
  std::printf("healthy: %d machines of 10,000 runs each through all shipped rules: %d with a false alarm\n",
              kMachines, alarms);
  EXPECT_EQ(alarms, 0);
}

TEST(DISABLED_LongTwoYears, OnsetsAreFoundWithinFiveRuns) {
  constexpr int kDraws = 100;
  std::printf("%-24s %12s %10s %8s %14s\n", "change", "sd per run", "in time", "latest", "false before");
  for (const Scenario& scenario : scenarios()) {
    for (const double rate :
         {3.0 / (kTwoYears - 600), 0.02, 0.1, 0.5, std::numeric_limits<double>::infinity()}) {
      const int draws = rate < 0.01 ? 20 : kDraws;
      const Found found = find(scenario, rate, draws, 300);
      std::printf("%-24s %12.5f %5d/%-4d %8d %14d\n", scenario.name, rate, found.in_time, draws, found.latest,
                  found.false_alarms);
      if (!std::isinf(rate)) {
        EXPECT_GE(found.in_time, draws - draws / 50) << scenario.name << " " << rate;
      }
      EXPECT_EQ(found.false_alarms, 0) << scenario.name << " " << rate;
    }
  }
}

}  // namespace
}  // namespace ballbar
