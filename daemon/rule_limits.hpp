#pragma once
/// Limits of alarm rules, for trends.

#include <string>
#include <vector>

#include "report/trend_plot.hpp"
#include "rules/rule.hpp"

namespace ballbar {

struct Where;

/// The rules of the configuration; none where there is no configuration, as with --db alone. Rules that
/// cannot be loaded are left out: 'ballbar rules check' names them.
/// @throws Error where a configuration is there but wrong
std::vector<Rule> configured_rules(const Where& where);

/// The limits of a quantity: of each rule that needs nothing else, applies to one of the records, and has a
/// number called limit_<unit>, as ovality_high's limit_um is of ovality_um. A rule that computes something
/// from its quantities limits that, and not them.
std::vector<TrendLimit> limits_of(const std::vector<Rule>& rules, const std::string& quantity,
                                  const std::vector<Record>& records);

}  // namespace ballbar
