#pragma once
/// Stored runs as pictures: which run becomes which curve, in which colour, with which words.

#include <string>
#include <vector>

#include "report/plot.hpp"
#include "rules/rule.hpp"
#include "store/store.hpp"

namespace ballbar {

enum class PictureKind { kPolar, kLine, kHarmonics, kTrend, kOvality };

struct PictureOptions {
  std::string axis;               ///< lines: only this direction of deviation; empty: the only one
  bool measured_only = false;     ///< without predictions
  int first_order = 2;            ///< harmonics: order 1 is the ball's set-up
  std::string quantity;           ///< trend: a name of the catalogue; empty: by the kind of the runs
  std::vector<double> limits_um;  ///< trend: limits [um] to be drawn beside those of rules
  std::vector<Rule> rules;        ///< trend: whose limits of the quantity are drawn
  bool by_run = false;            ///< trend: one step a run instead of time
  std::vector<std::int64_t>
      marked;                      ///< trend: started_us of runs that are drawn once more, in another colour
  std::string marked_label;        ///< trend: what the legend calls those
  std::vector<std::string> notes;  ///< trend: below the picture
};

/// Ways to say a direction: "counter-clockwise", "forward", ...
const char* way_of(TestKind kind, int direction);

/// What tells runs apart: robot, series, test and source, as far as they differ among `runs`.
class Apart {
 public:
  explicit Apart(const std::vector<StoredRun>& runs);
  /// E.g. "before B"; "" where all runs are alike. @param with_series  false: without the series
  std::string group(const StoredRun& run, bool with_series = true) const;

 private:
  bool robots_ = false, series_ = false, tests_ = false, sources_ = false;
};

/// @param runs  at least one, with their figures; those of the wrong kind for the picture are left out
/// @throws Error(kInput) where nothing is left to be drawn, or a choice does not fit
PlotScript picture_of(PictureKind kind, const Store& store, const std::vector<StoredRun>& runs,
                      const PictureOptions& options);

/// "ovality_um" as "ovality [µm]".
std::string label_of_quantity(const std::string& name);

}  // namespace ballbar
