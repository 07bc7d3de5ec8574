#pragma once
/// One line per event on standard error, with the journal's priority where systemd reads it.

#include <cstdint>
#include <optional>
#include <string>

namespace ballbar {

enum class Priority { kError = 3, kWarning = 4, kNotice = 5, kInfo = 6 };

/// How many lines may still be written: whoever can send messages could else fill the journal. A burst, and
/// so many a second for ever.
class LineBudget {
 public:
  static constexpr std::int64_t kBurst = 200;
  static constexpr std::uint64_t kEveryUs = 500'000;

  /// @param now_us  steady clock
  /// @return whether a line may be written, and then how many were left out since the last one
  std::optional<std::int64_t> take(std::uint64_t now_us);

 private:
  std::int64_t left_ = kBurst;
  std::int64_t left_out_ = 0;
  std::uint64_t filled_us_ = 0;
};

/// Writes one line, while there is room for lines of its kind (errors; all others); line breaks and control
/// characters from outside become blanks.
void log_line(Priority priority, std::string text);

}  // namespace ballbar
