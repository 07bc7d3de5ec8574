#pragma once
/// CSV of static poses. Columns by name: q1_deg..qN_deg and x_mm,y_mm,z_mm or length_mm; optionally series,
/// point, time_s, payload_kg, temperature_c, direction, held_out and c1_deg..cN_deg. Others are ignored.

#include <string_view>

#include "core/poses.hpp"

namespace ballbar {

inline constexpr std::size_t kMaxPoses = 200'000;

/// Separated by commas, semicolons or tabs; decimals are points. Empty lines and lines that begin with # are
/// passed over. Optional numbers may be empty in single rows.
/// @param bytes   of the whole file, UTF-8
/// @param joints  of the robot
/// @throws Error(kInput) with line: what is wrong and what to do
PoseSet read_poses(std::string_view bytes, int joints);

}  // namespace ballbar
