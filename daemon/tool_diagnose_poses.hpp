#pragma once
/// `ballbar diagnose --poses`: static poses measured from outside.

#include <string>

namespace ballbar {

struct PosesOptions {
  std::string poses_path, config_path;
  std::string robot;     ///< may be empty where one is configured
  std::string hold_out;  ///< "": as the file says; "blocks", "random", "each"; or names of series, by commas
  bool json = false;
};

/// Prints the diagnosis. @return exit code: 1 where the mismatch cannot be named
/// @throws Error(kInput) with the file and what is wrong
int diagnose_poses_file(const PosesOptions& options);

}  // namespace ballbar
