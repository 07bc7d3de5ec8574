#pragma once
/// Results, alarms and status onto the bus, for lcm-spy and other listeners. Only sends: without a
/// subscription liblcm opens no receiving socket, so no datagram can reach this process.

#include <memory>
#include <span>
#include <string>
#include <vector>

#include "core/alarm.hpp"
#include "core/gap_record.hpp"
#include "core/result.hpp"

namespace ballbar {

/// Once a second on BALLBARD_STATUS; fields as in lcmtypes/daemon_status_t.lcm.
struct DaemonStatus {
  std::int64_t time_us = 0;
  std::string version, state, database, last_error;
  std::int64_t messages = 0, refused = 0, lost_messages = 0, kernel_drops = 0, receiver_restarts = 0;
  std::int64_t runs_stored = 0, runs_ok = 0, runs_open = 0, store_failures = 0, runs_waiting = 0;
  int rules = 0, rules_generation = 0, rule_errors = 0, alarms_firing = 0;
};

class Publisher {
 public:
  /// @throws Error(kWorld) where the bus cannot be opened, e.g. without a multicast route
  explicit Publisher(const std::string& url);
  ~Publisher();

  /// One CIRCLE_RESULT, or one LINE_RESULT per axis.
  /// @param records  of this run, from pipeline/catalogue
  void publish(const Run& run, const RunResult& result, const std::vector<Record>& records);
  void publish(const AlarmStatus& alarm);
  /// @param says  one paragraph
  void publish(const GapRecord& gap, const std::string& says);
  void publish(const DaemonStatus& status);

 private:
  struct Impl;
  std::unique_ptr<Impl> impl_;
};

}  // namespace ballbar
