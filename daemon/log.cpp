#include "daemon/log.hpp"

#include <cstdio>
#include <cstdlib>

namespace ballbar {

void log_line(Priority priority, std::string text) {
  for (char& c : text)
    if (static_cast<unsigned char>(c) < 0x20 || c == 0x7f) c = ' ';
  static const bool journal = std::getenv("JOURNAL_STREAM") != nullptr;
  const std::string prefix = journal ? "<" + std::to_string(static_cast<int>(priority)) + ">" : "";
  std::fputs((prefix + text + "\n").c_str(), stderr);
}

}  // namespace ballbar
