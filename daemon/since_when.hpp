#pragma once
/// `ballbar diagnose --since-when`: after which run of the stored history the robot was another, and what
/// that looks like.

#include <nlohmann/json.hpp>
#include <optional>
#include <string>
#include <vector>

#include "core/spec.hpp"
#include "gap/since.hpp"
#include "physics/as_built.hpp"
#include "store/store.hpp"

namespace ballbar {

/// One test in one direction, as it was driven last: its runs with the same feed and payload.
struct TestHistory {
  std::string test;
  int direction = 0;
  std::vector<StoredRun> runs;  ///< oldest first
};

/// A change seen in one of them.
struct SeenChange {
  std::string test;
  int direction = 0;
  std::int64_t last_before = 0, first_after = 0;    ///< ids of runs
  std::int64_t earliest_us = 0, latest_us = 0;      ///< begins of the first run after it at 95 %
  std::int64_t first_after_us = 0;                  ///< its most likely begin
  int earliest_run = 0, latest_run = 0, place = 0;  ///< counted from 0 in the history
  int orders = 0;                                   ///< harmonics 2 .. of so many orders were looked at
  double step = 0.0;                                ///< [m] length of the change of these harmonics
  double p_value = 1.0;
  bool gradual = false;
};

/// What all tests say together: changes whose ranges overlap are one.
struct RobotChange {
  std::vector<SeenChange> seen;                 ///< the most significant first
  std::int64_t earliest_us = 0, latest_us = 0;  ///< what all of them allow
  std::vector<Likeness> likeness;               ///< the best first
};

struct SinceWhen {
  std::string robot;
  std::vector<TestHistory> histories;
  std::vector<RobotChange> changes;  ///< by time
};

/// @param test  only this one; empty: all
/// @throws Error(kInput) where the robot has no history that is long enough
SinceWhen since_when(const Store& store, const RobotSpec& robot, const AsBuilt& built,
                     const std::string& test);

nlohmann::ordered_json to_json(const SinceWhen& found);
std::string to_text(const SinceWhen& found);

}  // namespace ballbar
