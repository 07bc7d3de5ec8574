#pragma once
/// Results of Renishaw's Ballbar software (.b5r): XML.

#include <string>
#include <string_view>
#include <vector>

namespace ballbar {

/// Stated maximum of one run, in any file.
inline constexpr std::size_t kMaxReadings = 250'000;

struct B5rRun {
  int direction = 0;             ///< +1 counter-clockwise, -1 clockwise
  std::vector<double> readings;  ///< deviations of the bar, in the unit of the file, which it does not state
};

/// What two public readers of such files agree on (metrology.md 1.1); the rest of the file is passed over.
/// Texts are as in the file, empty where it has none.
struct B5rFile {
  std::string plane;         ///< PLANE@TEST_PLANE: "XY", "YZ" or "ZX"
  std::string test;          ///< TEST_SPEC@NAME
  std::string machine;       ///< MACHINE_TESTED@NAME
  std::string started;       ///< DATE_STARTED
  std::string person;        ///< OPERATOR
  std::string serial;        ///< SERIAL_NUMBER of the bar
  std::string calibrated;    ///< LAST_CALIBRATED
  std::vector<B5rRun> runs;  ///< in sequence; each RUN_DIRECTION with the READINGS behind it
};

/// @param bytes  of the whole file
/// @throws Error(kInput) with line where the XML is broken or cut short, is something else, holds no
/// readings, a
///         run without direction, what is no number, or more than kMaxReadings
B5rFile read_b5r(std::string_view bytes);

}  // namespace ballbar
