#pragma once
/// Which test to drive next, as text, JSON and tables of the configuration.

#include <nlohmann/json.hpp>
#include <string>
#include <vector>

#include "gap/next_test.hpp"

namespace ballbar {

/// A circle or line as a [[robot.test]] table that can be pasted into the configuration.
std::string test_table(const TestSpec& test);

std::string to_text(const std::vector<PairPlan>& plans);
nlohmann::ordered_json to_json(const std::vector<PairPlan>& plans);

std::string to_text(const RobotPlan& plan);
nlohmann::ordered_json to_json(const RobotPlan& plan);

/// A line on standard error that shows how far a piece of work is, on a terminal only; gone when it ends.
class ProgressLine {
 public:
  explicit ProgressLine(std::string what);
  ~ProgressLine();
  ProgressLine(const ProgressLine&) = delete;
  ProgressLine& operator=(const ProgressLine&) = delete;
  Progress progress();

 private:
  std::string what_;
  bool terminal_;
};

}  // namespace ballbar
