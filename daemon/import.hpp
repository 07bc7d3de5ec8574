#pragma once
/// Files of instruments into Runs of configured robots: all of them, or an error.

#include <optional>
#include <string>
#include <vector>

#include "core/run.hpp"
#include "daemon/config.hpp"
#include "files/csv.hpp"

namespace ballbar {

inline constexpr std::uintmax_t kMaxImportBytes = 16'000'000;  ///< of one file

/// What the files do not say, as typed.
struct ImportOptions {
  std::vector<std::string> files;
  std::string robot;      ///< empty: the only one
  std::string test;       ///< empty: as the .b5r names it
  std::string direction;  ///< "ccw", "cw", "forward", "backward"; empty for .b5r
  int repetition = 1;     ///< of the first file; each further one counts one more
  std::string series;
  std::string started;  ///< ISO 8601; empty: DATE_STARTED of the .b5r
  std::string axis;     ///< of a line's deviation; empty: a column
  CsvOptions csv;
  double feed_mm_s = 0.0;
  std::optional<double> payload_kg;
  std::optional<double> temperature_c;
  bool with_overshoot = false;
};

struct Import {
  std::string path;
  std::string about;  ///< what the file says of itself, for people
  std::vector<Run> runs;
};

/// Runs of one file begin ten minutes after each other: the file gives one time for all of them, a run is
/// identified by robot and begin, and no circle takes so long.
/// @throws Error(kInput) "FILE: what; what to do" for the first thing that is wrong in any file
std::vector<Import> read_imports(const ImportOptions& options, const Config& config);

/// Are these the same recording? Labels, kind and direction, and the readings to the nanometre.
bool same_recording(const Run& a, const Run& b);

}  // namespace ballbar
