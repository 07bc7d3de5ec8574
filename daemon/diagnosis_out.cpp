#include "daemon/diagnosis_out.hpp"

#include <algorithm>
#include <cmath>
#include <cstdio>

#include "core/units.hpp"
#include "daemon/text_table.hpp"
#include "physics/catalogue.hpp"

namespace ballbar {
namespace {

using nlohmann::ordered_json;

std::string formatted(const char* format, double value) {
  char text[64];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string um(double metres) { return formatted("%.2f", metres / kMetresPerUm); }

ordered_json figures_json(const FitFigures& figures) {
  return {{"runs", figures.runs},
          {"rms_before_um", figures.before / kMetresPerUm},
          {"rms_after_um", figures.after / kMetresPerUm},
          {"noise_floor_um", figures.floor / kMetresPerUm}};
}

ordered_json left_out_json(const LeftOut& one) {
  ordered_json json{{"effect", one.spec.effect}};
  for (const auto& [key, word] : one.spec.words) json[key] = word;
  json["joint"] = one.spec.joint;
  json["level"] = one.level;
  json["share"] = one.share;
  json["size_um"] = one.size / kMetresPerUm;
  json["evidence"] = one.evidence;
  json["parameters"] = ordered_json::array();
  for (const NamedParameter& p : one.parameters)
    json["parameters"].push_back({{"name", p.name}, {"value", p.value}, {"sd", p.sd}});
  json["cannot_be_told_from"] = ordered_json::array();
  for (const Twin& twin : one.twins)
    json["cannot_be_told_from"].push_back({{"effect", twin.effect},
                                           {"joint", twin.joint},
                                           {"which", twin.label},
                                           {"resemblance", twin.resemblance},
                                           {"to_tell_apart", twin.to_tell_apart}});
  json["says"] = one.says;
  return json;
}

/// On a circle an arc, on a line a stretch from its start and the axis of the deviation.
ordered_json located_json(const Located& place) {
  ordered_json json{
      {"joint", place.joint}, {"what", place.what}, {"test", place.test}, {"direction", place.direction}};
  if (place.kind == TestKind::kLine) {
    json["axis"] = std::string(1, place.axis);
    json["position_mm"] = {place.from / kMetresPerMm, place.to / kMetresPerMm};
  } else {
    json["angle_deg"] = {place.from / kRadPerDeg, place.to / kRadPerDeg};
  }
  json["size_um"] = place.size / kMetresPerUm;
  json["grows_with"] = place.grows_with;
  json["says"] = place.says;
  return json;
}

/// "joint 2: motion lost behind the encoder when the joint reverses, backlash (83 %)".
std::string in_words(const LeftOut& one) {
  const EffectKind* kind = find_effect_kind(one.spec.effect);
  std::string text = one.spec.joint > 0 ? "joint " + std::to_string(one.spec.joint) + ": " : "";
  text += one.driver.empty() && kind ? std::string(kind->meaning)
                                     : "an error that depends on its " + one.driver + ", of no known kind";
  if (const auto word = one.spec.words.find("kind"); word != one.spec.words.end())
    text += ", " + word->second;
  return text + " (" + formatted("%.0f", 100.0 * one.share) + " %)";
}

std::string causes(const Diagnosis& d) {
  constexpr std::size_t kMost = 3;
  std::string text;
  for (std::size_t i = 0; i < std::min(kMost, d.left_out.size()); ++i)
    text += (i == 0 ? " What it lacks: " : "; ") + in_words(d.left_out[i]);
  if (d.left_out.size() > kMost) text += "; and " + std::to_string(d.left_out.size() - kMost) + " more";
  return text.empty() ? "" : text + ".";
}

std::string tests_in_words(const Diagnosis& d) {
  return d.circles && d.lines ? "circles and lines" : d.lines ? "lines" : "circles";
}

std::string proof(const Diagnosis& d) {
  if (!(d.held_out.after > 0.0)) return "";
  return " On " + tests_in_words(d) +
         (d.held_out_by_leaving_out ? " left out of the fit in turn" : " that were not fitted") + ": " +
         um(d.held_out.before) + " um before, " + um(d.held_out.after) + " um after; noise " +
         um(d.held_out.floor) + " um." +
         (d.holds_elsewhere
              ? ""
              : " That is far more than noise and the standard deviations of what was fitted make (" +
                    um(d.held_out.expected) + " um): what was found here does not hold there.");
}

std::string paragraph(const Diagnosis& d) {
  const std::string before = um(d.fit.before) + " um", after = um(d.fit.after) + " um";
  const std::string floor = um(d.noise_floor) + " um";
  const std::string these = "these " + tests_in_words(d);
  const std::string misses = "The model as configured misses " + these + " by " + before + " (rms).";
  const std::string noise = " are left; the noise alone is " + floor + ".";
  switch (d.verdict) {
    case Verdict::kNothingMissing:
      return "The model explains " + these + ": " + after + " are left, the noise alone is " + floor +
             ". Beyond the joints' zeros and the set-up no physics is missing." + causes(d) + proof(d);
    case Verdict::kExplained:
      return misses + causes(d) + " With that " + after + noise + proof(d);
    case Verdict::kPartlyExplained:
      return misses + causes(d) + " That explains a part: " + after + noise + proof(d) +
             " Something else is there too.";
    case Verdict::kUnknownEffect:
      break;
  }
  if (d.remainder.structure == "none")
    return misses + causes(d) + " With that " + after + noise + proof(d) +
           " No effect of the catalogue explains that.";
  return misses + " No effect of the catalogue explains that." + causes(d) + " With that " + after + noise +
         proof(d);
}

}  // namespace

ordered_json to_json(const Diagnosis& d) {
  ordered_json json{{"verdict", to_string(d.verdict)},
                    {"says", paragraph(d)},
                    {"noise_floor_um", d.noise_floor / kMetresPerUm},
                    {"noise_from_repeats", d.noise_from_repeats},
                    {"fit", figures_json(d.fit)},
                    {"held_out", figures_json(d.held_out)}};
  json["held_out"]["expected_rms_um"] = d.held_out.expected / kMetresPerUm;
  json["held_out"]["by_leaving_out_in_turn"] = d.held_out_by_leaving_out;
  json["located"] = ordered_json::array();
  for (const Located& place : d.located) json["located"].push_back(located_json(place));
  json["left_out"] = ordered_json::array();
  for (const LeftOut& one : d.left_out) json["left_out"].push_back(left_out_json(one));
  json["nuisance"] = ordered_json::array();
  for (const Nuisance& one : d.nuisance)
    json["nuisance"].push_back({{"name", one.name}, {"value", one.value}, {"sd", one.sd}});
  json["remainder"] = {{"rms_um", d.remainder.rms / kMetresPerUm},
                       {"structure", d.remainder.structure},
                       {"joint", d.remainder.joint},
                       {"worst_z", d.remainder.worst_z}};
  json["warnings"] = d.warnings;
  return json;
}

std::string to_text(const Diagnosis& d) {
  std::string text = paragraph(d) + "\n";
  if (!d.left_out.empty()) {
    std::vector<std::vector<std::string>> table{
        {"effect", "joint", "parameter", "value", "sd", "size um", "share", "evidence"}};
    for (const LeftOut& one : d.left_out) {
      std::string name = one.spec.effect;
      for (const auto& [key, word] : one.spec.words) name += " (" + word + ")";
      const std::size_t rows = std::max<std::size_t>(1, one.parameters.size());
      for (std::size_t i = 0; i < rows; ++i) {
        const bool first = i == 0, known = i < one.parameters.size();
        table.push_back(
            {first ? name : "", first ? std::to_string(one.spec.joint) : "",
             known ? one.parameters[i].name : "", known ? formatted("%.4g", one.parameters[i].value) : "",
             known ? formatted("%.2g", one.parameters[i].sd) : "", first ? um(one.size) : "",
             first ? formatted("%.2f", one.share) : "", first ? formatted("%.0f", one.evidence) : ""});
      }
    }
    text += "\n" + text_table(table, 3) + "\n";
  }
  for (const LeftOut& one : d.left_out) {
    text += "- " + one.says + "\n";
    for (const Twin& twin : one.twins)
      text += "    could as well be " + twin.effect +
              (twin.joint > 0 ? " of joint " + std::to_string(twin.joint) : "") + ": " + twin.to_tell_apart +
              "\n";
  }
  for (const Located& place : d.located) text += "- " + place.says + "\n";
  for (const std::string& warning : d.warnings) text += "! " + warning + "\n";
  return text;
}

namespace {

std::string effect_table(const EffectSpec& spec) {
  std::string text = "[[robot.effect]]\neffect = \"" + spec.effect + "\"\n";
  if (spec.joint > 0) text.append("joint = ").append(std::to_string(spec.joint)).append("\n");
  for (const auto& [name, word] : spec.words) text.append(name).append(" = \"").append(word).append("\"\n");
  for (const auto& [name, value] : spec.parameters)
    text.append(name).append(" = ").append(formatted("%.10g", value)).append("\n");
  return text.append("\n");
}

}  // namespace

std::vector<EffectSpec> found_effects(const Diagnosis& d) {
  std::vector<EffectSpec> found;
  for (const LeftOut& one : d.left_out)
    if (one.spec.effect != "not_in_catalogue" && one.spec.effect != "joint_zero_offset")
      found.push_back(one.spec);
  // All of them, material or not: those that cannot be told apart hold only together.
  for (std::size_t j = 0; j < d.zero_offsets.size(); ++j)
    if (std::abs(d.zero_offsets[j].value) > 1e-9)
      found.push_back(
          {"joint_zero_offset", static_cast<int>(j) + 1, {{"offset_deg", d.zero_offsets[j].value}}, {}});
  return found;
}

std::string effect_tables(const std::vector<EffectSpec>& effects) {
  std::string text;
  for (const EffectSpec& spec : effects) {
    const EffectKind* kind = find_effect_kind(spec.effect);
    if (kind && kind->command)
      text.append(
          "# acts on what is commanded: the prediction has it only where joints = \"commanded\" or no joints "
          "are sent\n");
    text.append(effect_table(spec));
  }
  return text;
}

std::string model_tables(const Diagnosis& d) { return effect_tables(found_effects(d)); }

std::string mastering_table(const Diagnosis& d) {
  std::string text =
      "# The joints stand so far beside their readings [deg], +- one standard deviation: add these to the "
      "mastering.\n"
      "# Joints that these circles do not tell apart hold only together; the first and the last do not show "
      "at all.\n";
  for (std::size_t j = 0; j < d.mastering.size(); ++j)
    text.append("J")
        .append(std::to_string(j + 1))
        .append(formatted(" %+.5f", d.mastering[j].value))
        .append(formatted(" +- %.5f\n", d.mastering[j].sd));
  return text;
}

}  // namespace ballbar
