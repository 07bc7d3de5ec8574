/// compare_json() as text and as part of a page: the same tables.

#include <cstdio>
#include <functional>

#include "daemon/compare.hpp"
#include "daemon/pictures.hpp"
#include "daemon/text_table.hpp"
#include "pipeline/catalogue.hpp"
#include "report/canvas.hpp"
#include "report/html.hpp"

namespace ballbar {
namespace {

using Rows = std::vector<std::vector<std::string>>;

std::string signed_number(const Json& value) {
  return (value.is_number() && value.get<double>() >= 0 ? "+" : "") + figure_text(value, 2);
}

std::string with_sd(const Json& value, const Json& sd) {
  return figure_text(value, 2) + (sd.is_number() ? " ± " + figure_text(sd, 2) : "");
}

std::string counts(const Json& entry) {
  const int before = entry["runs_before"].get<int>();
  return std::to_string(before) + (before == 1 ? " run before, " : " runs before, ") +
         std::to_string(entry["runs_after"].get<int>()) + " after";
}

std::string circle_title(const Json& circle) {
  return circle["robot"].get<std::string>() + "   test " + circle["test"].get<std::string>() + "   " +
         way_of(TestKind::kCircle, circle["direction"].get<int>()) +
         (circle["source"] == "joints" ? "   from joints   " : "   ") + counts(circle);
}

std::string line_title(const Json& line) {
  return line["robot"].get<std::string>() + "   test " + line["test"].get<std::string>() +
         "   deviation along " + line["axis"].get<std::string>() + "   " + counts(line);
}

Rows harmonic_rows(const Json& circle) {
  Rows rows{{"order", "before µm", "after µm", "change µm", "before vector µm", "after vector µm", "moved µm",
             "moved vector µm", "T²", "p"}};
  for (const Json& h : circle["harmonics"])
    rows.push_back({std::to_string(h["order"].get<int>()) + (h["order"] == 1 ? " (set-up)" : ""),
                    figure_text(h["before_mean_amplitude_um"], 2),
                    figure_text(h["after_mean_amplitude_um"], 2), signed_number(h["amplitude_change_um"]),
                    vector_text(h["before_vector_um"], 2), vector_text(h["after_vector_um"], 2),
                    figure_text(h["moved_um"], 2), vector_text(h["moved_vector_um"], 2),
                    figure_text(h["t2"], 1), p_text(h["p_value"])});
  return rows;
}

Rows figure_rows(const Json& entry) {
  Rows rows{{"figure", "before", "after", "change"}};
  for (const Json& f : entry["figures"])
    rows.push_back({label_of_quantity(f["quantity"].get<std::string>()),
                    with_sd(f["before"], f.value("before_sd", Json())),
                    with_sd(f["after"], f.value("after_sd", Json())), signed_number(f["change"])});
  return rows;
}

HtmlTable html_rows(Rows rows) {
  HtmlTable table;
  table.heading = std::move(rows.front());
  rows.erase(rows.begin());
  table.rows = std::move(rows);
  return table;
}

std::string title_of(const Json& comparison) {
  return "before: " + comparison["before"].get<std::string>() +
         "   after: " + comparison["after"].get<std::string>();
}

constexpr const char* kLegend =
    "Amplitudes are means over the runs, ± is the standard deviation of a single run. A harmonic moves as a "
    "vector: "
    "it can turn while its amplitude stays. p is the chance to see such a move where nothing has moved "
    "(Hotelling's T²); below 0.05 it is taken for real. Order 1 is how the ball was set up.";

}  // namespace

std::string p_text(const Json& p_value) {
  if (!p_value.is_number()) return "-";
  constexpr double kSmallest = 0.001;
  if (p_value.get<double>() < kSmallest) return "< 0.001";
  return shown(p_value.get<double>(), 3);
}

std::string compare_text(const Json& comparison) {
  std::string text = title_of(comparison) + "\n\n";
  for (const Json& circle : comparison["circles"])
    text += circle_title(circle) + "\n" + text_table(harmonic_rows(circle), 1) + "\n" +
            text_table(figure_rows(circle), 1) + "\n";
  for (const Json& line : comparison["lines"])
    text += line_title(line) + "\n" + text_table(figure_rows(line), 1) + "\n";
  if (!comparison["circles"].empty()) text += std::string(kLegend) + "\n";
  return text;
}

std::string compare_html(const Json& comparison) {
  std::string html;
  if (!comparison["circles"].empty()) html += html_element("p", kLegend);
  for (const Json& circle : comparison["circles"])
    html += html_element("h3", circle_title(circle)) + html_table(html_rows(harmonic_rows(circle))) +
            html_table(html_rows(figure_rows(circle)));
  for (const Json& line : comparison["lines"])
    html += html_element("h3", line_title(line)) + html_table(html_rows(figure_rows(line)));
  return html;
}

}  // namespace ballbar
