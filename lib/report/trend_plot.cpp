#include "report/trend_plot.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <map>
#include <utility>

#include "core/error.hpp"
#include "report/canvas.hpp"
#include "report/gnuplot_text.hpp"

namespace ballbar {
namespace {

constexpr int kNames = 26;                    // [px] of the names of the series
constexpr int kSecondRow = 22;                // [px] of the dates below the hours
constexpr int kTrendDrawing = 400;            // [px]
constexpr double kAxesWidth = 0.83 * kWidth;  // [px] of the drawing between its margins
constexpr double kMicroseconds = 1e6;         // a second
constexpr double kNamePx = 8.0;               // of one character of a series' name
constexpr std::size_t kLongestName = 40;      // bytes, of a name that stands in the drawing
constexpr double kDay = 86400.0;              // [s]
constexpr int kMostTics = 5;                  // steps of the time axis

/// A stretch of runs of one series.
struct Band {
  std::string series;
  double begin = 0.0, end = 0.0;  // in x
};

/// x of every run: seconds since the first one, or its number in the sequence of begins.
class Abscissa {
 public:
  explicit Abscissa(const TrendPlot& plot) : by_run_(plot.by_run) {
    for (const Trend& trend : plot.trends)
      for (const TrendPoint& p : trend.points)
        if (std::isfinite(p.value)) series_[p.time_us] = p.series;
    double number = 0.0;
    for (const auto& [time, series] : series_) {
      const double x = by_run_ ? ++number : static_cast<double>(time) / kMicroseconds;
      x_[time] = x;
      if (bands_.empty() || bands_.back().series != series) bands_.push_back({series, x, x});
      bands_.back().end = x;
    }
  }
  bool empty() const { return x_.empty(); }
  double of(std::int64_t time_us) const { return x_.at(time_us); }
  double first() const { return x_.begin()->second; }
  double last() const { return x_.rbegin()->second; }
  const std::vector<Band>& bands() const { return bands_; }

 private:
  bool by_run_;
  std::map<std::int64_t, std::string> series_;
  std::map<std::int64_t, double> x_;
  std::vector<Band> bands_;
};

std::string rows_of(const Trend& trend, const Abscissa& abscissa, double& low, double& high) {
  std::string rows;
  std::string series;
  for (const TrendPoint& p : trend.points) {
    if (!std::isfinite(p.value)) continue;
    if (!rows.empty() && p.series != series) rows += "\n";
    series = p.series;
    const double sd = p.sd && std::isfinite(*p.sd) ? *p.sd : 0.0;
    low = std::min(low, p.value - sd);
    high = std::max(high, p.value + sd);
    rows += plain_number(abscissa.of(p.time_us), 3) + " " + plain_number(p.value, 5) + " " +
            plain_number(sd, 5) + "\n";
  }
  return rows;
}

/// Five figures or fewer, at round times.
std::string time_axis(double span_s) {
  constexpr double kMinute = 60.0;
  constexpr double kHour = 3600.0;
  constexpr std::array<double, 27> kSteps{
      1,          2,           5,           10,           15,           30,
      kMinute,    2 * kMinute, 5 * kMinute, 10 * kMinute, 15 * kMinute, 30 * kMinute,
      kHour,      2 * kHour,   3 * kHour,   6 * kHour,    12 * kHour,   kDay,
      2 * kDay,   5 * kDay,    10 * kDay,   20 * kDay,    50 * kDay,    100 * kDay,
      200 * kDay, 500 * kDay,  1000 * kDay};
  const auto found =
      std::find_if(kSteps.begin(), kSteps.end(), [&](double step) { return span_s / step <= kMostTics; });
  const double step = found == kSteps.end() ? span_s / kMostTics : *found;
  const std::string_view format = step < kMinute ? "%H:%M:%S\\n%d %b %Y"
                                  : step < kDay  ? "%H:%M\\n%d %b %Y"
                                                 : "%d %b\\n%Y";
  return join({"set xdata time\nset timefmt '%s'\nset format x \"", format, "\"\nset xtics ",
               plain_number(step, 0), "\n"});
}

/// The bands' borders and names; what finds no room is named in `notes`.
std::string bands_of(const std::vector<Band>& bands, double low, double high,
                     std::vector<std::string>& notes) {
  std::string text;
  std::string numbered;
  for (std::size_t i = 0; i < bands.size(); ++i) {
    const double begin = i == 0 ? low : (bands[i - 1].end + bands[i].begin) / 2;
    const double end = i + 1 == bands.size() ? high : (bands[i].end + bands[i + 1].begin) / 2;
    if (i > 0)
      text += join({"set arrow from ", plain_number(begin, 3), ",graph 0 to ", plain_number(begin, 3),
                    ",graph 1 nohead linecolor rgb '", kInk, "' linewidth 1 dashtype (3,4) back\n"});
    const std::string& name = bands[i].series;
    const double room = (end - begin) / (high - low) * kAxesWidth;
    const bool fits = name.size() <= kLongestName && static_cast<double>(name.size()) * kNamePx < room;
    const std::string number = std::to_string(i + 1);
    if (!fits) numbered += join({numbered.empty() ? "" : ",   ", number, ": ", name});
    text +=
        join({"set label ", gnuplot_quoted(fits ? name : number), " at ", plain_number((begin + end) / 2, 3),
              ",graph 1.04 center font ',14' textcolor rgb '", kInk, "'\n"});
  }
  if (!numbered.empty()) notes.insert(notes.begin(), "series   " + numbered);
  return text;
}

}  // namespace

PlotScript trend_script(const TrendPlot& plot) {
  const Abscissa abscissa(plot);
  if (abscissa.empty()) throw Error(Cause::kInput, "plot: no run gives this figure, so there is no trend");
  double low = 1e300;
  double high = -1e300;
  for (const TrendLimit& limit : plot.limits) {
    low = std::min(low, limit.value);
    high = std::max(high, limit.value);
  }
  Groups groups;
  for (const Trend& trend : plot.trends) groups.of(trend.group);
  std::string blocks;
  std::string command;
  std::size_t entries = 0;
  for (std::size_t i = 0; i < plot.trends.size(); ++i) {
    const Trend& trend = plot.trends[i];
    const std::string rows = rows_of(trend, abscissa, low, high);
    if (rows.empty()) continue;
    const std::string block = "$trend" + std::to_string(i);
    blocks += join({block, " << EOD\n", rows, "EOD\n"});
    const Stroke stroke = stroke_of(groups.size(), groups.of(trend.group), trend.direction);
    command +=
        join({command.empty() ? "plot " : ", \\\n     ", block, " using 1:2:3 with yerrorlines pointtype ",
              std::to_string(stroke.point), " pointsize 0.7 linecolor rgb '", stroke.colour,
              "' linewidth 1.6 dashtype ", stroke.dash, " title ", gnuplot_quoted(trend.label)});
    ++entries;
  }

  const double margin = std::max(0.03 * (abscissa.last() - abscissa.first()), plot.by_run ? 0.6 : 5.0);
  const double from = abscissa.first() - margin;
  const double to = abscissa.last() + margin;
  std::vector<std::string> notes = plot.notes;
  for (const TrendLimit& limit : plot.limits)
    if (!limit.whose.empty())
      notes.push_back(join({"limit ", plain_number(limit.value, 3), ": ", limit.whose}));
  const std::string bands = bands_of(abscissa.bands(), from, to, notes);
  PlotScript script = canvas(plot.title, plot.subtitle, notes, entries, kTrendDrawing,
                             plot.by_run ? kAxis : kAxis + kSecondRow, kNames);
  script.text += axes(plot.by_run ? "run, in sequence" : "begin of the run (UTC)", plot.value_label);
  if (!plot.by_run) script.text += time_axis(to - from);
  constexpr double kLeastSpread = 1e-4;  // less would be an empty range where it is written
  const double reach = high - low > kLeastSpread ? 0.06 * (high - low) : std::max(0.1 * std::abs(high), 1.0);
  script.text += "set yrange [" + plain_number(low - reach, 5) + ":" + plain_number(high + reach, 5) + "]\n";
  // With xdata time a range is read by timefmt, as text.
  const std::string quote = plot.by_run ? "" : "'";
  script.text += "set xrange [" + quote + plain_number(from, 3) + quote + ":" + quote + plain_number(to, 3) +
                 quote + "]\n";
  script.text += "set errorbars small\n" + bands;
  if (!plot.limits.empty()) script.text += "set rmargin at screen 0.86\n";
  for (const auto& [limit, whose] : plot.limits)
    script.text += join({"set arrow from graph 0,first ", plain_number(limit, 5), " to graph 1,first ",
                         plain_number(limit, 5), " nohead linecolor rgb '", kLimit,
                         "' linewidth 1.6 dashtype (8,4) front\nset label ",
                         gnuplot_quoted("limit " + plain_number(limit, 3)), " at graph 1.01,first ",
                         plain_number(limit, 5), " left font ',14' textcolor rgb '", kLimit, "' front\n"});
  script.text += blocks + command + "\n";
  return script;
}

}  // namespace ballbar
