#pragma once
/// What all pictures share: size, ink, strokes and the frame of title, drawing, legend and notes.

#include <cstddef>
#include <initializer_list>
#include <string>
#include <string_view>
#include <vector>

#include "report/plot.hpp"

namespace ballbar {

inline constexpr int kWidth =
    720;                          ///< [px] the fonts are chosen for it: readable at half the size, on a phone
inline constexpr int kTop = 74;   ///< [px] title and subtitle
inline constexpr int kAxis = 90;  ///< [px] figures and name of an axis
inline constexpr std::size_t kMostOwn = 3;  ///< runs alike that get an entry of the legend each
inline constexpr std::string_view kGrid = "#C8C8C8";
inline constexpr std::string_view kInk = "#404040";
inline constexpr std::string_view kLimit = "#B00020";  ///< limits of alarms

/// How a curve is drawn.
struct Stroke {
  std::string_view colour;  ///< "#rrggbb"
  std::string_view dash;    ///< gnuplot's dashtype
  int point = 0;            ///< gnuplot's point type
};

/// Okabe and Ito's colours, told apart with every kind of colour vision. Where there is one group, colour
/// tells the directions apart, and shades the runs of one direction; else colour tells the groups apart, and
/// tone and dash the directions.
/// @param groups     how many there are
/// @param group      which one, from 0
/// @param direction  > 0, < 0 or 0
/// @param shade      0..kMostOwn - 1, of runs alike; for one group only
Stroke stroke_of(std::size_t groups, std::size_t group, int direction, std::size_t shade = 0);

/// The place of each in the sequence of first appearance.
class Groups {
 public:
  std::size_t of(const std::string& name);  ///< counts it where it is new
  std::size_t size() const { return names_.size(); }

 private:
  std::vector<std::string> names_;
};

std::string join(std::initializer_list<std::string_view> parts);

/// Fixed-point with so many digits after the point, "-" for what is not finite; never follows the locale.
std::string shown(double value, int decimals = 1);

/// Text in the middle of the width, in `wanted_px` or smaller, so that it fits. @param place  gnuplot's y
std::string centred(std::string_view text, const std::string& place, int wanted_px);

/// The common frame, from above: title, subtitle, `above_px` of room, drawing, `axis_px` for its labels,
/// legend, notes.
PlotScript canvas(const std::string& title, const std::string& subtitle,
                  const std::vector<std::string>& notes, std::size_t legend_rows, int drawing_px, int axis_px,
                  int above_px = 0);

/// Border, tics and grid of a drawing with two axes.
std::string axes(const std::string& x_label, const std::string& y_label);

}  // namespace ballbar
