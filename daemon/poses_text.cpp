#include <cstdio>

#include "daemon/poses_json.hpp"
#include "daemon/text_table.hpp"

namespace ballbar {
namespace {

constexpr std::size_t kMostRows = 25, kMostPlaces = 6;

std::string number(double value, const char* format) {
  char text[48];
  std::snprintf(text, sizeof text, format, value);
  return text;
}

std::string mm(const Json& um) { return number(um.get<double>() / 1000.0, "%.3f"); }

std::string verdict_sentence(const Json& json) {
  const std::string verdict = json["verdict"];
  if (verdict == "nothing_missing")
    return "Nothing is missing: the model explains these poses to their noise.";
  if (verdict == "explained") return "What the model leaves out is named below.";
  if (verdict == "partly_explained")
    return "Most of what the model leaves out is named below; a remainder is not.";
  return "The model leaves something out that is none of the known effects.";
}

std::string paragraph(const Json& json, const std::string& robot, const std::string& file) {
  const Json& fit = json["fit"];
  std::string text = robot + ", " + file + ": " + std::to_string(fit["rows"].get<int>()) +
                     " poses fitted. The configured model misses the readings by " +
                     mm(fit["rms_before_um"]) + " mm (root mean square, base frame and tool point fitted). " +
                     verdict_sentence(json);
  std::size_t said = 0;
  for (const Json& place : json["located"]) {
    if (said++ == kMostPlaces) break;
    text += (said == 1 ? " The largest: " : "; ") + place["says"].get<std::string>();
  }
  if (said > 0) text += ".";
  for (const Json& proof : json["held_out_splits"])
    text += " " + std::to_string(proof["rows"].get<int>()) + " poses that were not fitted (" +
            proof["how"].get<std::string>() + ") are predicted to " + mm(proof["rms_after_um"]) +
            " mm instead of " + mm(proof["rms_before_um"]) + " mm.";
  for (const Json& warning : json["warnings"]) text += "\nNote: " + warning.get<std::string>() + ".";
  return text;
}

std::string effects_table(const Json& json) {
  std::vector<std::vector<std::string>> rows{
      {"effect", "joint", "parameters", "size um", "share", "evidence", "not told from"}};
  for (const Json& entry : json["left_out"]) {
    if (rows.size() > kMostRows) break;
    std::string parameters, twins;
    for (const Json& p : entry["parameters"])
      parameters += (parameters.empty() ? "" : ", ") + p["name"].get<std::string>() + " " +
                    number(p["value"].get<double>(), "%.4g") +
                    (p["sd"].is_number() ? " +- " + number(p["sd"].get<double>(), "%.1g") : "");
    for (const Json& twin : entry["cannot_be_told_from"])
      twins += (twins.empty() ? "" : ", ") + twin["effect"].get<std::string>() + " " +
               twin.value("parameter", std::string()) + (twin.contains("parameter") ? " " : "") +
               std::to_string(twin["joint"].get<int>());
    rows.push_back({entry["effect"], std::to_string(entry["joint"].get<int>()), parameters,
                    number(entry["size_um"].get<double>(), "%.1f"),
                    number(100.0 * entry["share"].get<double>(), "%.0f %%"),
                    number(entry["evidence"].get<double>(), "%.0f"), twins});
  }
  std::string text = text_table(rows, 3);
  const std::size_t all = json["left_out"].size();
  if (all > kMostRows)
    text += "  and " + std::to_string(all - kMostRows) + " smaller ones: --json shows all\n";
  return text;
}

std::string proof_table(const Json& json) {
  std::string text;
  for (const Json& proof : json["held_out_splits"]) {
    std::vector<std::vector<std::string>> rows{{"model", "fitted mm", "not fitted mm", "median mm"}};
    for (const Json& step : proof["steps"])
      rows.push_back(
          {step["model"].get<std::string>() == rows.front()[0] ? "" : "+ " + step["model"].get<std::string>(),
           mm(step["rms_fitted_um"]), mm(step["rms_um"]), mm(step["median_um"])});
    rows[1][0] = "configured";
    text += "\nnot fitted: " + proof["how"].get<std::string>() + ", " +
            std::to_string(proof["rows"].get<int>()) + " poses\n" + text_table(rows, 1);
  }
  return text;
}

}  // namespace

std::string poses_text(const Json& json, const std::string& robot, const std::string& file) {
  std::string text = paragraph(json, robot, file) + "\n";
  if (!json["left_out"].empty()) text += "\nleft out\n" + effects_table(json);
  return text + proof_table(json) + "\nnoise floor " + mm(json["noise_floor_um"]) + " mm, from " +
         (json["noise_from"] == "repeats" ? "repeats" : "what the fit leaves") + "\n";
}

}  // namespace ballbar
