#include "report/gap_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/error.hpp"
#include "report/canvas.hpp"
#include "report/gnuplot_text.hpp"

namespace ballbar {
namespace {

constexpr int kPanel = 210;        // [px] of a trace
constexpr int kBetween = 34;       // [px] between panels
constexpr int kMapRow = 17;        // [px] of the map
constexpr std::size_t kBins = 72;  // of the map over a turn
constexpr int kBar = 40;           // [px] of a share

void check(const GapPlot& plot) {
  if (plot.traces.empty())
    throw Error(Cause::kInput, "plot: no circle or line, so there is no picture of the gap");
  for (const GapTrace& t : plot.traces) {
    if (t.line != plot.traces.front().line)
      throw std::invalid_argument("plot: circles and lines have no axis in common");
    if (t.measured_um.size() != t.place.size() || t.before_um.size() != t.place.size() ||
        t.after_um.size() != t.place.size())
      throw std::invalid_argument("plot: a circle or line before and after has as many values as places");
  }
}

const char* axis_of(const GapPlot& plot) {
  return plot.traces.front().line ? "position [mm]" : "angle [deg]";
}

/// What the map spans [deg] or [mm].
double span_of(const GapPlot& plot) {
  double span = plot.traces.front().line ? 1.0 : 360.0;
  if (plot.traces.front().line)
    for (const GapTrace& t : plot.traces)
      for (const double place : t.place)
        if (std::isfinite(place)) span = std::max(span, place);
  return span;
}

std::string rows_of(const std::vector<double>& x, const std::vector<double>& y) {
  std::string rows;
  for (std::size_t i = 0; i < x.size(); ++i) {
    if (std::isfinite(x[i]) && std::isfinite(y[i]))
      rows += plain_number(x[i], 2) + " " + plain_number(y[i], 3);
    rows += "\n";
  }
  return rows;
}

/// Top and bottom margin of a panel. @param from,to  [px] from below
std::string between(double from, double to, int height) {
  return join({"set bmargin at screen ", plain_number(from / height, 4), "\nset tmargin at screen ",
               plain_number(to / height, 4), "\n"});
}

std::string panel_title(const std::string& text) {
  return "set title " + gnuplot_quoted(text) + " font ',16' offset 0,-0.6\n";
}

struct Range {
  double low = std::numeric_limits<double>::infinity(), high = -low;
  void take(const std::vector<double>& values) {
    for (const double v : values)
      if (std::isfinite(v)) low = std::min(low, v), high = std::max(high, v);
  }
};

/// Means over equal parts of a turn, or of a line; NaN where nothing lies.
std::array<double, kBins> binned(const GapTrace& trace, const std::vector<double>& predicted_um,
                                 double span) {
  std::array<double, kBins> sum{}, count{};
  for (std::size_t i = 0; i < trace.place.size(); ++i) {
    const double share = trace.place[i] / span;
    const double left = trace.measured_um[i] - predicted_um[i];
    if (!std::isfinite(share) || !std::isfinite(left)) continue;
    const double inside = trace.line ? std::clamp(share, 0.0, 1.0) : share - std::floor(share);
    const auto bin = std::min(kBins - 1, static_cast<std::size_t>(inside * kBins));
    sum.at(bin) += left;
    count.at(bin) += 1.0;
  }
  for (std::size_t k = 0; k < kBins; ++k)
    sum.at(k) = count.at(k) > 0.0 ? sum.at(k) / count.at(k) : std::numeric_limits<double>::quiet_NaN();
  return sum;
}

std::string matrix(const std::vector<std::array<double, kBins>>& rows) {
  std::string text;
  for (const auto& row : rows) {
    for (const double value : row) text += (std::isfinite(value) ? plain_number(value, 3) : "NaN") + " ";
    text += "\n";
  }
  return text;
}

}  // namespace

PlotScript gap_traces_script(const GapPlot& plot) {
  check(plot);
  const auto panels = static_cast<int>(plot.traces.size());
  const int drawing = panels * kPanel + (panels - 1) * kBetween;
  PlotScript script = canvas(plot.title, plot.subtitle, plot.notes, 3, drawing, kAxis, kBetween);
  Range range;
  for (const GapTrace& t : plot.traces)
    for (const auto* values : {&t.measured_um, &t.before_um, &t.after_um}) range.take(*values);
  script.text += axes("", "deviation [µm]") + (plot.traces.front().line ? "" : "set xtics 30\n") +
                 "set autoscale xfix\n";
  const double room = std::max(0.05 * (range.high - range.low), 1e-3);
  script.text += join({"set yrange [", plain_number(range.low - room, 3), ":",
                       plain_number(range.high + room, 3), "]\nset multiplot\n"});
  const double below = script.height - kTop - kBetween - drawing;
  for (int i = 0; i < panels; ++i) {
    const GapTrace& t = plot.traces[static_cast<std::size_t>(i)];
    const double bottom = below + (panels - 1 - i) * (kPanel + kBetween);
    const bool last = i + 1 == panels;
    script.text += between(bottom, bottom + kPanel, script.height) + panel_title(t.label);
    script.text += last ? join({"set format x '%g'\nset xlabel '", axis_of(plot), "'\n"})
                        : "set format x ''\nunset key\n";
    if (last && panels > 1)
      script.text +=
          "set key at screen 0.5," +
          plain_number(
              (8.0 + 26.0 * static_cast<double>(std::min<std::size_t>(plot.notes.size(), 6))) / script.height,
              4) +
          " center bottom vertical Left reverse samplen 3 maxcols 1 spacing 1.1\n";
    const std::string n = std::to_string(i);
    script.text += join({"$measured", n, " << EOD\n", rows_of(t.place, t.measured_um), "EOD\n"});
    script.text += join({"$before", n, " << EOD\n", rows_of(t.place, t.before_um), "EOD\n"});
    script.text += join({"$after", n, " << EOD\n", rows_of(t.place, t.after_um), "EOD\n"});
    const Stroke stroke = stroke_of(1, 0, t.direction, 1);
    const std::string line = " using 1:2 with lines linecolor rgb '";
    script.text +=
        join({"plot $measured", n, line, stroke.colour, "' linewidth 5 dashtype solid title 'measured'"});
    script.text += join({", \\\n     $before", n, line, "#888888' linewidth 1.6 dashtype (10,6)"});
    script.text += join({" title 'predicted by the model as configured', \\\n     $after", n, line});
    script.text += "#000000' linewidth 1.2 dashtype solid title 'predicted with what was left out'\n";
    if (i == 0) script.text += "unset label\n";
  }
  script.text += "unset multiplot\n";
  return script;
}

PlotScript gap_map_script(const GapPlot& plot) {
  check(plot);
  const auto count = static_cast<int>(plot.traces.size());
  const int panel = std::max(count * kMapRow, 60);
  constexpr int kScale = 84;  // [px] of the colours' scale
  PlotScript script =
      canvas(plot.title, plot.subtitle, plot.notes, 0, 2 * panel + kBetween, kAxis + kScale, kBetween);
  const double span = span_of(plot);
  std::vector<std::array<double, kBins>> before, after;
  double largest = 1e-3;
  for (const GapTrace& t : plot.traces) {
    before.push_back(binned(t, t.before_um, span));
    after.push_back(binned(t, t.after_um, span));
    for (const auto* row : {&before.back(), &after.back()})
      for (const double v : *row)
        if (std::isfinite(v)) largest = std::max(largest, std::abs(v));
  }
  const std::string limit = plain_number(largest, 3);
  script.text +=
      axes("", "") + "set lmargin at screen 0.36\nunset ylabel\nunset grid\nunset xzeroaxis\nunset key\n";
  script.text += "set palette defined (-1 '#0072B2', 0 '#FFFFFF', 1 '#D55E00')\nset cbrange [-" + limit +
                 ":" + limit + "]\nset cblabel 'measured - predicted [µm]'\n";
  script.text += "set xrange [0:" + plain_number(span, 0) + "]\n" +
                 (plot.traces.front().line ? "" : "set xtics 30\n") + "set yrange [" +
                 plain_number(count - 0.5, 1) + ":-0.5]\nset tics font ',13'\n";
  std::string names;
  for (int i = 0; i < count; ++i)
    names += (names.empty() ? "" : ", ") + gnuplot_quoted(plot.traces[static_cast<std::size_t>(i)].label) +
             " " + std::to_string(i);
  script.text += "set ytics (" + names + ")\n";
  script.text += "$before << EOD\n" + matrix(before) + "EOD\n$after << EOD\n" + matrix(after) + "EOD\n";
  const double below = script.height - kTop - kBetween - 2.0 * panel - kBetween;
  const double scale = below - kAxis - 14.0;  // the scale's place
  const std::string use = " matrix using ($1 * " + plain_number(span / kBins, 3) + " + " +
                          plain_number(0.5 * span / kBins, 3) + "):2:3 with image pixels\n";
  script.text += "set multiplot\nunset colorbox\nset format x ''\n" +
                 between(below + panel + kBetween, below + 2.0 * panel + kBetween, script.height) +
                 panel_title("the model as configured") + "plot $before" + use + "unset label\n";
  script.text +=
      join({"set colorbox horizontal user origin screen 0.36,screen ", plain_number(scale / script.height, 4),
            " size screen 0.60,screen ", plain_number(14.0 / script.height, 4), "\n"});
  script.text += between(below, below + panel, script.height) + "set format x '%g'\nset xlabel '" +
                 axis_of(plot) + "'\n" + panel_title("with what was left out") + "plot $after" + use +
                 "unset multiplot\n";
  return script;
}

PlotScript gap_shares_script(const std::string& title, const std::string& subtitle,
                             const std::vector<GapShare>& shares) {
  if (shares.empty()) throw Error(Cause::kInput, "plot: nothing was left out, so there are no shares");
  PlotScript script = canvas(title, subtitle, {}, 0, kBar * static_cast<int>(shares.size()), kAxis);
  std::string rows, names;
  for (std::size_t i = 0; i < shares.size(); ++i) {
    const double percent = 100.0 * shares[i].share;
    const std::string place = std::to_string(i);
    rows += join({plain_number(percent, 3), " ", place, "\n"});
    names += (i == 0 ? "" : ", ") + gnuplot_quoted(shares[i].label) + " " + place;
    script.text += "set label " +
                   gnuplot_quoted(shown(percent, 0) + " %   " + shown(shares[i].size_um, 1) + " µm") +
                   " at " + plain_number(percent + 1.5, 3) + "," + place + " left font ',15'\n";
  }
  script.text +=
      axes("share of the mismatch [%]", "") +
      "set lmargin at screen 0.42\nset rmargin at screen 0.97\nunset ylabel\nunset key\nset xrange [0:130]\n"
      "set xtics (0, 25, 50, 75, 100)\nunset xzeroaxis\nset yrange [" +
      plain_number(static_cast<double>(shares.size()) - 0.5, 1) + ":-0.5]\nset ytics (" + names +
      ") font ',14'\n$shares << EOD\n" + rows + "EOD\n";
  script.text +=
      "plot $shares using ($1/2):2:($1/2):(0.32) with boxxyerror fillstyle solid linecolor rgb '#0072B2' "
      "notitle\n";
  return script;
}

}  // namespace ballbar
