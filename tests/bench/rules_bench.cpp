// What one new circle costs: 100 rules, on robots with short and long histories. Prints milliseconds of one
// core.
//     build/tests/rules_bench [CIRCLES]

#include <algorithm>
#include <cstdio>
#include <cstdlib>
#include <ctime>
#include <random>

#include "pipeline/catalogue.hpp"
#include "rules/rule_set.hpp"
#include "rules/subjects.hpp"
#include "store/store.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

/// Of this process: what else the machine does is not counted.
double cpu_ms() { return 1000.0 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; }

/// A circle with 45 figures and 10 orders, without a recording.
struct Circle {
  Run run;
  RunResult result;
  std::vector<Record> records;
};

Circle circle(int number, std::mt19937_64& rng) {
  std::normal_distribution<double> noise;
  Circle c;
  c.run.robot = "r";
  c.run.test = "A";
  c.run.direction = number % 2 == 0 ? 1 : -1;
  c.run.series = "s" + std::to_string(number / 5000);
  c.run.started_us = 1'700'000'000'000'000 + number * 60'000'000LL;
  c.run.ended_us = c.run.started_us + 12'000'000;
  c.result.source = "bar";
  c.result.circle.emplace();
  for (int k = 1; k <= 10; ++k)
    c.result.circle->harmonics.push_back({k, noise(rng) * 1e-6, noise(rng) * 1e-6, 1e-14, 1e-14, 0});
  for (Record& record : ballbar::records(c.run, c.result)) c.records.push_back(record);
  for (const Quantity& quantity : catalogue())
    if (quantity.kind == "circle") c.records[0].values[std::string(quantity.name)] = {50.0 + noise(rng), {}};
  return c;
}

/// 100 rules that look back in every way, at twenty figures.
std::vector<RuleSource> hundred_rules() {
  std::vector<std::string> names;
  for (const Quantity& quantity : catalogue())
    if (quantity.kind == "circle" && quantity.name.ends_with("_um") && names.size() < 20)
      names.emplace_back(quantity.name);
  std::vector<RuleSource> rules;
  for (int i = 0; i < 100; ++i) {
    const std::string& name = names[static_cast<std::size_t>(i) % names.size()];
    const std::vector<std::string> ways{"result." + name + " > 2 * (history.median('" + name + "') or 100)",
                                        "(history.slope('" + name + "') or 0) > 100",
                                        "(history.cusum('" + name + "') or 0) > 50",
                                        "(history.vector_cusum('ovality') or 0) > 50",
                                        "#history.recent > 50 and history.recent[1]." + name + " > 100"};
    rules.push_back({"r" + std::to_string(i) + ".lua",
                     "return { name = 'r" + std::to_string(i) + "', on = 'circle', needs = { '" + name +
                         "' }, text = 'x', limit_um = 1,\n"
                         "when = function(result, history, rule) return " +
                         ways[static_cast<std::size_t>(i) / 20] + " end }"});
  }
  return rules;
}

void measure(int circles) {
  test::TempDir dir;
  Store store(dir.path() + "/b.db");
  store.database().execute("PRAGMA synchronous = OFF");
  std::mt19937_64 rng(1);
  for (int i = 0; i < circles; ++i) {
    const Circle c = circle(i, rng);
    store.save(c.run, c.result, c.records, {}, {});
  }
  const LoadReport loaded = RuleSet::load(hundred_rules());
  std::vector<double> took;
  std::vector<AlarmStatus> states;
  for (int i = circles; i < circles + 101; ++i) {
    const Circle c = circle(i, rng);
    const Record record = with_harmonics(c.records[0], c.result);
    const double begin = cpu_ms();
    for (const Record& subject : subjects_of(record)) {
      const std::unique_ptr<Past> past = store.past(subject);
      const EvaluateResult result = loaded.rules.evaluate(subject, *past, states, c.run.ended_us);
      if (!result.errors.empty()) std::printf("%s\n", to_string(result.errors[0]).c_str());
    }
    if (i > circles) took.push_back(cpu_ms() - begin);
    store.save(c.run, c.result, c.records, {}, {});
  }
  std::sort(took.begin(), took.end());
  std::printf("%7d circles stored, %zu rules: median %.2f ms, largest %.2f ms for a new circle\n", circles,
              loaded.rules.rules().size(), took[took.size() / 2], took.back());
}

}  // namespace
}  // namespace ballbar

int main(int argc, char** argv) {
  const int most = argc > 1 ? std::atoi(argv[1]) : 100'000;
  for (int circles = 1000; circles <= most; circles *= 10) ballbar::measure(circles);
  return 0;
}
