#include "report/motion_plot.hpp"

#include <array>
#include <cmath>
#include <stdexcept>
#include <string_view>

#include "core/error.hpp"
#include "report/gnuplot_text.hpp"

namespace ballbar {
namespace {

constexpr int kMotionWidth = 720;
constexpr int kHeight = 560;
constexpr int kColumns = 3;  // of the legend

/// Okabe and Ito's colours, told apart with every kind of colour vision; the dashes tell them apart in print.
constexpr std::array<std::string_view, 6> kColours{"#0072B2", "#D55E00", "#009E73",
                                                   "#CC79A7", "#E69F00", "#333333"};
constexpr std::array<std::string_view, 4> kDashes{"solid", "(14,5)", "(3,4)", "(14,5,3,5)"};

std::string rows_of(const JointTrace& trace) {
  if (trace.place.size() != trace.angle_deg.size())
    throw std::invalid_argument("plot: a joint has as many places as angles");
  std::string rows;
  for (std::size_t i = 0; i < trace.place.size(); ++i) {
    if (std::isfinite(trace.place[i]) && std::isfinite(trace.angle_deg[i]))
      rows += plain_number(trace.place[i], 3) + " " + plain_number(trace.angle_deg[i], 4);
    rows += "\n";
  }
  return rows;
}

std::string label(const std::string& text, const char* place, int font) {
  return "set label " + gnuplot_quoted(text) + " at screen 0.5,screen " + place + " center font '," +
         std::to_string(font) + "'\n";
}

}  // namespace

PlotScript motion_script(const MotionPlot& plot) {
  std::string blocks;
  std::string command;
  for (std::size_t i = 0; i < plot.joints.size(); ++i) {
    const std::string rows = rows_of(plot.joints[i]);
    if (rows.find_first_not_of('\n') == std::string::npos) continue;
    const std::string block = "$joint" + std::to_string(i);
    blocks.append(block).append(" << EOD\n").append(rows).append("EOD\n");
    command += command.empty() ? "plot " : ", \\\n     ";
    command.append(block).append(" using 1:2 with lines linecolor rgb '");
    command.append(kColours.at(i % kColours.size())).append("' linewidth 2 dashtype ");
    command.append(kDashes.at(i % kDashes.size())).append(" title ");
    command += gnuplot_quoted(plot.joints[i].label);
  }
  if (command.empty()) throw Error(Cause::kInput, "plot: no joint angles, so there is no plot of the motion");
  PlotScript script{kMotionWidth, kHeight, "set encoding utf8\n"};
  script.text += label(plot.title, "0.955", 22) + label(plot.subtitle, "0.905", 17);
  script.text += "set lmargin at screen 0.13\nset rmargin at screen 0.96\n";
  script.text += "set tmargin at screen 0.87\nset bmargin at screen 0.28\n";
  script.text +=
      "set key at screen 0.5,screen 0.03 center bottom horizontal Left reverse samplen 4 maxcols " +
      std::to_string(kColumns) + " spacing 1.1\n";
  script.text += "set border 3 linecolor rgb '#404040'\nset tics nomirror\n";
  script.text += "set grid linecolor rgb '#C8C8C8' linewidth 0.8 dashtype solid\n";
  script.text += "set xrange [*:*] noextend\nset offsets 0,0,graph 0.04,graph 0.04\n";
  script.text += "set xlabel " + gnuplot_quoted(plot.place_label) + "\nset ylabel 'joint angle [deg]'\n";
  script.text += blocks + command + "\n";
  return script;
}

}  // namespace ballbar
