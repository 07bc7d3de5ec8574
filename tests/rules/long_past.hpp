#pragma once
/// Many runs, one after another, through the shipped rules.

#include <algorithm>
#include <filesystem>
#include <functional>
#include <map>
#include <string>
#include <utility>
#include <vector>

#include "core/past.hpp"
#include "rules/rule_files.hpp"
#include "rules/rule_set.hpp"

namespace ballbar::test {

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

/// @param only  one rule; empty: all
inline RuleSet shipped_rules(const std::string& only = "") {
  const std::filesystem::path folder = std::filesystem::path(BALLBAR_SOURCE_DIR) / "scripts" / "rules";
  if (only.empty()) return RuleSet::load(folder).rules;
  return RuleSet::load({read_rule_file(folder / (only + ".lua"))}).rules;
}

/// Runs 0.., one after another; each alarm that fires is told.
/// @param subjects_at  what the rules are asked about at a run
/// @param fires        hears of each alarm that begins to fire; false: that is enough
/// @param failed       hears of each error of a rule
inline void each_alarm(const RuleSet& rules, int runs,
                       const std::function<std::vector<Record>(int run)>& subjects_at,
                       const std::function<bool(int run, const AlarmStatus& alarm)>& fires,
                       const std::function<void(const RuleError&)>& failed) {
  std::map<std::pair<std::string, int>, LongPast> pasts;
  std::vector<AlarmStatus> states;
  for (int run = 0; run < runs; ++run) {
    for (const Record& subject : subjects_at(run)) {
      LongPast& past = pasts[{subject.kind, subject.direction}];
      const EvaluateResult result = rules.evaluate(subject, past, states, subject.started_us);
      for (const RuleError& error : result.errors) failed(error);
      for (const AlarmStatus& status : result.statuses) {
        std::erase_if(states, [&](const AlarmStatus& s) { return s.key == status.key; });
        states.push_back(status);
      }
      for (const AlarmEvent& event : result.events)
        if (event.status.state == AlarmState::kFiring && !fires(run, event.status)) return;
      past.add(subject);
    }
  }
}

}  // namespace ballbar::test
