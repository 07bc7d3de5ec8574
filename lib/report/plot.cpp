#include "report/plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <map>
#include <stdexcept>
#include <string_view>
#include <utility>

#include "core/error.hpp"
#include "core/units.hpp"
#include "report/canvas.hpp"
#include "report/gnuplot_text.hpp"
#include "report/thinned.hpp"

namespace ballbar {
namespace {

constexpr int kPolarDrawing = 690;  // [px] height of rings and angle labels
constexpr int kLineDrawing = 380;   // [px] height of the axes
constexpr int kNominal = 6;         // [div] radius at which the nominal circle is drawn
constexpr int kMostDivisions = 4;   // [div] that a deviation may take up on either side of it
constexpr double kThinPx = 0.45;    // [px] that a thinned curve may be off: less than half a line

/// What a polar plot and a line plot have in common: curves in picture coordinates.
struct Curve {
  std::string label;
  std::string group;
  int direction = 0;
  bool predicted = false;
  std::string points;  // rows "x y"; a blank row interrupts the line
};

struct Words {
  std::string_view positive, negative;
};

/// Curves and how they are told apart.
struct Drawing {
  std::vector<Curve> curves;
  Groups groups;
  std::map<std::pair<std::size_t, int>, std::size_t> runs;  // measured ones, by group and direction

  /// A trace without a finite sample is left out, from the legend too.
  template <typename Trace>
  void add(const Trace& trace, std::string points) {
    if (points.find_first_not_of('\n') == std::string::npos) return;
    const int direction = (trace.direction > 0) - (trace.direction < 0);
    const std::size_t group = groups.of(trace.group);
    if (!trace.predicted) ++runs[{group, direction}];
    curves.push_back({trace.label, trace.group, direction, trace.predicted, std::move(points)});
  }

  /// Runs alike in one stroke: shades of a colour are there for few runs of a single group.
  bool is_bundle(std::size_t group, int direction) const {
    const auto found = runs.find({group, direction});
    return found != runs.end() && found->second > (groups.size() > 1 ? 1 : kMostOwn);
  }

  /// Entries that the legend will have: one a trace, or one a bundle.
  std::size_t legend_entries() const {
    auto entries = static_cast<std::size_t>(
        std::count_if(curves.begin(), curves.end(), [](const Curve& c) { return c.predicted; }));
    for (const auto& [key, count] : runs) entries += is_bundle(key.first, key.second) ? 1 : count;
    return entries;
  }
};

std::string_view way(int direction, const Words& words) {
  return direction > 0 ? words.positive : direction < 0 ? words.negative : "direction not known";
}

std::string plot_command(Drawing& drawing, const Words& words, std::string_view with) {
  std::string blocks;
  std::string text = "plot";
  std::map<std::pair<std::size_t, int>, std::size_t> seen;
  for (std::size_t i = 0; i < drawing.curves.size(); ++i) {
    const Curve& curve = drawing.curves[i];
    blocks += join({"$trace", std::to_string(i), " << EOD\n", curve.points, "EOD\n"});
    text += join({i == 0 ? " " : ", \\\n     ", "$trace", std::to_string(i), " using 1:2 with "});
    if (curve.predicted) {
      text += join({"lines linecolor rgb '", kInk, "' linewidth 1.2 dashtype (2,4) title ",
                    gnuplot_quoted(curve.label + "   predicted")});
      continue;
    }
    const std::size_t group = drawing.groups.of(curve.group);
    const bool bundle = drawing.is_bundle(group, curve.direction);
    const std::size_t index = seen[{group, curve.direction}]++;
    const Stroke stroke = stroke_of(drawing.groups.size(), group, curve.direction, bundle ? 0 : index);
    const std::size_t count = drawing.runs[{group, curve.direction}];
    const std::string_view between = curve.group.empty() || !bundle ? "" : "   ";
    const std::string label =
        bundle
            ? join({curve.group, between, way(curve.direction, words), " (", std::to_string(count), " runs)"})
            : join({curve.label, "   ", way(curve.direction, words)});
    text += join({with, with == "lines" ? "" : " pointsize 0.6 pointtype " + std::to_string(stroke.point),
                  " linecolor rgb '", stroke.colour, "' linewidth ", bundle ? "1.1" : "1.8", " dashtype ",
                  stroke.dash, bundle && index > 0 ? " notitle" : " title " + gnuplot_quoted(label)});
  }
  return blocks + text + "\n";
}

void check(const std::vector<double>& x, const std::vector<double>& y) {
  if (x.size() != y.size()) throw std::invalid_argument("plot: a trace has as many positions as deviations");
}

/// Rings, spokes and their labels; one unit of the picture is one division.
std::string polar_grid(double scale, int reach) {
  std::string text;
  for (int ring = -reach; ring <= reach; ++ring) {
    const bool nominal = ring == 0;
    text += join({"set object circle at 0,0 size ", std::to_string(kNominal + ring),
                  " fillstyle empty border rgb '", nominal ? kInk : kGrid, "' linewidth ",
                  nominal ? "1.8" : "0.8", " behind\n"});
  }
  const double outer = kNominal + reach;
  for (int degrees = 0; degrees < 360; degrees += 30) {
    const double x = std::cos(degrees * kRadPerDeg);
    const double y = std::sin(degrees * kRadPerDeg);
    const double inner = kNominal - reach;
    text += join({"set arrow from ", plain_number(inner * x, 5), ",", plain_number(inner * y, 5), " to ",
                  plain_number(outer * x, 5), ",", plain_number(outer * y, 5), " nohead linecolor rgb '",
                  kGrid, "' linewidth 0.8 back\n"});
    text += join({"set label '", std::to_string(degrees), "°' at ", plain_number((outer + 0.62) * x, 5), ",",
                  plain_number((outer + 0.45) * y, 5), " center\n"});
  }
  for (int ring = -reach; ring <= reach; ++ring) {  // along 105 degrees, between two spokes
    const double radius = kNominal + ring;
    const std::string value = (ring > 0   ? "+"
                               : ring < 0 ? "−"
                                          : "") +
                              plain_number(std::abs(ring) * scale, 1);
    text += join({"set label '", value, "' at ", plain_number(radius * std::cos(105 * kRadPerDeg), 5), ",",
                  plain_number(radius * std::sin(105 * kRadPerDeg), 5), " center font ',14' textcolor rgb '",
                  kInk, "' front\n"});
  }
  return text;
}

bool is_finite(double x, double y) { return std::isfinite(x) && std::isfinite(y); }

std::string polar_points(const PolarTrace& trace, double scale, double tolerance) {
  std::string rows;
  std::vector<PlotPoint> stretch;
  const auto flush = [&] {
    for (const PlotPoint& p : thinned(stretch, tolerance))
      rows += plain_number(p.x, 4) + " " + plain_number(p.y, 4) + "\n";
    stretch.clear();
  };
  for (std::size_t i = 0; i < trace.angle_rad.size(); ++i) {
    const double angle = trace.angle_rad[i];
    const double radius = kNominal + trace.deviation_um[i] / scale;
    if (is_finite(angle, radius)) {
      stretch.push_back({radius * std::cos(angle), radius * std::sin(angle)});
      continue;
    }
    flush();
    rows += "\n";
  }
  flush();
  return rows;
}

std::string line_points(const LineTrace& trace) {
  check(trace.position_mm, trace.deviation_um);
  std::string rows;
  for (std::size_t i = 0; i < trace.position_mm.size(); ++i) {
    if (is_finite(trace.position_mm[i], trace.deviation_um[i]))
      rows += plain_number(trace.position_mm[i], 4) + " " + plain_number(trace.deviation_um[i], 4);
    rows += "\n";
  }
  return rows;
}

}  // namespace

double scale_um_per_division(double largest_um, int divisions) {
  if (!std::isfinite(largest_um) || largest_um < 0 || divisions <= 0)
    throw std::invalid_argument(
        "scale_um_per_division: a finite deviation and a number of divisions above 0");
  constexpr std::array<double, 3> steps{1.0, 2.0, 5.0};
  for (int decade = -1; decade <= 300; ++decade) {
    for (const double step : steps) {
      const double scale = decade < 0 ? step / 10.0 : step * std::pow(10.0, decade);
      if (largest_um <= scale * divisions) return scale;
    }
  }
  return 5e300;
}

PlotScript polar_script(const PolarPlot& plot) {
  double largest_um = -1.0;
  for (const PolarTrace& trace : plot.traces) {
    check(trace.angle_rad, trace.deviation_um);
    for (std::size_t i = 0; i < trace.angle_rad.size(); ++i)
      if (is_finite(trace.angle_rad[i], trace.deviation_um[i]))
        largest_um = std::max(largest_um, std::abs(trace.deviation_um[i]));
  }
  if (largest_um < 0) throw Error(Cause::kInput, "plot: no sample has an angle, so there is no polar plot");
  const double scale = scale_um_per_division(largest_um, kMostDivisions);
  const int reach = std::max(2, static_cast<int>(std::ceil(largest_um / scale)));
  const double half_width = kNominal + reach + 1.2;  // [div]
  const double tolerance = kThinPx * 2 * half_width / kPolarDrawing;
  Drawing drawing;
  for (const PolarTrace& trace : plot.traces) drawing.add(trace, polar_points(trace, scale, tolerance));

  PlotScript script =
      canvas(plot.title, plot.subtitle, plot.notes, drawing.legend_entries(), kPolarDrawing, 10);
  const std::string limit = plain_number(half_width, 1);
  script.text += "unset border\nunset tics\nset size ratio -1\n";
  script.text += "set xrange [-" + limit + ":" + limit + "]\nset yrange [-" + limit + ":" + limit + "]\n";
  script.text += polar_grid(scale, reach);
  script.text += "set label 'scale' at 0,0.45 center textcolor rgb '" + std::string(kInk) + "'\n";
  script.text += "set label '" + plain_number(scale, 1) + " µm/div' at 0,-0.45 center font ',21'\n";
  script.text += plot_command(drawing, {"counter-clockwise", "clockwise"}, "lines");
  return script;
}

PlotScript line_script(const LinePlot& plot) {
  Drawing drawing;
  for (const LineTrace& trace : plot.traces) drawing.add(trace, line_points(trace));
  if (drawing.curves.empty()) throw Error(Cause::kInput, "plot: no readings, so there is no line plot");

  PlotScript script =
      canvas(plot.title, plot.subtitle, plot.notes, drawing.legend_entries(), kLineDrawing, kAxis);
  script.text +=
      axes("position along the line [mm]", (plot.axis.empty() ? "" : plot.axis + " ") + "deviation [µm]");
  script.text += "set xrange [*:*] noextend\nset offsets graph 0.02,graph 0.02,0,0\n";
  script.text += plot_command(drawing, {"forward", "backward"}, "linespoints");
  return script;
}

}  // namespace ballbar
