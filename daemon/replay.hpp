#pragma once
/// An LCM log through the same path as live data.

#include <functional>
#include <string>
#include <vector>

#include "bus/assembler.hpp"
#include "bus/log_file.hpp"
#include "daemon/service.hpp"

namespace ballbar {

/// Assembles the runs of a log as the daemon would, as fast as it can be read. What is open at its end is
/// closed.
/// @param take        called once per run, in sequence
/// @param calibrated  called once per mark of a calibration; may be empty
/// @param progress  called now and then with the seconds of recording that were read; may be empty
/// @return what was heard, and what was refused
AssemblerCounters read_runs(const LogFile& log, const std::vector<RobotSpec>& robots, const Models& models,
                            const std::function<void(Run)>& take,
                            const std::function<void(BaselineMark)>& calibrated = {},
                            const std::function<void(double recorded_s)>& progress = {});

struct ReplayOutcome {
  AssemblerCounters messages;
};

/// read_runs() into `service`.
ReplayOutcome replay(const LogFile& log, Service& service,
                     const std::function<void(double recorded_s)>& progress = {});

}  // namespace ballbar
