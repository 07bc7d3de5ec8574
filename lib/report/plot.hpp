#pragma once
/// Plots as gnuplot scripts: data in, text out. render() hands the text to gnuplot.
///
/// Names and titles may hold anything: quotes, line breaks, markup and broken UTF-8 are made harmless here.

#include <string>
#include <vector>

namespace ballbar {

/// One circle as the bar saw it. Samples that are not finite interrupt the line.
struct PolarTrace {
  std::string label{};                 ///< legend, e.g. "A+1#1"
  int direction = 0;                   ///< +1 counter-clockwise, -1 clockwise, 0 not known
  std::vector<double> angle_rad{};     ///< [rad] counter-clockwise from the plane's first axis
  std::vector<double> deviation_um{};  ///< [um] bar length - nominal length; one per angle
  bool predicted = false;              ///< by the model: thin and dotted
  std::string group{};                 ///< what colour tells apart, e.g. the series; stands in the legend
};

struct PolarPlot {
  std::string title{};     ///< first line, e.g. "lrmate-1   test A"
  std::string subtitle{};  ///< second line, e.g. series and date; may be empty
  std::vector<PolarTrace> traces{};
  std::vector<std::string> notes{};  ///< lines below the picture, e.g. the figures; the first six are shown
};

/// One pass over a line.
struct LineTrace {
  std::string label{};
  int direction = 0;                   ///< +1 forward, -1 backward, 0 not known
  std::vector<double> position_mm{};   ///< [mm] along the line, from its start
  std::vector<double> deviation_um{};  ///< [um] one per position
  bool predicted = false;              ///< by the model: thin and dotted
  std::string group{};                 ///< as for PolarTrace
};

struct LinePlot {
  std::string title{};
  std::string subtitle{};
  std::string axis{};  ///< direction of the deviation, e.g. "X"; may be empty
  std::vector<LineTrace> traces{};
  std::vector<std::string> notes{};  ///< lines below the picture; the first six are shown
};

/// A picture that gnuplot can draw: everything but the terminal, which render() chooses.
struct PlotScript {
  int width = 0;   ///< [px]
  int height = 0;  ///< [px]
  std::string text{};
};

/// Scale of a polar plot [um/div]: the smallest of 1, 2, 5 x 10^n, at least 0.1, with which the largest
/// deviation stays within `divisions` of the nominal circle.
///
/// @throws std::invalid_argument if largest_um is not finite or is negative, or divisions is not above 0
double scale_um_per_division(double largest_um, int divisions);

/// Polar plot about the nominal circle. Where all traces are of one group, blue and solid is
/// counter-clockwise, orange and dashed clockwise, and more than three traces of one direction are drawn as a
/// bundle with one entry in the legend. Where there are several groups, each has its colour, clockwise
/// lighter and dashed, and a bundle for each direction. What the model predicts is thin, dotted and grey.
/// Curves are thinned to what the eye can tell apart.
///
/// @throws std::invalid_argument if the lengths of a trace differ
/// @throws Error (kInput) if no trace holds a finite sample
PlotScript polar_script(const PolarPlot& plot);

/// Deviation over position: forward solid, backward dashed; colours as for polar_script().
///
/// @throws std::invalid_argument if the lengths of a trace differ
/// @throws Error (kInput) if no trace holds a finite sample
PlotScript line_script(const LinePlot& plot);

/// Draws the script with gnuplot into `path`, as SVG or PNG by its ending. What stood there is replaced only
/// when the picture is complete.
///
/// @throws Error (kInput) for another ending
/// @throws Error (kWorld) if gnuplot is missing or fails, or the file cannot be written
void render(const PlotScript& script, const std::string& path);

/// The same as the text of an SVG, to stand in a page.
///
/// @throws Error (kWorld) if gnuplot is missing or fails
std::string svg_of(const PlotScript& script);

}  // namespace ballbar
