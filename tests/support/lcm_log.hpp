#pragma once
/// LCM logs made from other ones.

#include <ballbar/test_mark_t.hpp>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <stdexcept>
#include <string>

#include "support/messages.hpp"

namespace ballbar::test {

/// Copies a log with other marks. @param change  may change a mark; false leaves it out
inline void copy_log(const std::string& from, const std::string& to,
                     const std::function<bool(test_mark_t&)>& change) {
  lcm::LogFile in(from, "r"), out(to, "w");
  if (!in.good() || !out.good()) throw std::runtime_error("cannot copy " + from + " to " + to);
  while (const lcm::LogEvent* event = in.readNextEvent()) {
    lcm::LogEvent copy = *event;
    std::vector<std::uint8_t> bytes;
    if (event->channel == "TEST_MARK") {
      test_mark_t mark;
      if (mark.decode(event->data, 0, event->datalen) < 0)
        throw std::runtime_error("a mark of " + from + " is damaged");
      if (!change(mark)) continue;
      bytes = bytes_of(mark);
      copy.data = bytes.data();
      copy.datalen = static_cast<std::int32_t>(bytes.size());
    }
    out.writeEvent(&copy);
  }
}

}  // namespace ballbar::test
