#pragma once
/// A history in memory: of tables of tests, and of whoever has the records at hand.

#include <cstdint>
#include <map>

#include "core/alarm.hpp"
#include "core/past.hpp"

namespace ballbar {

class PastRecords : public Past {
 public:
  /// Of a History that was read for `record`; what is not "ok" is left out. "first" and "calibration" are its
  /// oldest recent ones.
  PastRecords(const Record& record, const History& history);

  /// What of `all` (in sequence of time) is earlier than `record` and of its robot, test, kind, direction,
  /// axis and source.
  /// @param marks_us  times of calibrations
  PastRecords(const Record& record, const std::vector<Record>& all,
              const std::vector<std::int64_t>& marks_us);

  const std::vector<Record>& window(const std::string& which) override;
  const std::vector<double>& column(const std::string& which, const std::string& name) override;

 private:
  Record record_;
  std::vector<Record> all_;  // of the same subject, "ok"
  std::vector<std::int64_t> marks_us_;
  std::map<std::string, std::vector<Record>> windows_;
  std::map<std::string, std::map<std::string, std::vector<double>>> columns_;
};

}  // namespace ballbar
