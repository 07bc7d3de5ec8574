#include "daemon/diagnosis_page.hpp"

#include <algorithm>
#include <cstdio>
#include <set>

#include "core/error.hpp"
#include "core/units.hpp"
#include "daemon/diagnosis_out.hpp"
#include "report/canvas.hpp"
#include "report/gap_plot.hpp"
#include "report/html.hpp"

namespace ballbar {
namespace {

using nlohmann::ordered_json;

std::vector<double> scaled(const Eigen::VectorXd& values, double factor) {
  std::vector<double> all(static_cast<std::size_t>(values.size()));
  Eigen::Map<Eigen::VectorXd>(all.data(), values.size()) = factor * values;
  return all;
}

GapTrace gap_trace(const FitTrace& trace, bool with_series) {
  std::string label =
      (with_series ? trace.series + ":" : "") + trace.test + (trace.direction > 0 ? "+1" : "-1");
  const bool line = trace.kind == TestKind::kLine;
  if (line) label += std::string(" ") + trace.axis;
  label += "   " + shown(to_mm(trace.feed), 0) + " mm/s   " + shown(trace.payload, 1) + " kg";
  if (trace.held_out) label += "   held out";
  return {label,
          trace.direction,
          line,
          scaled(trace.place, 1.0 / (line ? kMetresPerMm : kRadPerDeg)),
          scaled(trace.measured, 1.0 / kMetresPerUm),
          scaled(trace.before, 1.0 / kMetresPerUm),
          scaled(trace.after, 1.0 / kMetresPerUm)};
}

bool any_of_kind(const Diagnosis& diagnosis, TestKind kind) {
  return std::any_of(diagnosis.traces.begin(), diagnosis.traces.end(),
                     [&](const FitTrace& trace) { return trace.kind == kind; });
}

/// Circles or lines, or those of one test.
template <typename Wanted>
std::vector<GapTrace> traces_of(const Diagnosis& diagnosis, const Wanted& wanted) {
  std::set<std::string> series;
  for (const FitTrace& trace : diagnosis.traces)
    if (!trace.held_out) series.insert(trace.series);
  std::vector<GapTrace> traces;
  for (const FitTrace& trace : diagnosis.traces)
    if (wanted(trace)) traces.push_back(gap_trace(trace, series.size() > 1));
  return traces;
}

std::string rms_text(const Diagnosis& d) {
  const auto um = [](double metres) { return shown(metres / kMetresPerUm, 2) + " µm"; };
  return "root mean square: " + um(d.fit.before) + " before, " + um(d.fit.after) + " after, noise " +
         um(d.noise_floor);
}

/// As in the table of the text.
std::string effect_name(const ordered_json& one) {
  std::string name = one["effect"].get<std::string>();
  for (const char* word : {"kind", "driver"})
    if (one.contains(word)) name += " (" + one[word].get<std::string>() + ")";
  return name;
}

std::string figure(const ordered_json& value, const char* format) {
  if (!value.is_number()) return "-";
  char text[64];
  std::snprintf(text, sizeof text, format, value.get<double>());
  return text;
}

HtmlTable left_out_table(const ordered_json& json) {
  HtmlTable table;
  table.heading = {"effect",
                   "joint",
                   "parameter",
                   "value",
                   "standard deviation",
                   "size µm",
                   "share",
                   "evidence",
                   "what else it could be"};
  table.last_is_words = true;
  for (const ordered_json& one : json["left_out"]) {
    std::string twins;
    for (const ordered_json& twin : one["cannot_be_told_from"]) {
      const int joint = twin["joint"].get<int>();
      twins += (twins.empty() ? "" : "; ") + twin["effect"].get<std::string>() +
               (joint > 0 ? " of joint " + std::to_string(joint) : "");
    }
    const ordered_json& parameters = one["parameters"];
    for (std::size_t i = 0; i < std::max<std::size_t>(1, parameters.size()); ++i) {
      const bool known = i < parameters.size();
      const auto first = [i](std::string text) { return i == 0 ? std::move(text) : std::string(); };
      const int joint = one["joint"].get<int>();
      table.rows.push_back({first(effect_name(one)), first(joint > 0 ? std::to_string(joint) : ""),
                            known ? parameters[i]["name"].get<std::string>() : "",
                            known ? figure(parameters[i]["value"], "%.4g") : "",
                            known ? figure(parameters[i]["sd"], "%.2g") : "",
                            first(figure(one["size_um"], "%.2f")), first(figure(one["share"], "%.2f")),
                            first(figure(one["evidence"], "%.0f")), first(twins)});
    }
  }
  return table;
}

}  // namespace

PlotScript diagnosis_picture(const Diagnosis& diagnosis, const std::string& title,
                             const std::string& picture) {
  if (picture == "shares") {
    std::vector<GapShare> shares;
    for (const LeftOut& one : diagnosis.left_out) {
      std::string label = one.spec.effect;
      for (const auto& [key, word] : one.spec.words) label += " " + word;
      if (one.spec.joint > 0) label += " J" + std::to_string(one.spec.joint);
      shares.push_back({label, one.share, one.size / kMetresPerUm});
    }
    return gap_shares_script(title, "what was left out, by its share of the mismatch", shares);
  }
  if (picture == "map" || picture == "lines") {
    const bool lines = picture == "lines" || !any_of_kind(diagnosis, TestKind::kCircle);
    const TestKind kind = lines ? TestKind::kLine : TestKind::kCircle;
    return gap_map_script({title,
                           lines ? "measured minus predicted, by position and condition"
                                 : "measured minus predicted, by arc and condition",
                           traces_of(diagnosis, [&](const FitTrace& trace) { return trace.kind == kind; }),
                           {rms_text(diagnosis)}});
  }
  std::vector<GapTrace> traces =
      traces_of(diagnosis, [&](const FitTrace& trace) { return trace.test == picture; });
  if (traces.empty())
    throw Error(Cause::kInput,
                "--picture " + picture +
                    ": no circle or line of that name was diagnosed; map, lines and shares are there too");
  return gap_traces_script(
      {title, "test " + picture + ", mean of the laps, before and after", std::move(traces), {}});
}

std::string diagnosis_html(const ordered_json& json) {
  std::string html = html_element("p", json["says"].get<std::string>());
  if (!json["left_out"].empty()) html += html_table(left_out_table(json));
  for (const ordered_json& one : json["left_out"]) {
    html += html_element("p", one["says"].get<std::string>());
    for (const ordered_json& twin : one["cannot_be_told_from"])
      html += html_element("p", "To tell it from " + twin["effect"].get<std::string>() + ": " +
                                    twin["to_tell_apart"].get<std::string>());
  }
  for (const ordered_json& place : json["located"])
    html += html_element("p", place["says"].get<std::string>());
  for (const ordered_json& warning : json["warnings"])
    html += html_element("p", "Beware: " + warning.get<std::string>());
  return html;
}

std::string diagnosis_page(const Diagnosis& diagnosis, const std::string& title) {
  int pictures = 0;
  const auto figure_of = [&](const std::string& picture, const std::string& caption) {
    return html_figure(svg_of(diagnosis_picture(diagnosis, title, picture)), "d" + std::to_string(++pictures),
                       caption);
  };
  const ordered_json json = to_json(diagnosis);
  std::string body = html_element("h1", title) + diagnosis_html(json);
  body += html_element("h2", "What is left, by arc and condition") + "<div class=\"pictures\">\n";
  body += figure_of(
      "map",
      "Each row is a circle (or a line) in one direction, mean of its laps. Above the model as configured, "
      "below with what was left out, both in the same colours: what is white below is explained.");
  if (any_of_kind(diagnosis, TestKind::kCircle) && any_of_kind(diagnosis, TestKind::kLine))
    body += figure_of("lines", "The same of the lines, each in one direction and read along one axis.");
  if (!diagnosis.left_out.empty())
    body +=
        figure_of("shares", "Shares of the mismatch, after zero offsets and set-up took up what they can.");
  body += "</div>\n" + html_element("h2", "Tests before and after") + "<div class=\"pictures\">\n";
  std::set<std::string> done;
  for (const FitTrace& trace : diagnosis.traces)
    if (done.insert(trace.test).second)
      body += figure_of(trace.test, trace.held_out ? "This test was not fitted: it is proof."
                                                   : "Measured, and predicted before and after.");
  body += "</div>\n";
  HtmlTable nuisance;
  nuisance.heading = {"set-up", "value", "standard deviation"};
  for (const Nuisance& one : diagnosis.nuisance)
    nuisance.rows.push_back({one.name, shown(one.value, 2), shown(one.sd, 2)});
  body += html_element("h2", "Fitted, but no physics of the robot") + html_table(nuisance);
  return html_page(title, body);
}

}  // namespace ballbar
