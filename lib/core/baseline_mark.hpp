#pragma once
/// From when on a robot counts as calibrated anew.

#include <cstdint>
#include <string>

namespace ballbar {

/// From `at_us` on the rules' baseline "calibration" begins anew.
struct BaselineMark {
  std::string robot, test;  ///< test "": all
  std::int64_t at_us = 0;
  std::string note;
};

}  // namespace ballbar
