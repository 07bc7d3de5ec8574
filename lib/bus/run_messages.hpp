#pragma once
/// A Run back into the messages that it was assembled of.

#include <map>
#include <string>
#include <utility>
#include <vector>

#include "bus/channels.hpp"
#include "core/run.hpp"
#include "core/samples.hpp"

namespace ballbar {

/// Numbers the messages of each channel and robot from 1, over all runs that it is given.
class RunMessages {
 public:
  /// Begin mark, samples in sequence of time, end mark (or abort mark). Each sample is a message of its own,
  /// so that times to the microsecond come back as they were; messages that were lost stay lost, without a
  /// hole in the numbers.
  /// @param run  that ended with a mark (RunEnd::kMark or kAborted)
  /// @throws std::invalid_argument for a run that ended otherwise: a log could not say how
  std::vector<Sample> of(const Run& run);

 private:
  SampleHeader header(const Run& run, Channel channel, double time);

  std::map<std::pair<std::string, Channel>, std::int64_t> sent_;
};

}  // namespace ballbar
