#pragma once
/// Ovality vectors on their plane: how far two of them lie apart, which their lengths alone do not tell.

#include <Eigen/Core>
#include <string>
#include <vector>

#include "report/plot.hpp"

namespace ballbar {

/// Repetitions of one series, test and direction.
struct OvalityVectors {
  std::string label{};  ///< legend
  std::string group{};  ///< what colour tells apart; tone and dash tell the directions apart
  int direction = 0;
  std::vector<Eigen::Vector2d> vectors_um{};  ///< [um] cos, sin of harmonic 2, one per repetition
};

struct OvalityPlot {
  std::string title{};
  std::string subtitle{};
  std::vector<OvalityVectors> sets{};
  std::vector<std::string> notes{};
};

/// Vectors of the means from the origin, the repetitions as points and, from three of them on, the ellipse
/// that holds the true mean in 95 % of all cases (Hotelling's T^2, metrology.md 2). Where the scatter is too
/// small to be seen, repetitions and ellipses are drawn 2, 5, 10, ... times as far from their mean, and a
/// note says so.
///
/// @throws Error (kInput) if no vector is finite
PlotScript ovality_script(const OvalityPlot& plot);

}  // namespace ballbar
