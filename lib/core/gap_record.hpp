#pragma once
/// The diagnosis of a series as rules and listeners see it.

#include <cstdint>
#include <string>
#include <vector>

namespace ballbar {

struct GapRecord {
  std::string robot, series, verdict;
  std::int64_t ended_us = 0;  ///< producer's clock: end of the last run that it rests on
  double noise_floor = 0.0, rms_before = 0.0, rms_after = 0.0;  ///< [m]
  struct Finding {
    std::string effect, kind;  ///< kind: the effect's word, e.g. "backlash"; empty where it has none
    int joint = 0;             ///< from 1; 0: none
    int level = 0;             ///< 1 joint zeros, 2 geometry, 3 everything else
    double share = 0.0;        ///< of the mismatch
    double evidence = 0.0;     ///< ln of the odds for it
  };
  std::vector<Finding> left_out;  ///< by share, the largest first
};

}  // namespace ballbar
