#pragma once
/// LCM logs as files: what they hold, and where they are damaged, before liblcm reads them.

#include <cstdint>
#include <string>

namespace ballbar {

inline constexpr std::uint32_t kLogSync = 0xEDA1DA01;  ///< each event of a log begins so

struct LogFile {
  std::string path;
  std::string url;              ///< for Subscriber: read as fast as it can be read
  std::int64_t events = 0;      ///< whole ones
  std::int64_t bytes = 0;       ///< of the file
  std::int64_t good_bytes = 0;  ///< up to the first that is no event: liblcm reads no further
  double recorded_s = 0.0;      ///< from the first event to the last

  bool whole() const { return good_bytes == bytes; }
};

/// Walks over the whole log, header by header.
/// @throws Error(kInput) where the file cannot be read, holds no event, or its path holds a '?', which an LCM
/// URL cannot
LogFile inspect_log(const std::string& path);

}  // namespace ballbar
