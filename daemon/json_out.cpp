#include "daemon/json_out.hpp"

#include <cmath>

#include "core/units.hpp"
#include "daemon/service.hpp"
#include "metrology/signatures.hpp"
#include "pipeline/catalogue.hpp"
#include "report/canvas.hpp"
#include "store/labels.hpp"

namespace ballbar {
namespace {

/// Every quantity of the catalogue for this kind of test; null where the run does not give it.
void put_figures(Json& json, const Record& record, const std::string& kind) {
  for (const Quantity& quantity : catalogue()) {
    if (quantity.kind != kind) continue;
    const std::string name(quantity.name);
    const auto found = record.values.find(name);
    json[name] = found == record.values.end() ? Json() : Json(found->second.value);
    if (found != record.values.end() && found->second.sd) json[name + "_sd"] = *found->second.sd;
  }
  if (kind == "line" && record.values.contains("points"))
    json["points"] = std::llround(record.values.at("points").value);
}

Json harmonics_json(const std::vector<Harmonic>& harmonics) {
  Json list = Json::array();
  for (const Harmonic& h : harmonics) {
    list.push_back({{"order", h.order},
                    {"cos_um", to_um(h.cos)},
                    {"sin_um", to_um(h.sin)},
                    {"amplitude_um", to_um(std::hypot(h.cos, h.sin))},
                    {"sd_um", to_um(std::sqrt((h.var_cos + h.var_sin) / 2.0))}});
  }
  return list;
}

Json signatures_json(const std::optional<SignatureFit>& fit) {
  Json list = Json::array();
  if (!fit) return list;
  for (const Signature& s : fit->signatures) {
    const SignatureUnit unit = unit_of(s.name);
    Json json{{"name", s.name},
              {"value", unit.factor * s.value.value_or(0.0)},
              {"sd", s.sd ? Json(unit.factor * *s.sd) : Json()},
              {"unit", unit.unit},
              {"span_um", to_um(s.span)},
              {"share", s.share},
              {"without_um", to_um(s.without)}};
    if (s.detail) json[s.name.starts_with("cyclic") ? "pitch_mm" : "travel_mm"] = to_mm(*s.detail);
    list.push_back(std::move(json));
  }
  for (const SignatureGroup& g : fit->not_told_apart)
    list.push_back({{"not_told_apart", g.names}, {"span_um", to_um(g.span)}, {"share", g.share}});
  return list;
}

Json profile_json(const StoredRun& run, const std::string& axis) {
  Json list = Json::array();
  for (const auto& [line_axis, points] : run.lines) {
    if (axis != std::string(1, line_axis)) continue;
    for (const LinePoint& point : points)
      list.push_back({{"position_mm", to_mm(point.position)},
                      {"deviation_um", to_um(point.deviation)},
                      {"reversal_um", point.reversal ? Json(to_um(*point.reversal)) : Json()},
                      {"predicted_um", point.predicted ? Json(to_um(*point.predicted)) : Json()}});
  }
  return list;
}

Json line_json(const StoredRun& run, const Record& record) {
  Json json;
  json["axis"] = record.axis;
  put_figures(json, record, "line");
  json["profile"] = profile_json(run, record.axis);
  return json;
}

}  // namespace

Json to_json(const StoredRun& run) {
  const bool circle = run.kind == TestKind::kCircle;
  Json json;
  json["id"] = run.id;
  json["run"] = run_name(run.test, run.direction, run.repetition);
  json["robot"] = run.robot;
  json["test"] = run.test;
  json["kind"] = circle ? "circle" : "line";
  json["direction"] = run.direction;
  json["repetition"] = run.repetition;
  json["series"] = run.series;
  json["started_us"] = run.started_us;
  json["ended_us"] = run.ended_us;
  json["status"] = run.status;
  if (!run.message.empty()) json["message"] = run.message;
  json["ended_by"] = to_string(run.end);
  json["angle_source"] = run.angle_source;
  json["source"] = run.source;
  if (circle) json["plane"] = run.plane;
  json["predicted_from"] = run.predicted_from;
  json["samples"] = run.samples;
  json["lost_messages"] = run.lost_messages;
  json["receiver_restarts"] = run.receiver_restarts;
  json["feed_mm_s"] = to_mm(run.feed);
  json["payload_kg"] = run.payload;
  json["temperature_c"] = run.temperature ? Json(*run.temperature) : Json();
  if (circle) {
    put_figures(json, run.records.empty() ? Record{} : run.records.front(), "circle");
    json["harmonics"] = harmonics_json(run.harmonics);
    json["gap_harmonics"] = harmonics_json(run.gap_harmonics);
    json["signatures"] = signatures_json(run.signatures);
    json["radial_signatures"] = signatures_json(run.radial_signatures);
    json["radial_frame_deg"] =
        run.radial_signatures ? Json(to_deg(run.radial_signatures->frame_angle)) : Json();
  } else {
    json.update(line_json(run, run.records.empty() ? Record{} : run.records.front()));
    if (run.records.size() > 1)
      for (const Record& record : run.records) json["axes"].push_back(line_json(run, record));
  }
  return json;
}

std::string text_of(const Json& json) {
  return json.dump(1, ' ', false, Json::error_handler_t::replace) + "\n";
}

std::string figure_text(const Json& value, int decimals) {
  return value.is_number() ? shown(value.get<double>(), decimals) : "-";
}

std::string vector_text(const Json& vector, int decimals) {
  return "(" + figure_text(vector[0], decimals) + ", " + figure_text(vector[1], decimals) + ")";
}

}  // namespace ballbar
