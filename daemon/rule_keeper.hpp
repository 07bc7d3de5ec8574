#pragma once
/// Which set of rules is in use: a whole one that passes, or the last one that did, also after a restart.

#include <cstdint>
#include <functional>
#include <optional>
#include <string>
#include <vector>

#include "daemon/config.hpp"
#include "daemon/log.hpp"
#include "rules/rule_set.hpp"
#include "store/store.hpp"

namespace ballbar {

class RuleKeeper {
 public:
  using Log = std::function<void(Priority, const std::string&)>;
  RuleKeeper(Store& store, Log log) : store_(store), log_(std::move(log)) {}

  struct Taken {
    RuleSet rules;
    bool complete = false;  ///< alarms of rules that it does not hold have no rule any more
  };

  /// Reads the configured folder. A set with an error in any file is not taken, so that rules that were
  /// edited together go live together.
  ///
  /// @return the set to be used from now on; nothing where the one in use stays. At the first call of a
  ///         process the last good set of the database takes the place of one that does not pass; where there
  ///         is none, the rules that could be loaded.
  std::optional<Taken> load(const Config& config, std::int64_t now_us);

  int generation() const { return generation_; }                    ///< of the set in use; 0: of no good set
  const std::vector<RuleError>& errors() const { return errors_; }  ///< of the last load()
  /// "rules generation 3 stays: high.lua:2: ... (and 1 more error)"; empty where the last load() passed.
  std::string why_not() const;

 private:
  Taken last_good(LoadReport report);
  int number_of(const RuleSet& rules, std::int64_t now_us);

  Store& store_;
  Log log_;
  int generation_ = 0;
  bool first_ = true;
  std::vector<RuleError> errors_;
};

}  // namespace ballbar
