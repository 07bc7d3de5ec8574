#include "daemon/tool_diagnose_poses.hpp"

#include <filesystem>
#include <iostream>

#include "core/error.hpp"
#include "daemon/poses_json.hpp"
#include "daemon/service.hpp"
#include "daemon/tool.hpp"
#include "files/poses_csv.hpp"
#include "gap/pose_diagnosis.hpp"

namespace ballbar {
namespace {

/// What --hold-out says: a way to split, or series.
PoseHoldOut hold_out(const std::vector<std::string>& words, std::vector<std::string>& series) {
  if (words == std::vector<std::string>{"blocks"}) return PoseHoldOut::kBlocks;
  if (words == std::vector<std::string>{"random"}) return PoseHoldOut::kRandom;
  if (words == std::vector<std::string>{"each"}) return PoseHoldOut::kEachPlace;
  series = words;
  return PoseHoldOut::kDefault;
}

}  // namespace

int diagnose_poses_file(const PosesOptions& options) {
  const Config config = config_of_robot(options.config_path, options.robot);
  const RobotSpec& spec = config.robots.front();
  const Models models = load_models(config);
  const AsBuilt& robot = models.at(spec.name);
  const std::string text = read_text(options.poses_path);
  PoseDiagnosisOptions how;
  std::vector<std::string> series;
  how.hold_out = hold_out(options.hold_out, series);
  PoseDiagnosis diagnosis;
  try {
    const PoseSet set = read_poses(text, robot.model().joints());
    diagnosis = diagnose_poses(prepare_poses(set, robot, spec, series), robot.chain(), how);
  } catch (const Error& error) {
    throw Error(error.cause(), options.poses_path + ": " + error.what());
  }
  const Json json = poses_json(diagnosis);
  if (options.json)
    std::cout << text_of(json);
  else
    std::cout << poses_text(json, spec.name, std::filesystem::path(options.poses_path).filename().string());
  return diagnosis.verdict == PoseVerdict::kNothingMissing || diagnosis.verdict == PoseVerdict::kExplained
             ? 0
             : 1;
}

}  // namespace ballbar
