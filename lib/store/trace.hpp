#pragma once
/// The raw recording of a run as a compact blob.

#include <cstddef>
#include <cstdint>
#include <vector>

#include "core/result.hpp"
#include "core/run.hpp"

namespace ballbar {

/// What the instruments said, and the angle that was found for each bar sample. Members as in Run and
/// RunResult.
struct Trace {
  std::vector<double> bar_time;       ///< [s] since the begin of the run
  std::vector<double> bar_deviation;  ///< [m] one per bar_time
  std::vector<double> angle;          ///< [rad] empty, or one per bar_time; NaN where not known
  std::vector<double> predicted;      ///< [m] empty, or one per bar_time; NaN where not known
  std::size_t arc_begin = 0;          ///< the measured arc: bar samples [arc_begin, arc_end)
  std::size_t arc_end = 0;

  int joints = 0;
  std::vector<double> joint_time;      ///< [s]
  std::vector<double> joint_position;  ///< [rad] row-major, joint_time.size() x joints
  std::vector<double> joint_torque;    ///< [Nm] empty, or as joint_position

  std::vector<InterferometerReading> readings;
};

/// What encode() writes; the number stands beside each blob. decode() also reads 1, which has no predictions.
inline constexpr int kTraceCoding = 2;

/// Stated limits, above what one run may hold (bus/assembler): numbers in one trace, and bytes of one blob.
inline constexpr std::size_t kMaxTraceValues = 25'000'000;
inline constexpr std::size_t kMaxTraceBytes = 256'000'000;

Trace make_trace(const Run& run, const RunResult& result);

/// Rounded to: time 1 us, deviation and prediction 1 nm, line position 1 nm, angle and joints 1e-9 rad,
/// torque 1 mNm. A column that does not fit (beyond 2^53 steps, or infinite) is kept exactly.
/// encode(decode(x)) is x again.
///
/// @throws std::invalid_argument where the sizes of the columns do not belong together, or beyond the limits
std::vector<std::uint8_t> encode(const Trace& trace);

/// @throws std::runtime_error where the bytes are damaged or of an unknown coding; it never reads or
/// allocates beyond
///         what `bytes` can hold
Trace decode(int coding, const std::vector<std::uint8_t>& bytes);

}  // namespace ballbar
