#include "daemon/report_parts.hpp"

#include <algorithm>
#include <cmath>
#include <map>

#include "core/units.hpp"
#include "daemon/pictures.hpp"
#include "daemon/summary_json.hpp"
#include "metrology/signatures.hpp"
#include "report/canvas.hpp"
#include "report/html.hpp"
#include "store/labels.hpp"

namespace ballbar {
namespace {

/// In words of a person who reads the trace; "X" and "Y" are those of the frame.
std::string meaning_of(const std::string& signature) {
  static const std::map<std::string, std::string> kMeanings{
      {"radius_change", "the circle is too large (+) or too small all around"},
      {"scaling_mismatch", "an oval along X (+) or Y, the same both ways"},
      {"squareness", "an oval at 45 degrees, the same both ways"},
      {"servo_mismatch",
       "an oval at 45 degrees that changes sides with the direction: one axis follows later"},
      {"straightness_x", "a rounded triangle: motion along X is bent"},
      {"straightness_y", "a rounded triangle: motion along Y is bent"},
      {"three_lobe", "a rounded triangle that the two directions do not share: often a worn ball or cup"},
      {"backlash_x", "a step where motion along X turns round: + outward"},
      {"backlash_y", "a step where motion along Y turns round: + outward"},
      {"lateral_play_x", "the trace shifts sideways as a whole with the direction along X"},
      {"lateral_play_y", "the trace shifts sideways as a whole with the direction along Y"},
      {"reversal_spike_x", "a short peak where motion along X turns round, gone after a little way"},
      {"reversal_spike_y", "a short peak where motion along Y turns round, gone after a little way"},
      {"cyclic_x", "a ripple of steady pitch along X"},
      {"cyclic_y", "a ripple of steady pitch along Y"},
      {"master_slave_changeover", "steps at the 45 degree positions: two motors on one axis take turns"},
      {"spiral", "begin and end do not meet: warming up, or something slipped"},
      {"vibration", "shaking: what is quicker than 15 waves a turn"},
  };
  const auto found = kMeanings.find(signature);
  return found == kMeanings.end() ? "" : found->second;
}

std::string spaced(std::string name) {
  std::replace(name.begin(), name.end(), '_', ' ');
  return name;
}

std::string signature_table(const SignatureFit& fit) {
  HtmlTable table;
  table.heading = {"shape", "value", "unit", "share %", "circular error without it µm", "what it is"};
  table.last_is_words = true;
  for (const Signature& s : fit.signatures) {
    if (!s.value) continue;
    const SignatureUnit unit = unit_of(s.name);
    table.rows.push_back(
        {spaced(s.name),
         shown(unit.factor * *s.value, 2) + (s.sd ? " ± " + shown(unit.factor * *s.sd, 2) : ""), unit.unit,
         shown(100.0 * s.share, 1), shown(to_um(s.without), 1), meaning_of(s.name)});
  }
  for (const SignatureGroup& group : fit.not_told_apart) {
    std::string names;
    for (const std::string& name : group.names) names += (names.empty() ? "" : " + ") + spaced(name);
    table.rows.push_back(
        {names, "", "", shown(100.0 * group.share, 1), "", "only the sum of these is known"});
  }
  return html_table(table);
}

std::string circles_html(const Store& store, const std::vector<StoredRun>& runs) {
  HtmlTable table;
  table.heading = {"direction",
                   "runs",
                   "path accuracy AT µm",
                   "centred µm",
                   "path repeatability RT µm",
                   "mean ovality vector µm",
                   "its covariance over the runs µm²: cos, sin, both"};
  for (const Json& c : circles_summary(store, runs, "")) {
    const Json path = c["path"].is_null() ? Json::object() : c["path"];
    std::vector<std::string> row{way_of(TestKind::kCircle, c["direction"].get<int>()),
                                 std::to_string(c["runs"].get<int>()),
                                 figure_text(path.value("accuracy_um", Json()), 1),
                                 figure_text(path.value("accuracy_centred_um", Json()), 1),
                                 figure_text(path.value("repeatability_um", Json()), 1),
                                 vector_text(c["harmonic2_mean_vector_um"], 1),
                                 "-"};
    for (const Json& h : c["harmonics"])
      if (const Json& m = h["covariance_um2"]; h["order"] == 2 && m.is_array())
        row.back() = shown(m[0][0].get<double>(), 3) + ", " + shown(m[1][1].get<double>(), 3) + ", " +
                     shown(m[0][1].get<double>(), 3);
    table.rows.push_back(std::move(row));
  }
  if (table.rows.empty()) return "";
  return html_element(
             "p",
             "Over the repetitions. Path accuracy and repeatability are those of ISO 9283, as radial "
             "projections: a bar sees no more. AT is the largest distance of the mean path from the "
             "nominal circle, RT three standard deviations of the runs where they scatter most.") +
         html_table(table);
}

std::string stops_html(const std::vector<StoredRun>& runs) {
  HtmlTable table;
  table.heading = {"deviation along", "stops", "pose accuracy AP, largest µm",
                   "pose repeatability RP, largest µm"};
  for (const Json& line : lines_summary(runs))
    for (const auto& [key, poses] : line.items())
      if (key.starts_with("poses") && poses.is_object())
        table.rows.push_back({key == "poses" ? line["axis"].get<std::string>() : key.substr(sizeof "poses"),
                              std::to_string(poses["stops"].size()), figure_text(poses["accuracy_max_um"], 1),
                              figure_text(poses["repeatability_max_um"], 1)});
  if (table.rows.empty()) return "";
  return html_element("p",
                      "At the stops, over the repetitions: pose accuracy and repeatability of ISO 9283, "
                      "projected on what the optics see.") +
         html_table(table);
}

}  // namespace

std::string shapes_html(const std::vector<StoredRun>& runs) {
  const auto last = std::find_if(runs.rbegin(), runs.rend(),
                                 [](const StoredRun& run) { return run.signatures.has_value(); });
  if (last == runs.rend()) return "";
  std::string html = html_element(
      "p",
      "Shapes in both directions of repetition " + std::to_string(last->repetition) +
          " together, by share of their circular error. On a robot they are shapes, not causes: it has no X "
          "and Y slides, and backlash x says where the trace steps, not which part has play. X and Y are "
          "those of the plane.");
  html += signature_table(*last->signatures);
  if (!last->radial_signatures) return html;
  return html +
         html_element("p", "The same with X along the radius from the base's axis, " +
                               shown(to_deg(last->radial_signatures->frame_angle), 1) +
                               " degrees from the plane's first axis: joints turn round near the ends of "
                               "these X and Y.") +
         signature_table(*last->radial_signatures);
}

std::string repeats_html(const Store& store, const std::vector<StoredRun>& runs) {
  return runs.front().kind == TestKind::kCircle ? circles_html(store, runs) : stops_html(runs);
}

}  // namespace ballbar
