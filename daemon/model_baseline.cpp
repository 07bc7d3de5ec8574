#include "daemon/model_baseline.hpp"

#include <algorithm>
#include <nlohmann/json.hpp>

#include "core/error.hpp"
#include "daemon/diagnosis_out.hpp"
#include "physics/catalogue.hpp"

namespace ballbar {
namespace {

bool acts_on_command(const EffectSpec& spec) {
  const EffectKind* kind = find_effect_kind(spec.effect);
  return kind && kind->command;
}

}  // namespace

ModelBaseline model_baseline_of(const RobotSpec& robot, const Diagnosis& diagnosis, const std::string& series,
                                std::int64_t ended_us) {
  std::vector<EffectSpec> effects;
  // Where JOINTS are read back, a configured filter of the command is in them already.
  for (const EffectSpec& spec : robot.effects)
    if (robot.joints_commanded || !acts_on_command(spec)) effects.push_back(spec);
  for (EffectSpec& spec : found_effects(diagnosis)) effects.push_back(std::move(spec));
  nlohmann::json model{{"verdict", to_string(diagnosis.verdict)}, {"effects", nlohmann::json::array()}};
  for (const EffectSpec& spec : effects)
    model["effects"].push_back({{"effect", spec.effect},
                                {"joint", spec.joint},
                                {"words", spec.words},
                                {"parameters", spec.parameters}});
  return {robot.name, series, ended_us, diagnosis.noise_floor, model.dump()};
}

RobotSpec with_baseline(RobotSpec robot, const ModelBaseline& baseline) {
  try {
    robot.effects.clear();
    const nlohmann::json model = nlohmann::json::parse(baseline.model);
    for (const nlohmann::json& one : model.at("effects"))
      robot.effects.push_back({one.at("effect").get<std::string>(), one.at("joint").get<int>(),
                               one.at("parameters").get<std::map<std::string, double>>(),
                               one.at("words").get<std::map<std::string, std::string>>()});
  } catch (const nlohmann::json::exception& error) {
    throw Error(Cause::kWorld, "the baseline of robot '" + baseline.robot + "' cannot be read (" +
                                   error.what() + "); make it anew with ballbar baseline keep");
  }
  // What was found to act on the command acts on the joints as they were heard.
  if (std::any_of(robot.effects.begin(), robot.effects.end(), acts_on_command)) robot.joints_commanded = true;
  return robot;
}

}  // namespace ballbar
