#pragma once
/// What the joints do while a test is driven.

#include <string>
#include <vector>

#include "report/plot.hpp"

namespace ballbar {

/// One joint. Samples that are not finite interrupt the line.
struct JointTrace {
  std::string label{};              ///< e.g. "J1"
  std::vector<double> place{};      ///< along the test, in the unit that place_label says; rising
  std::vector<double> angle_deg{};  ///< [deg] one per place
};

struct MotionPlot {
  std::string title{};
  std::string subtitle{};     ///< may be empty
  std::string place_label{};  ///< e.g. "angle on the circle [deg]"
  std::vector<JointTrace> joints{};
};

/// Joint angles over the place on the test, each joint with its own colour and dash.
///
/// @throws std::invalid_argument if the lengths of a trace differ
/// @throws Error (kInput) if no trace holds a finite sample
PlotScript motion_script(const MotionPlot& plot);

}  // namespace ballbar
