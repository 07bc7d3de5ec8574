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
#include "report/gnuplot_text.hpp"

namespace ballbar {
namespace {

constexpr int kWidth = 720;  // [px] the fonts below are chosen for it: readable at half the size, on a phone
constexpr int kPolarDrawing = 690;  // [px] height of rings and angle labels
constexpr int kLineDrawing = 380;   // [px] height of the axes
constexpr int kTop = 74;            // [px] title and subtitle
constexpr int kRow = 26;            // [px] of legend and notes
constexpr int kSmallestFont = 9;    // [px]
constexpr int kNominal = 6;         // [div] radius at which the nominal circle is drawn
constexpr int kMostDivisions = 4;   // [div] that a deviation may take up on either side of it
constexpr std::size_t kMostOwn =
    3;  // traces of one direction that get a shade and a legend entry of their own
constexpr std::size_t kMostNotes = 4;

/// Okabe and Ito's colours, told apart with every kind of colour vision, and shades of them.
using Shades = std::array<std::string_view, kMostOwn>;
constexpr Shades kPositive{"#0072B2", "#56B4E9", "#003B5C"};
constexpr Shades kNegative{"#D55E00", "#E69F00", "#7A3500"};
constexpr Shades kUnknown{"#333333", "#888888", "#000000"};
constexpr std::string_view kGrid = "#C8C8C8";
constexpr std::string_view kInk = "#404040";

struct Style {
  Shades shades;
  std::string_view dash;
  int point;  // gnuplot's point type: 7 filled circle, 4 open square, 2 cross
};

Style style_of(int direction) {
  if (direction > 0) return {kPositive, "solid", 7};
  if (direction < 0) return {kNegative, "(14,5)", 4};
  return {kUnknown, "(3,4)", 2};
}

/// What a polar plot and a line plot have in common: curves in picture coordinates.
struct Curve {
  std::string_view label;
  int direction = 0;
  bool predicted = false;
  std::string points;  // rows "x y"; a blank row interrupts the line
};

struct Words {
  std::string_view positive, negative;
};

std::string join(std::initializer_list<std::string_view> parts) {
  std::string all;
  for (const std::string_view part : parts) all += part;
  return all;
}

std::size_t count_of(const std::vector<Curve>& curves, int direction) {
  return static_cast<std::size_t>(std::count_if(curves.begin(), curves.end(), [&](const Curve& c) {
    return !c.predicted && c.direction == direction;
  }));
}

std::string legend_label(const Curve& curve, std::size_t runs, const Words& words) {
  if (curve.predicted) return join({curve.label, "   predicted"});
  const std::string_view way = curve.direction > 0   ? words.positive
                               : curve.direction < 0 ? words.negative
                                                     : "direction not known";
  if (runs > kMostOwn) return join({way, " (", std::to_string(runs), " runs)"});
  return join({curve.label, "   ", way});
}

/// Entries that the legend will have: one a trace, or one a bundle.
std::size_t legend_entries(const std::vector<Curve>& curves) {
  auto entries = static_cast<std::size_t>(
      std::count_if(curves.begin(), curves.end(), [](const Curve& c) { return c.predicted; }));
  for (const int direction : {1, -1, 0}) {
    const std::size_t runs = count_of(curves, direction);
    entries += runs > kMostOwn ? 1 : runs;
  }
  return entries;
}

std::string data_blocks(const std::vector<Curve>& curves) {
  std::string text;
  for (std::size_t i = 0; i < curves.size(); ++i)
    text += join({"$trace", std::to_string(i), " << EOD\n", curves[i].points, "EOD\n"});
  return text;
}

std::string plot_command(const std::vector<Curve>& curves, const Words& words, std::string_view with) {
  std::string text = "plot";
  std::map<int, std::size_t> seen;  // by direction
  for (std::size_t i = 0; i < curves.size(); ++i) {
    const int direction = curves[i].direction;
    if (curves[i].predicted) {
      text += join({i == 0 ? " " : ", \\\n     ", "$trace", std::to_string(i),
                    " using 1:2 with lines linecolor rgb '", kInk, "' linewidth 1.2 dashtype (2,4) title ",
                    gnuplot_quoted(legend_label(curves[i], 0, words))});
      continue;
    }
    const Style style = style_of(direction);
    const std::size_t runs = count_of(curves, direction);
    const bool bundle = runs > kMostOwn;
    const std::size_t index = seen[direction]++;
    const std::string_view colour = style.shades.at(bundle ? 0 : index);
    const bool listed = !bundle || index == 0;
    const std::string title =
        listed ? "title " + gnuplot_quoted(legend_label(curves[i], runs, words)) : "notitle";
    text += join({i == 0 ? " " : ", \\\n     ", "$trace", std::to_string(i), " using 1:2 with ", with,
                  with == "lines" ? "" : " pointsize 0.6 pointtype " + std::to_string(style.point),
                  " linecolor rgb '", colour, "' linewidth ", bundle ? "1.1" : "1.8", " dashtype ",
                  style.dash, " ", title});
  }
  return text + "\n";
}

int sign(int direction) { return (direction > 0) - (direction < 0); }

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

std::string polar_points(const PolarTrace& trace, double scale) {
  std::string rows;
  for (std::size_t i = 0; i < trace.angle_rad.size(); ++i) {
    const double angle = trace.angle_rad[i];
    const double radius = kNominal + trace.deviation_um[i] / scale;
    if (is_finite(angle, radius))
      rows += plain_number(radius * std::cos(angle), 4) + " " + plain_number(radius * std::sin(angle), 4);
    rows += "\n";
  }
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

/// A trace without a finite sample is left out, from the legend too.
template <typename Trace>
void add_curve(std::vector<Curve>& curves, const Trace& trace, std::string points) {
  if (points.find_first_not_of('\n') != std::string::npos)
    curves.push_back({trace.label, sign(trace.direction), trace.predicted, std::move(points)});
}

/// Text in the middle of the width, in `wanted_px` or smaller, so that it fits.
std::string centred(std::string_view text, const std::string& place, int wanted_px) {
  constexpr double kCharacterWidth = 0.5;  // of the font's height, mean of DejaVu Sans
  const auto characters =
      std::count_if(text.begin(), text.end(), [](unsigned char c) { return (c & 0xC0U) != 0x80U; });
  const double fitting =
      (kWidth - 16) / (kCharacterWidth * static_cast<double>(std::max<std::ptrdiff_t>(characters, 1)));
  const int size = fitting > wanted_px ? wanted_px : std::max(static_cast<int>(fitting), kSmallestFont);
  return "set label " + gnuplot_quoted(text) + " at screen 0.5," + place + " center font '," +
         std::to_string(size) + "'\n";
}

/// The common frame, from above: title, subtitle, drawing, `axis_px` for its labels, legend in two columns,
/// notes.
PlotScript canvas(const std::string& title, const std::string& subtitle,
                  const std::vector<std::string>& notes, const std::vector<Curve>& curves, int drawing_px,
                  int axis_px) {
  const int note_rows = static_cast<int>(std::min(notes.size(), kMostNotes));
  const int legend_rows = static_cast<int>(legend_entries(curves));
  const int bottom = axis_px + kRow * (legend_rows + note_rows);
  PlotScript script{kWidth, kTop + drawing_px + bottom, "set encoding utf8\n"};
  const auto screen = [&](double px_from_below) {
    return "screen " + plain_number(px_from_below / script.height, 4);
  };

  const double top = script.height;
  script.text += centred(title, screen(top - 26), 22) + centred(subtitle, screen(top - 54), 17);
  for (int i = 0; i < note_rows; ++i)
    script.text += centred(notes[static_cast<std::size_t>(i)], screen(16 + kRow * (note_rows - 1 - i)), 16);
  script.text += "set bmargin at " + screen(bottom) + "\nset tmargin at " + screen(top - kTop) + "\n";
  script.text += "set key at screen 0.5," + screen(8 + kRow * note_rows) +
                 " center bottom vertical Left reverse samplen 3 maxcols 1 spacing 1.1\n";
  return script;
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
  std::vector<Curve> curves;
  for (const PolarTrace& trace : plot.traces) add_curve(curves, trace, polar_points(trace, scale));

  PlotScript script = canvas(plot.title, plot.subtitle, plot.notes, curves, kPolarDrawing, 10);
  const std::string limit = plain_number(kNominal + reach + 1.2, 1);
  script.text += "unset border\nunset tics\nset size ratio -1\n";
  script.text += "set xrange [-" + limit + ":" + limit + "]\nset yrange [-" + limit + ":" + limit + "]\n";
  script.text += polar_grid(scale, reach);
  script.text += "set label 'scale' at 0,0.45 center textcolor rgb '" + std::string(kInk) + "'\n";
  script.text += "set label '" + plain_number(scale, 1) + " µm/div' at 0,-0.45 center font ',21'\n";
  script.text += data_blocks(curves) + plot_command(curves, {"counter-clockwise", "clockwise"}, "lines");
  return script;
}

PlotScript line_script(const LinePlot& plot) {
  std::vector<Curve> curves;
  for (const LineTrace& trace : plot.traces) add_curve(curves, trace, line_points(trace));
  if (curves.empty()) throw Error(Cause::kInput, "plot: no readings, so there is no line plot");

  PlotScript script = canvas(plot.title, plot.subtitle, plot.notes, curves, kLineDrawing, 74);
  const std::string ink(kInk);
  script.text += "set lmargin at screen 0.13\nset rmargin at screen 0.96\n";
  script.text += "set border 3 linecolor rgb '" + ink + "'\nset tics nomirror\n";
  script.text += "set grid linecolor rgb '" + std::string(kGrid) + "' linewidth 0.8 dashtype solid\n";
  script.text += "set xzeroaxis linecolor rgb '" + ink + "' linewidth 1.2 dashtype solid\n";
  script.text += "set xrange [*:*] noextend\nset offsets graph 0.02,graph 0.02,0,0\n";
  script.text += "set xlabel 'position along the line [mm]'\n";
  script.text +=
      "set ylabel " + gnuplot_quoted((plot.axis.empty() ? "" : plot.axis + " ") + "deviation [µm]") + "\n";
  script.text += data_blocks(curves) + plot_command(curves, {"forward", "backward"}, "linespoints");
  return script;
}

}  // namespace ballbar
