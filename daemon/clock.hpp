#pragma once
/// The clocks, for the event loop and for how long a turn of it lasts: all else is told the time.

#include <chrono>
#include <cstdint>

namespace ballbar {

/// [us] for waits: no one can set it.
inline std::uint64_t steady_us() {
  const auto now = std::chrono::steady_clock::now().time_since_epoch();
  return static_cast<std::uint64_t>(std::chrono::duration_cast<std::chrono::microseconds>(now).count());
}

/// [us] since 1970, for people.
inline std::int64_t wall_us() {
  const auto now = std::chrono::system_clock::now().time_since_epoch();
  return std::chrono::duration_cast<std::chrono::microseconds>(now).count();
}

}  // namespace ballbar
