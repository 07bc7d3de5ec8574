#pragma once
/// `ballbar diagnose --poses`: static poses measured from outside.

#include <string>
#include <vector>

namespace ballbar {

struct PosesOptions {
  std::string poses_path, config_path;
  std::string robot;                  ///< may be empty where one is configured
  std::vector<std::string> hold_out;  ///< none: as the file says; "blocks", "random", "each"; or series
  bool json = false;
};

/// Prints the diagnosis. @return exit code: 1 where the mismatch cannot be named
/// @throws Error(kInput) with the file and what is wrong
int diagnose_poses_file(const PosesOptions& options);

}  // namespace ballbar
