#pragma once
/// An LCM log of a case, written event by event.

#include <filesystem>
#include <string>
#include <vector>

#include "plan.hpp"

namespace blind {

struct Recorded {
  Recording of;
  std::vector<Joints> joints;        ///< chain angles [rad], one per bar sample; every fourth is sent
  std::vector<double> deviation_um;  ///< of the bar
};

/// `begin_us`: clock of the series' begin. Throws std::runtime_error where the file cannot be written.
void write_log(const std::filesystem::path& file, const Plan& plan, const std::vector<Recorded>& recorded,
               const std::string& series, double begin_us, bool fanuc, int first_number);

}  // namespace blind
