#include "daemon/tool_rules.hpp"

#include <algorithm>
#include <filesystem>
#include <iostream>
#include <map>
#include <memory>

#include "core/error.hpp"
#include "daemon/backtest.hpp"
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

struct RuleOptions {
  Where where;
  std::string directory, since, until, robot, rule, output, run;
};

RuleSet load_set(const RuleOptions& options) {
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

/// The line's text, below the error; nothing where it names none.
std::string line_of_error(const Rule& rule, const RuleError& error) {
  const std::string text = text_of_line(rule.source.text, error.line);
  return text.empty() ? "" : "    " + text + "\n";
}

/// "-> firing: text [ovality_um 184.3]": the text where the rule found it bad, and what it needs.
std::string says_of_change(const Rule& rule, const BacktestChange& change) {
  const AlarmEvent& event = change.event;
  std::string line = std::string(to_string(event.from)) + " -> " + to_string(event.status.state);
  if (!event.status.text.empty() && event.status.clean_runs == 0) line += ": " + event.status.text;
  std::string values;
  for (const std::string& name : rule.needs)
    if (const auto found = change.record.values.find(name); found != change.record.values.end())
      values += (values.empty() ? "" : ", ") + name + " " + short_number(found->second.value);
  return line + (values.empty() ? "" : "  [" + values + "]");
}

/// The figure that a rule needs first, over the backtest; a line stands where its alarm changed.
void draw_backtest(const Rule& rule, const BacktestReport& report, const std::string& path) {
  if (rule.needs.empty())
    throw Error(Cause::kInput, "rule " + rule.name + " needs no figure that could be drawn");
  const std::string& quantity = rule.needs.front();
  std::map<std::string, Trend> trends;
  std::vector<Record> records;
  for (const auto& [subject, state] : report.asked) {
    const auto value = subject.values.find(quantity);
    if (value == subject.values.end()) continue;
    std::string label = subject.robot;
    if (!subject.test.empty()) label += " " + subject.test;
    if (subject.direction != 0) label += subject.direction > 0 ? " +1" : " -1";
    if (!subject.axis.empty()) label += " " + subject.axis;
    Trend& trend = trends[label];
    trend.label = label;
    trend.group = subject.test;
    trend.direction = subject.direction;
    trend.points.push_back({subject.started_us, value->second.value, value->second.sd, to_string(state)});
    records.push_back(subject);
  }
  TrendPlot plot;
  plot.title = "rule " + rule.name;
  plot.subtitle = "what it would have said of what is stored";
  plot.value_label = quantity;
  for (const auto& [label, trend] : trends) plot.trends.push_back(trend);
  plot.limits = limits_of({rule}, quantity, records);
  render(trend_script(plot), path);
}

std::vector<RobotSpec> known_robots(const RuleOptions& options) {
  std::error_code error;
  if (!std::filesystem::exists(options.where.config_path, error)) return {};
  return options.where.config().robots;
}

int backtest(const RuleOptions& options) {
  RuleSet rules = load_set(options);
  if (!options.rule.empty()) rules = RuleSet::load({rule_named(rules, options.rule).source}).rules;
  if (!options.output.empty() && options.rule.empty())
    throw Error(Cause::kInput, "-o draws one rule: name it with --rule");
  const Store store = options.where.open();
  BacktestPeriod period;
  period.robot = options.robot;
  period.known = known_robots(options);
  if (!options.since.empty()) period.since_us = time_of(options.since, now_us());
  period.until_us = options.until.empty() ? now_us() : time_of(options.until, now_us());
  const BacktestReport report =
      backtest(rules, store, period, options.output.empty() ? nullptr : &rules.rules().front());
  for (const BacktestChange& change : report.changes) {
    const std::string& name = change.event.status.key.rule;
    std::cout << utc_text(change.at_us) << "  " << name << "  " << change.subject << "  "
              << says_of_change(rule_named(rules, name), change) << "\n";
  }
  for (const auto& [error, count] : report.errors)
    std::cout << to_string(error) << " (" << count << " times)\n"
              << line_of_error(rule_named(rules, error.rule), error);
  std::cout << report.runs << " runs, " << report.diagnoses << " diagnoses, " << report.changes.size()
            << " changes of state, " << report.errors.size() << " errors\n";
  if (!options.output.empty()) draw_backtest(rules.rules().front(), report, options.output);
  return report.errors.empty() ? 0 : 1;
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
    const RuleError why{rule.name, rule.source.file, error.line(), error.what()};
    std::cout << "  error: " << to_string(why) << "\n" << line_of_error(rule, why);
  }
}

int explain(const RuleOptions& options) {
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
              << (rule.kind == "gap" || rule.kind == "silence" || rule.kind == "loss"
                      ? "; ballbar rules backtest --rule " + rule.name + " says when it would have fired"
                      : "")
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
  RunBacktest test(rules, store);
  std::vector<std::string> said;
  for (const StoredRun& earlier : before)
    test.feed(earlier, [&](const Record& subject, const AlarmEvent& event) {
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
  auto options = std::make_shared<RuleOptions>();
  const auto does = [options, &action](CLI::App* verb, int (*what)(const RuleOptions&)) {
    options->where.add_to(*verb);
    verb->callback([options, what, &action] { action = [options, what] { return what(*options); }; });
    return verb;
  };
  const char* folder = "folder of the rules (default: the configured one)";
  CLI::App* back =
      does(rules.add_subcommand("backtest", "what the rules would have said of what is stored"), backtest);
  back->add_option("DIRECTORY", options->directory, folder);
  back->add_option("--since", options->since, "only what was since then: 2026-03-11, or 30d (ago)");
  back->add_option("--until", options->until, "until then (default: now)");
  back->add_option("--robot", options->robot, "only of this robot");
  back->add_option("--rule", options->rule, "show and draw only this rule");
  back->add_option("-o,--output", options->output,
                   "a picture (.svg, .png) of the rule's figure and its states");
  CLI::App* why = does(rules.add_subcommand("explain", "why a rule did or did not find a run bad"), explain);
  why->add_option("NAME", options->rule, "the rule's name")->required();
  why->add_option("RUN", options->run, "the run: A+1#2, SERIES:A+1#2 or its id")->required();
  why->add_option("--rules", options->directory, folder);
}

}  // namespace ballbar
