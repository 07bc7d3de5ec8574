#include "report/harmonics_plot.hpp"

#include <algorithm>
#include <cmath>

#include "core/error.hpp"
#include "report/canvas.hpp"
#include "report/gnuplot_text.hpp"

namespace ballbar {
namespace {

constexpr int kHarmonicsDrawing = 380;    // [px]
constexpr double kOfStep = 0.8;           // of the step from order to order, taken by bars
constexpr std::size_t kMostFigures = 10;  // bars of one order that are so wide that figures stand on them

}  // namespace

PlotScript harmonics_script(const HarmonicsPlot& plot) {
  std::vector<const HarmonicBars*> sets;
  Groups groups;
  int first = 0;
  int last = 0;
  double tallest = 0.0;
  for (const HarmonicBars& set : plot.sets) {
    if (set.bars.empty()) continue;
    sets.push_back(&set);
    groups.of(set.group);
    for (const HarmonicBar& bar : set.bars) {
      first = first == 0 ? bar.order : std::min(first, bar.order);
      last = std::max(last, bar.order);
      if (std::isfinite(bar.amplitude_um))
        tallest = std::max(tallest, bar.amplitude_um + bar.sd_um.value_or(0.0));
    }
  }
  if (sets.empty()) throw Error(Cause::kInput, "plot: no harmonics, so there are no bars");

  const double width = kOfStep / static_cast<double>(sets.size());
  const bool figures = static_cast<std::size_t>(last - first + 1) * sets.size() <= kMostFigures;
  std::string blocks;
  std::string command;
  for (std::size_t i = 0; i < sets.size(); ++i) {
    const HarmonicBars& set = *sets[i];
    const double offset = (static_cast<double>(i) + 0.5) * width - kOfStep / 2;
    std::string rows;
    for (const HarmonicBar& bar : set.bars)
      if (std::isfinite(bar.amplitude_um))
        rows += plain_number(bar.order + offset, 5) + " " + plain_number(bar.amplitude_um, 4) + " " +
                plain_number(bar.sd_um.value_or(0.0), 4) + " " + plain_number(bar.amplitude_um, 1) + "\n";
    const std::string block = "$bars" + std::to_string(i);
    blocks += join({block, " << EOD\n", rows, "EOD\n"});
    const Stroke stroke = stroke_of(groups.size(), groups.of(set.group), set.direction);
    command +=
        join({command.empty() ? "plot " : ", \\\n     ", block,
              " using 1:2:3 with boxerrorbars fillstyle solid 1 border rgb '", kInk, "' linecolor rgb '",
              stroke.colour, "' linewidth 0.8 title ", gnuplot_quoted(set.label)});
    if (figures)
      command += join({", \\\n     ", block, " using 1:2:4 with labels offset 0,0.7 font ',13' notitle"});
  }
  PlotScript script = canvas(plot.title, plot.subtitle, plot.notes, sets.size(), kHarmonicsDrawing, kAxis);
  script.text += axes("order of the harmonic", "amplitude [µm]");
  script.text += "set grid noxtics ytics\nset xtics 1 scale 0\nset boxwidth " + plain_number(width, 5) + "\n";
  script.text += "set xrange [" + plain_number(first - 0.5, 1) + ":" + plain_number(last + 0.5, 1) +
                 "]\nset yrange [0:" + plain_number(tallest > 0 ? 1.08 * tallest : 1.0, 4) + "]\n";
  script.text += blocks + command + "\n";
  return script;
}

}  // namespace ballbar
