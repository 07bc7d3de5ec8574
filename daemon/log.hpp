#pragma once
/// One line per event on standard error, with the journal's priority where systemd reads it.

#include <string>

namespace ballbar {

enum class Priority { kError = 3, kWarning = 4, kNotice = 5, kInfo = 6 };

/// Writes one line; line breaks and control characters from outside become blanks.
void log_line(Priority priority, std::string text);

}  // namespace ballbar
