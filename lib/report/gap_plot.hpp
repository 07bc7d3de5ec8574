#pragma once
/// A diagnosis in pictures: one circle before and after, what is left by arc and condition, the shares.

#include <string>
#include <vector>

#include "report/plot.hpp"

namespace ballbar {

/// One circle in one direction; all vectors are as long as the angles.
struct GapTrace {
  std::string label{};  ///< e.g. "A2+1   90 mm/s   0.4 kg"
  int direction = 0;    ///< > 0 counter-clockwise, < 0 clockwise
  std::vector<double> angle_deg{};
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

/// Measured and predicted over the angle, before and after, one panel a trace, all of one scale.
/// @throws std::invalid_argument if lengths differ
/// @throws Error (kInput) where there is no trace
PlotScript gap_traces_script(const GapPlot& plot);

/// Measured minus predicted as colour, over the angle, one row a trace: above as configured, below with what
/// was left out, both of one scale. Means over 5 degrees.
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
