#pragma once
/// Amplitudes of the harmonics as bars, several series, tests and directions side by side.

#include <optional>
#include <string>
#include <vector>

#include "report/plot.hpp"

namespace ballbar {

struct HarmonicBar {
  int order = 0;
  double amplitude_um = 0.0;    ///< [um] mean over the repetitions
  std::optional<double> sd_um;  ///< [um] of the repetitions, over n - 1; nothing for a single one
};

struct HarmonicBars {
  std::string label{};  ///< legend, e.g. "A counter-clockwise (5 runs)"
  std::string group{};  ///< what colour tells apart; tone tells the directions apart
  int direction = 0;
  std::vector<HarmonicBar> bars{};
};

struct HarmonicsPlot {
  std::string title{};
  std::string subtitle{};
  std::vector<HarmonicBars> sets{};
  std::vector<std::string> notes{};
};

/// Bars by order, with the scatter of the repetitions as error bars (+- sd).
///
/// @throws Error (kInput) if there is no bar
PlotScript harmonics_script(const HarmonicsPlot& plot);

}  // namespace ballbar
