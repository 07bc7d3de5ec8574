#pragma once
/// LCM logs as lcm-logger writes them.

#include <cstdint>
#include <cstdio>
#include <string>

#include "bus/encode.hpp"

namespace ballbar {

/// A log under a name of its own until it is complete: without keep() nothing is left of it, and what stood
/// at `path` stays.
class LogWriter {
 public:
  /// @throws Error(kInput) where the path holds a '?', which an LCM URL cannot
  /// @throws Error(kWorld) where the folder cannot be written
  explicit LogWriter(const std::string& path);
  ~LogWriter();
  LogWriter(const LogWriter&) = delete;
  LogWriter& operator=(const LogWriter&) = delete;

  /// @param arrival_us  microseconds since the epoch; must not fall from event to event
  /// @throws Error(kWorld) where the disk is full
  void write(const Encoded& message, std::int64_t arrival_us);

  /// Gives the log its name; what stood there is replaced.
  /// @throws Error(kWorld) where the disk is full
  void keep();

  std::int64_t events() const { return events_; }

 private:
  [[noreturn]] void fail() const;

  std::string path_, draft_;
  std::FILE* file_ = nullptr;
  std::int64_t events_ = 0;
};

}  // namespace ballbar
