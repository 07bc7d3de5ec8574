#pragma once
/// LCM logs as files: what they hold, and where they are damaged, before liblcm reads them.

#include <cstdint>
#include <string>

#include "bus/channels.hpp"

namespace ballbar {

inline constexpr std::uint32_t kLogSync = 0xEDA1DA01;  ///< each event of a log begins so

struct LogFile {
  std::string path;
  std::int64_t events = 0;      ///< whole ones
  std::int64_t bytes = 0;       ///< of the file
  std::int64_t good_bytes = 0;  ///< up to the first that is no event: read_log() reads no further
  double recorded_s = 0.0;      ///< from the first event to the last

  bool whole() const { return good_bytes == bytes; }
};

/// Walks over the whole log, header by header.
/// @throws Error(kInput) where the file cannot be read or holds no event
LogFile inspect_log(const std::string& path);

/// Hands on every whole event of the input channels, in sequence. liblcm is never asked for one beyond them:
/// it sets aside as much memory as a damaged header states.
/// @throws Error(kInput) where the file cannot be read any more
void read_log(const LogFile& log, const RawHandler& handler);

}  // namespace ballbar
