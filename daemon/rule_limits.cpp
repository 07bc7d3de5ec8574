#include "daemon/rule_limits.hpp"

#include <algorithm>
#include <filesystem>

#include "daemon/tool.hpp"
#include "rules/rule_set.hpp"

namespace ballbar {

std::vector<Rule> configured_rules(const Where& where) {
  std::error_code error;
  if (where.config_path == kDefaultConfig && !std::filesystem::exists(where.config_path, error)) return {};
  std::vector<std::filesystem::path> folders = where.config().rule_folders();
  std::erase_if(folders,
                [&error](const auto& folder) { return !std::filesystem::is_directory(folder, error); });
  return RuleSet::load_folders(folders).rules.rules();
}

std::vector<TrendLimit> limits_of(const std::vector<Rule>& rules, const std::string& quantity,
                                  const std::vector<Record>& records) {
  std::vector<TrendLimit> limits;
  for (const Rule& rule : rules) {
    if (rule.needs != std::vector{quantity}) continue;
    if (std::none_of(records.begin(), records.end(), [&](const Record& r) { return applies(rule, r); }))
      continue;
    for (const auto& [name, field] : rule.fields) {
      const double* value = std::get_if<double>(&field);
      if (value && name.starts_with("limit_") && quantity.ends_with(name.substr(sizeof "limit" - 1)))
        limits.push_back({*value, "rule " + rule.name});
    }
  }
  return limits;
}

}  // namespace ballbar
