#pragma once
/// What rules are asked about, beside the runs themselves.

#include <cstdint>
#include <string>
#include <vector>

#include "core/gap_record.hpp"
#include "core/result.hpp"

namespace ballbar {

/// Everything that one result of a run lets rules judge: itself; where it completes both directions of a
/// circle, a "test" (direction 0, figures of both); where the model predicts it, a "residual" (measured minus
/// predicted). A run that is not "ok" is only itself.
/// @param record  with harmonics
std::vector<Record> subjects_of(const Record& record);

/// Of the clock: so long has nothing been measured. `test` is empty for the robot as a whole.
Record silence_record(const std::string& robot, const std::string& test, std::int64_t now_us,
                      std::int64_t last_us);

/// What a robot lost in the last day.
struct Losses {
  std::int64_t runs = 0;  ///< all, whatever became of them
  std::int64_t runs_failed = 0;
  std::int64_t lost_messages = 0;
  std::int64_t receiver_restarts = 0;
};
Record loss_record(const std::string& robot, std::int64_t now_us, const Losses& losses);

/// A diagnosis: verdict and figures, the strongest finding as effect, effect_kind, joint, level, share and
/// evidence, all of them as parts.
Record gap_record(const GapRecord& gap);

}  // namespace ballbar
