#include "daemon/rule_keeper.hpp"

#include <utility>

#include "daemon/service.hpp"

namespace ballbar {
namespace {

using Files = std::vector<std::pair<std::string, std::string>>;

Files files_of(const RuleSet& rules) {
  Files files;
  for (const Rule& rule : rules.rules()) files.emplace_back(rule.source.file, rule.source.text);
  return files;
}

}  // namespace

std::optional<RuleKeeper::Taken> RuleKeeper::load(const Config& config, std::int64_t now_us) {
  LoadReport report = load_rules(config);
  errors_ = report.errors;
  for (const RuleError& error : errors_) log_(Priority::kError, "rules not taken: " + to_string(error));
  std::optional<Taken> taken;
  if (errors_.empty()) {
    generation_ = number_of(report.rules, now_us);
    taken = {std::move(report.rules), true};
    log_(Priority::kNotice, "rules generation " + std::to_string(generation_) + ": " +
                                std::to_string(taken->rules.rules().size()) + " rules");
  } else if (first_) {
    taken = last_good(std::move(report));
  }
  first_ = false;
  if (const std::string why = why_not(); !why.empty()) log_(Priority::kError, why);
  return taken;
}

RuleKeeper::Taken RuleKeeper::last_good(LoadReport report) {
  try {
    if (const std::optional<RuleGeneration> last = store_.last_rules()) {
      std::vector<RuleSource> sources;
      for (const auto& [file, text] : last->files) sources.push_back({file, text});
      LoadReport stored = RuleSet::load(sources);
      generation_ = last->generation;
      return {std::move(stored.rules), stored.errors.empty()};
    }
  } catch (const StoreError& error) {
    log_(Priority::kError, std::string("the last good rules cannot be read: ") + error.what());
  }
  return {std::move(report.rules), false};
}

int RuleKeeper::number_of(const RuleSet& rules, std::int64_t now_us) {
  const Files files = files_of(rules);
  try {
    const std::optional<RuleGeneration> last = store_.last_rules();
    return last && last->files == files ? last->generation : store_.save_rules(files, now_us);
  } catch (const StoreError& error) {
    log_(Priority::kError, std::string("rules taken, but not kept for the next start: ") + error.what());
    return generation_ + 1;
  }
}

std::string RuleKeeper::why_not() const {
  if (errors_.empty()) return "";
  const std::string which = generation_ > 0 ? "rules generation " + std::to_string(generation_) + " stays: "
                                            : "only the rules that could be loaded are in use: ";
  const std::size_t more = errors_.size() - 1;
  return which + to_string(errors_.front()) +
         (more == 0 ? "" : " (and " + std::to_string(more) + (more == 1 ? " more error)" : " more errors)"));
}

}  // namespace ballbar
