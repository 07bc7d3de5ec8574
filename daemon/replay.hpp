#pragma once
/// An LCM log through the same path as live data.

#include <functional>
#include <string>

#include "bus/assembler.hpp"
#include "bus/log_file.hpp"
#include "daemon/service.hpp"

namespace ballbar {

struct ReplayOutcome {
  AssemblerCounters messages;
};

/// Reads the log as fast as it can be read; runs go to `service`. What is open at its end is closed.
/// @param progress  called now and then with the seconds of recording that were read; may be empty
ReplayOutcome replay(const LogFile& log, Service& service,
                     const std::function<void(double recorded_s)>& progress = {});

}  // namespace ballbar
