#pragma once
/// An LCM log through the same path as live data.

#include <functional>
#include <string>

#include "bus/assembler.hpp"
#include "daemon/service.hpp"

namespace ballbar {

struct ReplayOutcome {
  AssemblerCounters messages;
  std::int64_t first_us = 0, last_us = 0;  ///< time of the log's first and last message
};

/// Reads the whole log as fast as it can be read; runs go to `service`. What is open at its end is closed.
/// @param progress  called now and then with the seconds of recording that were read; may be empty
/// @throws Error(kInput) where the file is no log
ReplayOutcome replay(const std::string& log_path, Service& service,
                     const std::function<void(double recorded_s)>& progress = {});

}  // namespace ballbar
