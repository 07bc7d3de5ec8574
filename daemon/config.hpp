#pragma once
/// The TOML configuration: one file, every key known, every value possible, or an error with file, line and
/// column.

#include <filesystem>
#include <string>
#include <vector>

#include "core/spec.hpp"

namespace ballbar {

/// Whom to tell of alarms, beside LCM and the journal.
struct NotifySpec {
  std::vector<std::string> command;  ///< program, by its whole path, and its words; empty: nobody
  double time_limit_s = 30.0;        ///< then it is ended
  double retry_s = 5.0;              ///< pause after a failure; doubled with each one in a row, up to 10 min
  std::string severity = "warning";  ///< the least one that is told
};

struct Config {
  std::string path;  ///< the file it came from
  std::string bus_url = "udpm://239.255.76.67:7667?ttl=0&recv_buf_size=2097152";
  std::string store_path = "/var/lib/ballbard/ballbard.db";
  std::string rules_directory = "/etc/ballbard/rules.d";
  std::string control_socket = "/run/ballbard/control";
  NotifySpec notify;
  bool live_diagnosis = true;         ///< series are diagnosed when they end
  double series_ends_after = 3600.0;  ///< [s] in which nothing more of a series came
  std::string rules_shipped;          ///< empty: none
  int keep_days = 0;                  ///< runs and alarm events older than this are deleted; 0: kept for ever
  int keep_traces_days = 0;           ///< likewise recordings
  int max_size_mb =
      0;  ///< where the database grows larger, the oldest recordings are deleted, then runs; 0: any
  std::string metrics_path;  ///< Prometheus text file; empty: none
  std::vector<RobotSpec> robots;

  /// Shipped ones first: those behind them count more.
  std::vector<std::filesystem::path> rule_folders() const;
  const RobotSpec* find_robot(const std::string& name) const;
};

inline constexpr const char* kDefaultConfig = "/etc/ballbard/ballbard.toml";

/// @throws Error(kInput) "file:line:column: what; what to do" for the first thing that is wrong, and for a
/// file
///         that cannot be read
Config load_config(const std::string& path);

/// The text of a file, e.g. of a URDF.
/// @throws Error(kInput) with path and reason
std::string read_text(const std::string& path);

/// Writes the whole file or leaves what was there.
/// @throws Error(kWorld) with path and reason
void write_text(const std::string& path, const std::string& text);

}  // namespace ballbar
