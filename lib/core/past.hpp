#pragma once
/// Earlier results as rules ask for them: labels of a window, and one figure of all its results at a time.

#include <string>
#include <vector>

#include "core/result.hpp"

namespace ballbar {

inline constexpr std::size_t kPastRecent = 200;  ///< results in the window "recent", the newest
inline constexpr std::size_t kPastFirst = 100;   ///< results in every other window, the oldest

/// The earlier "ok" results of one subject (same robot, test, direction, axis and source), without the one
/// being judged. Every window is bounded, so that looking back costs the same however long the history is.
class Past {
 public:
  Past() = default;
  Past(const Past&) = delete;
  Past& operator=(const Past&) = delete;
  virtual ~Past() = default;

  /// Labels, oldest first; figures are read by column().
  /// @param which  "recent" (of all series), "series" (the first of the same series), "first" (of all),
  ///               "calibration" (the first since the latest mark, else as "first") or "series NAME"
  virtual const std::vector<Record>& window(const std::string& which) = 0;

  /// A figure of each of window(which); NaN where a result does not have it.
  virtual const std::vector<double>& column(const std::string& which, const std::string& name) = 0;
};

}  // namespace ballbar
