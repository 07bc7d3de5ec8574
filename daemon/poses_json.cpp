#include "daemon/poses_json.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <map>

#include "core/units.hpp"
#include "daemon/pose_finding_json.hpp"

namespace ballbar {
namespace {

std::string tenths(double value) {
  char text[48];
  std::snprintf(text, sizeof text, "%.1f", value);
  return text;
}

/// What one kind of effect does at one joint, all its lines together.
Json located_json(const PoseDiagnosis& d) {
  struct Place {
    double squares = 0.0, strongest = 0.0, cycles = 0.0, least = 1e9, most = 0.0;
    int lines = 0;
    std::string says;
  };
  std::map<std::pair<std::string, int>, Place> places;
  for (const PoseFinding& f : d.left_out) {
    Place& place = places[{pose_effect_name(f.term, d), f.term.joint}];
    place.squares += f.contribution * f.contribution;
    ++place.lines;
    place.least = std::min(place.least, f.term.setting);
    place.most = std::max(place.most, f.term.setting);
    if (f.contribution <= place.strongest) continue;
    place.strongest = f.contribution;
    place.cycles = f.term.setting;
    place.says = pose_finding_json(f, d)["says"];
  }
  Json located = Json::array();
  for (const auto& [key, place] : places) {
    const bool ripple = key.first == "transmission_error";
    std::string says = place.says;
    if (ripple && place.lines > 1)
      says = joint_in_words(key.second)
                 .append(" has a periodic error, ")
                 .append(std::to_string(place.lines))
                 .append(" lines from ")
                 .append(tenths(place.least))
                 .append(" to ")
                 .append(tenths(place.most))
                 .append(" cycles per turn; the strongest: ")
                 .append(place.says);
    located.push_back({{"joint", key.second},
                       {"what", ripple ? "periodic error of the angle" : key.first},
                       {"lines", place.lines},
                       {"size_um", to_um(std::sqrt(place.squares))},
                       {"grows_with", key.first == "joint_compliance" ? Json("payload") : Json()},
                       {"says", says}});
  }
  std::stable_sort(located.begin(), located.end(), [](const Json& a, const Json& b) {
    return a["size_um"].get<double>() > b["size_um"].get<double>();
  });
  return located;
}

Json proof_json(const PoseProof& proof, const PoseDiagnosis& d) {
  Json coverage = Json::array();
  std::map<int, int> outside;
  for (const PoseCoverage::Joint& joint : proof.coverage.joints) {
    outside[joint.joint] += joint.outside;
    if (proof.parts == 1)
      coverage.push_back({{"joint", joint.joint},
                          {"rows", joint.outside},
                          {"fitted_deg", {to_deg(joint.fitted_least), to_deg(joint.fitted_most)}},
                          {"held_out_deg", {to_deg(joint.least), to_deg(joint.most)}}});
  }
  if (proof.parts > 1)
    for (const auto& [joint, rows] : outside) coverage.push_back({{"joint", joint}, {"rows", rows}});
  Json steps = Json::array();
  for (const PoseStep& step : proof.steps)
    steps.push_back({{"model", step.model},
                     {"rms_fitted_um", to_um(step.fitted)},
                     {"rms_um", to_um(step.held_out)},
                     {"median_um", to_um(step.held_out_median)}});
  return {{"how", proof.how},
          {"runs", d.frames},
          {"parts", proof.parts},
          {"rows", proof.rows},
          {"rms_before_um", to_um(proof.before().held_out)},
          {"rms_after_um", to_um(proof.after().held_out)},
          {"median_after_um", to_um(proof.after().held_out_median)},
          {"rows_outside_fitted_range", proof.coverage.outside},
          {"outside_fitted_range", coverage},
          {"steps", steps}};
}

Json nuisance_json(const PoseDiagnosis& d) {
  Json nuisance = Json::array();
  const auto vector = [](const Eigen::Vector3d& v) { return Json{to_mm(v.x()), to_mm(v.y()), to_mm(v.z())}; };
  for (std::size_t f = 0; f < d.state.frames.size(); ++f) {
    const Eigen::AngleAxisd turn(d.state.frames[f].linear());
    const Eigen::Vector3d w = turn.angle() * turn.axis();
    nuisance.push_back({{"what", "base_frame"},
                        {"series", d.frames[f]},
                        {"all_series", d.one_frame},
                        {"position_mm", vector(d.state.frames[f].translation())},
                        {"rotation_deg", {to_deg(w.x()), to_deg(w.y()), to_deg(w.z())}}});
  }
  for (std::size_t f = 0; f < d.state.fixed.size(); ++f)
    nuisance.push_back(
        {{"what", "fixed_point"}, {"series", d.frames[f]}, {"position_mm", vector(d.state.fixed[f])}});
  for (std::size_t t = 0; t < d.state.tools.size(); ++t)
    nuisance.push_back(
        {{"what", "tool_point"}, {"series", d.tools[t]}, {"position_mm", vector(d.state.tools[t])}});
  for (const PoseTerm& term : d.absorbed)
    nuisance.push_back(
        {{"what", "absorbed"},
         {"effect", pose_effect_name(term, d)},
         {"joint", term.joint},
         {"parameter", pose_parameter_name(term.effect)},
         {"says", "base frame, tool point or fixed point make up for it: these poses cannot show it"}});
  return nuisance;
}

const char* verdict_name(PoseVerdict verdict) {
  switch (verdict) {
    case PoseVerdict::kNothingMissing:
      return "nothing_missing";
    case PoseVerdict::kExplained:
      return "explained";
    case PoseVerdict::kPartlyExplained:
      return "partly_explained";
    case PoseVerdict::kUnknownEffect:
      return "unknown_effect";
  }
  return "";
}

Json warnings_json(const PoseDiagnosis& d) {
  Json warnings = Json::array();
  if (!d.noise_from_repeats)
    warnings.push_back(
        "no pose was measured twice: the noise floor is what the fit leaves, so it hides what is as small as "
        "that; "
        "repeat some poses");
  for (const PoseProof& proof : d.held_out)
    if (proof.coverage.outside > 0)
      warnings.push_back(
          std::to_string(proof.coverage.outside) + " of " + std::to_string(proof.rows) + " predicted rows (" +
          proof.how +
          ") leave the joint range that was fitted; errors of a joint's angle are not known there");
  for (const std::string& effect : d.not_applied)
    warnings.push_back("the configured effect '" + effect + "' is not applied to static poses");
  return warnings;
}

}  // namespace

Json poses_json(const PoseDiagnosis& d) {
  Json left_out = Json::array();
  for (const PoseFinding& finding : d.left_out) left_out.push_back(pose_finding_json(finding, d));
  Json splits = Json::array();
  for (const PoseProof& proof : d.held_out) splits.push_back(proof_json(proof, d));
  std::string structure = "none";
  int joint = 0;
  if (d.structured) {
    const bool angle = d.remainder_structure.effect == PoseEffect::kAngleCurve;
    structure = angle ? "joint angle" : "time";
    joint = angle ? d.remainder_structure.joint : 0;
  } else if (d.remainder) {
    structure = "other";
  }
  return {{"verdict", verdict_name(d.verdict)},
          {"noise_floor_um", to_um(d.noise_floor)},
          {"noise_from", d.noise_from_repeats ? "repeats" : "remainder"},
          {"fit",
           {{"runs", d.frames},
            {"rows", d.fitted_rows},
            {"rms_before_um", to_um(d.before)},
            {"rms_after_um", to_um(d.after)}}},
          {"held_out", splits.front()},
          {"held_out_splits", splits},
          {"located", located_json(d)},
          {"left_out", left_out},
          {"nuisance", nuisance_json(d)},
          {"remainder", {{"rms_um", to_um(d.after)}, {"structure", structure}, {"joint", joint}}},
          {"warnings", warnings_json(d)}};
}

}  // namespace ballbar
