#pragma once
/// Another program that moves the arm: it gets commands and the robot as built, and gives motor angles and
/// tool points.

#include <filesystem>
#include <string>

#include "truth.hpp"

namespace blind {

struct Driven {
  std::vector<Joints> motor;   ///< at the joints' stamps: every bar stamp
  std::vector<Vector3d> tool;  ///< true tool point at the bar's samples
};

/// One way per pair of recordings, in the plan's order. `command`: what to start, with the job's folder as
/// its argument. Throws std::runtime_error where that fails.
std::vector<Driven> drive_with(const std::string& command, const std::filesystem::path& folder,
                               const Physics& physics, const Plan& plan);

}  // namespace blind
