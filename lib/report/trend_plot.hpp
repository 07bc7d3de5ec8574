#pragma once
/// A figure of many runs over time, with the limits of alarms.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "report/plot.hpp"

namespace ballbar {

struct TrendPoint {
  std::int64_t time_us = 0;  ///< begin of the run, since the epoch
  double value = 0.0;
  std::optional<double> sd;
  std::string series{};
};

/// Points that are joined by a line as far as they are of one series.
struct Trend {
  std::string label{};  ///< legend, e.g. "A counter-clockwise"
  std::string group{};  ///< what colour tells apart; tone and dash tell the directions apart
  int direction = 0;
  std::vector<TrendPoint> points{};  ///< by rising time
};

/// Drawn as a horizontal line.
struct TrendLimit {
  double value = 0.0;   ///< in the value's unit
  std::string whose{};  ///< said in a note; may be empty
};

struct TrendPlot {
  std::string title{};
  std::string subtitle{};
  std::string value_label{};  ///< with unit, e.g. "ovality [um]"
  bool by_run = false;        ///< one step a run instead of time, where series lie days apart
  std::vector<Trend> trends{};
  std::vector<TrendLimit> limits{};
  std::vector<std::string> notes{};
};

/// Values over time (UTC) with +- sd where it is known. A vertical line stands where a series begins, with
/// its name; a name that finds no room is a number, explained in a note.
///
/// @throws Error (kInput) if no point is finite
PlotScript trend_script(const TrendPlot& plot);

}  // namespace ballbar
