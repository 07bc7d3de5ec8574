#pragma once
/// A diagnosis in pictures: one circle or line before and after, what is left by arc and condition, the
/// shares.

#include <string>
#include <vector>

#include "report/plot.hpp"

namespace ballbar {

/// One circle or line in one direction; all vectors are as long as the places.
struct GapTrace {
  std::string label{};  ///< e.g. "A2+1   90 mm/s   0.4 kg"
  int direction = 0;    ///< > 0 counter-clockwise or forward, < 0 clockwise or backward
  bool line = false;
  std::vector<double> place{};  ///< [deg] on a circle, [mm] on a line, from its start
  std::vector<double> measured_um{};
  std::vector<double> before_um{};  ///< predicted by the model as configured
  std::vector<double> after_um{};   ///< predicted with what was left out
};

struct GapPlot {
  std::string title{};
  std::string subtitle{};
  std::vector<GapTrace> traces{};
  std::vector<std::string> notes{};
};

/// Measured and predicted over angle or position, before and after, one panel a trace, all of one scale.
/// @throws std::invalid_argument if lengths differ, or circles and lines are mixed
/// @throws Error (kInput) where there is no trace
PlotScript gap_traces_script(const GapPlot& plot);

/// Measured minus predicted as colour, over angle or position, one row a trace: above as configured, below
/// with what was left out, both of one scale. Means over 5 degrees, or over 72 parts of the longest line.
/// @throws as gap_traces_script()
PlotScript gap_map_script(const GapPlot& plot);

struct GapShare {
  std::string label{};  ///< e.g. "joint_lost_motion backlash J2"
  double share = 0.0;   ///< of the mismatch, 0..1
  double size_um = 0.0;
};

/// Bars, in the sequence given from above.
/// @throws Error (kInput) where there is none
PlotScript gap_shares_script(const std::string& title, const std::string& subtitle,
                             const std::vector<GapShare>& shares);

}  // namespace ballbar
