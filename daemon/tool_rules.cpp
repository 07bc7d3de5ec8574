#include "daemon/tool_rules.hpp"

#include <algorithm>
#include <chrono>
#include <iostream>
#include <map>
#include <memory>
#include <sstream>

#include "core/error.hpp"
#include "daemon/rule_limits.hpp"
#include "daemon/service.hpp"
#include "report/trend_plot.hpp"
#include "rules/names.hpp"
#include "rules/rule_set.hpp"
#include "rules/sandbox.hpp"
#include "rules/subjects.hpp"
#include "rules/text.hpp"

namespace ballbar {
namespace {

struct RulesOptions {
  Where where;
  std::string directory, since, robot, rule, output, run;
};

RuleSet load_set(const RulesOptions& options) {
  LoadReport report =
      options.directory.empty() ? load_rules(options.where.config()) : RuleSet::load(options.directory);
  if (!report.errors.empty())
    throw Error(Cause::kInput, to_string(report.errors.front()) + "; ballbar rules check says more");
  return std::move(report.rules);
}

const Rule& rule_named(const RuleSet& rules, const std::string& name) {
  std::vector<std::string_view> names;
  for (const Rule& rule : rules.rules()) {
    if (rule.name == name) return rule;
    names.emplace_back(rule.name);
  }
  throw Error(Cause::kInput, "there is no rule '" + name + "'" + did_you_mean(nearest(name, names, 4)));
}

std::string subject_name(const StoredRun& run, const Record& subject) {
  const std::string what = subject.kind == "test" ? run.test + " (both directions)"
                                                  : run_name(run.test, run.direction, run.repetition);
  return run.robot + " " + what + (subject.axis.empty() ? "" : " " + subject.axis);
}

/// The alarms of a set of rules, and how they change from run to run.
struct Backtest {
  std::map<AlarmKey, AlarmStatus> alarms;
  std::map<std::string, int> errors;   // by their text
  std::map<std::string, int> changes;  // by rule
  std::int64_t runs = 0;
};

void feed(const RuleSet& rules, const Store& store, const StoredRun& run, Backtest& test,
          const std::function<void(const Record&, const AlarmEvent&)>& changed) {
  ++test.runs;
  for (const Record& record : run.records) {
    for (const Record& subject : subjects_of(record)) {
      std::vector<AlarmStatus> states;
      for (const auto& [key, status] : test.alarms) states.push_back(status);
      const std::unique_ptr<Past> past = store.past(subject);
      const EvaluateResult verdict = rules.evaluate(subject, *past, states, run.ended_us);
      for (const AlarmStatus& status : verdict.statuses) test.alarms[status.key] = status;
      for (const RuleError& error : verdict.errors) ++test.errors[to_string(error)];
      for (const AlarmEvent& event : verdict.events) {
        ++test.changes[event.status.key.rule];
        changed(subject, event);
      }
    }
  }
}

void print_change(const StoredRun& run, const Record& subject, const AlarmEvent& event) {
  std::cout << utc_text(run.started_us) << "  " << event.status.key.rule << "  " << subject_name(run, subject)
            << "  " << to_string(event.from) << " -> " << to_string(event.status.state);
  if (!event.status.text.empty() && event.status.clean_runs == 0) std::cout << ": " << event.status.text;
  std::cout << "\n";
}

/// The figure that a rule needs first, over the backtest; a line stands where its alarm changed.
class Picture {
 public:
  explicit Picture(const Rule& rule) : rule_(rule) {
    if (rule.needs.empty())
      throw Error(Cause::kInput, "rule " + rule.name + " needs no figure that could be drawn");
  }

  void add(const Record& subject, const Backtest& test) {
    if (!applies(rule_, subject)) return;
    const auto value = subject.values.find(rule_.needs.front());
    const auto alarm =
        test.alarms.find({rule_.name, subject.robot, subject.test, subject.direction, subject.axis});
    if (value == subject.values.end() || alarm == test.alarms.end()) return;
    const std::string direction = subject.direction > 0 ? " +1" : subject.direction < 0 ? " -1" : "";
    const std::string label =
        subject.robot + " " + subject.test + direction + (subject.axis.empty() ? "" : " " + subject.axis);
    Trend& trend = trends_[label];
    trend.label = label;
    trend.group = subject.test;
    trend.direction = subject.direction;
    trend.points.push_back(
        {subject.started_us, value->second.value, value->second.sd, to_string(alarm->second.state)});
    records_.push_back(subject);
  }

  void draw(const std::string& path) const {
    TrendPlot plot;
    plot.title = "rule " + rule_.name;
    plot.subtitle = "what it would have said of the stored runs";
    plot.value_label = rule_.needs.front();
    for (const auto& [label, trend] : trends_) plot.trends.push_back(trend);
    plot.limits = limits_of({rule_}, rule_.needs.front(), records_);
    render(trend_script(plot), path);
  }

 private:
  const Rule& rule_;
  std::map<std::string, Trend> trends_;
  std::vector<Record> records_;
};

int backtest(const RulesOptions& options) {
  const RuleSet rules = load_set(options);
  const Rule* drawn = options.rule.empty() ? nullptr : &rule_named(rules, options.rule);
  if (!options.output.empty() && drawn == nullptr)
    throw Error(Cause::kInput, "-o draws one rule: name it with --rule");
  const Store store = options.where.open();
  RunFilter filter;
  filter.status = "ok";
  filter.harmonic_orders = kAllHarmonicOrders;
  if (!options.robot.empty()) filter.robot = options.robot;
  if (!options.since.empty()) filter.since_us = time_of(options.since, now_us());
  Backtest test;
  std::optional<Picture> picture;
  if (drawn != nullptr && !options.output.empty()) picture.emplace(*drawn);
  for (const StoredRun& run : store.runs(filter)) {
    feed(rules, store, run, test, [&](const Record& subject, const AlarmEvent& event) {
      if (drawn == nullptr || event.status.key.rule == drawn->name) print_change(run, subject, event);
    });
    if (!picture) continue;
    for (const Record& record : run.records)
      for (const Record& subject : subjects_of(record)) picture->add(subject, test);
  }
  int changes = 0;
  for (const auto& [rule, count] : test.changes)
    if (drawn == nullptr || rule == drawn->name) changes += count;
  for (const auto& [error, count] : test.errors) std::cout << error << " (" << count << " times)\n";
  std::cout << test.runs << " runs, " << changes << " changes of state, " << test.errors.size()
            << " errors\n";
  if (picture) picture->draw(options.output);
  return test.errors.empty() ? 0 : 1;
}

std::string why_not_asked(const Rule& rule, const Record& subject) {
  if (subject.status != "ok")
    return "not asked: the run's status is " + subject.status + ", rules see \"ok\" only";
  for (const auto& [label, wanted] : rule.where.labels) {
    const std::string has = label_text(subject, label);
    if (has == wanted) continue;
    std::string text = "not asked: where says ";
    text.append(label).append(" = \"").append(wanted).append("\", this run has \"").append(has).append("\"");
    return text;
  }
  if (rule.where.direction && *rule.where.direction != subject.direction)
    return "not asked: where says another direction";
  return "not asked: where says another payload_kg, or the run is of the virtual ballbar";
}

void explain_subject(const Rule& rule, const Store& store, const StoredRun& run, const Record& subject) {
  std::cout << subject_name(run, subject) << ", " << subject.kind << "\n";
  if (!applies(rule, subject)) {
    std::cout << "  " << why_not_asked(rule, subject) << "\n";
    return;
  }
  for (const std::string& name : rule.needs) {
    const auto value = subject.values.find(name);
    std::cout << "  " << name << " = "
              << (value == subject.values.end() ? "missing" : short_number(value->second.value)) << "\n";
  }
  for (const auto& [name, value] : rule.fields)
    if (const double* number = std::get_if<double>(&value))
      std::cout << "  rule." << name << " = " << short_number(*number) << "\n";
  const std::unique_ptr<Past> past = store.past(subject);
  const std::size_t held = past->window(rule.baseline).size();
  std::cout << "  earlier results: " << past->window("recent").size() << "; baseline (" << rule.baseline
            << "): " << std::min(held, static_cast<std::size_t>(rule.baseline_runs)) << " of "
            << rule.baseline_runs << "\n";
  try {
    const Judgement judgement = judge(rule, subject, *past);
    for (const auto& [name, value] : judgement.given)
      std::cout << "  " << name << " = " << short_number(value) << "\n";
    std::cout << "  bad: " << (judgement.bad ? "yes: " + judgement.text : "no") << "\n";
  } catch (const ScriptError& error) {
    std::cout << "  error: " << to_string(RuleError{rule.name, rule.source.file, error.line(), error.what()})
              << "\n";
  }
}

int explain(const RulesOptions& options) {
  const RuleSet rules = load_set(options);
  const Rule& rule = rule_named(rules, options.rule);
  const Store store = options.where.open();
  const StoredRun named = find_run(store, options.run);
  RunFilter filter;
  filter.ids = {named.id};
  filter.harmonic_orders = kAllHarmonicOrders;
  const StoredRun run = store.runs(filter).at(0);
  bool asked = false;
  for (const Record& record : run.records) {
    for (const Record& subject : subjects_of(record)) {
      if (subject.kind != rule.kind) continue;
      explain_subject(rule, store, run, subject);
      asked = true;
    }
  }
  if (!asked)
    std::cout << subject_name(run, run.records.front()) << ": not asked: the rule is on " << rule.kind
              << "\n";
  // States: the same rule over what came before.
  filter = {};
  filter.robot = run.robot;
  filter.status = "ok";
  filter.harmonic_orders = kAllHarmonicOrders;
  filter.until_us = run.started_us + 1;
  filter.newest_first = true;
  filter.limit = static_cast<std::int64_t>(4 * kPastRecent);
  std::vector<StoredRun> before = store.runs(filter);
  std::reverse(before.begin(), before.end());
  Backtest test;
  std::vector<std::string> said;
  for (const StoredRun& earlier : before)
    feed(rules, store, earlier, test, [&](const Record& subject, const AlarmEvent& event) {
      if (event.status.key.rule != rule.name || subject.test != run.test) return;
      said.push_back("  " + utc_text(earlier.started_us) + "  " + subject_name(earlier, subject) + "  " +
                     to_string(event.from) + " -> " + to_string(event.status.state));
    });
  std::cout << "it fires at " << rule.hold_runs << " bad runs in a row and ends after more than "
            << rule.keep_runs << " good ones; the alarm's changes until this run:\n";
  constexpr std::size_t kShown = 10;
  for (std::size_t i = said.size() > kShown ? said.size() - kShown : 0; i < said.size(); ++i)
    std::cout << said[i] << "\n";
  if (said.empty()) std::cout << "  none\n";
  return 0;
}

}  // namespace

void add_rule_history(CLI::App& rules, Action& action) {
  auto options = std::make_shared<RulesOptions>();
  const auto does = [options, &action](CLI::App* verb, int (*what)(const RulesOptions&)) {
    options->where.add_to(*verb);
    verb->callback([options, what, &action] { action = [options, what] { return what(*options); }; });
    return verb;
  };
  const char* folder = "folder of the rules (default: the configured one)";
  CLI::App* back =
      does(rules.add_subcommand("backtest", "what the rules would have said of the stored runs"), backtest);
  back->add_option("DIRECTORY", options->directory, folder);
  back->add_option("--since", options->since, "only runs since then: 2026-03-11, or 30d (ago)");
  back->add_option("--robot", options->robot, "only runs of this robot");
  back->add_option("--rule", options->rule, "show and draw only this rule");
  back->add_option("-o,--output", options->output,
                   "a picture (.svg, .png) of the rule's figure and its states");
  CLI::App* why = does(rules.add_subcommand("explain", "why a rule did or did not find a run bad"), explain);
  why->add_option("NAME", options->rule, "the rule's name")->required();
  why->add_option("RUN", options->run, "the run: A+1#2, SERIES:A+1#2 or its id")->required();
  why->add_option("--rules", options->directory, folder);
}

}  // namespace ballbar
