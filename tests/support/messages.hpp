#pragma once
/// Wire messages as a producer makes them, with LCM's own generated encoders.

#include <ballbar/ballbar_samples_t.hpp>
#include <ballbar/interferometer_samples_t.hpp>
#include <ballbar/joint_samples_t.hpp>
#include <ballbar/test_mark_t.hpp>
#include <cstdint>
#include <limits>
#include <string>
#include <vector>

#include "bus/encode.hpp"

namespace ballbar::test {

inline constexpr std::int64_t kEpochUs = 1'700'000'000'000'000;  // any time of the producer's clock

using ballbar::bytes_of;

inline ballbar_samples_t bar_message(std::int64_t time_us, std::int64_t seq, std::vector<double> deviation_um,
                                     double period_us = 4000.0, const std::string& robot = "r1") {
  ballbar_samples_t m{};
  m.time_us = time_us;
  m.seq = seq;
  m.robot = robot;
  m.period_us = period_us;
  m.count = static_cast<std::int32_t>(deviation_um.size());
  m.deviation_um = std::move(deviation_um);
  return m;
}

inline joint_samples_t joint_message(std::int64_t time_us, std::int64_t seq, std::vector<double> position_rad,
                                     const std::string& robot = "r1") {
  joint_samples_t m{};
  m.time_us = time_us;
  m.seq = seq;
  m.robot = robot;
  m.joints = static_cast<std::int32_t>(position_rad.size());
  m.position_rad = std::move(position_rad);
  return m;
}

inline interferometer_samples_t interferometer_message(std::int64_t time_us, std::int64_t seq,
                                                       double position_mm, double deviation_um,
                                                       const std::string& axis = "X",
                                                       const std::string& robot = "r1") {
  interferometer_samples_t m{};
  m.time_us = time_us;
  m.seq = seq;
  m.robot = robot;
  m.axis = axis;
  m.count = 1;
  m.position_mm = {position_mm};
  m.deviation_um = {deviation_um};
  return m;
}

inline test_mark_t mark_message(std::int64_t time_us, std::int64_t seq, int mark,
                                const std::string& test = "A", int direction = 1, int repetition = 1,
                                const std::string& robot = "r1") {
  test_mark_t m{};
  m.time_us = time_us;
  m.seq = seq;
  m.robot = robot;
  m.test = test;
  m.mark = static_cast<std::int8_t>(mark);
  m.direction = static_cast<std::int8_t>(direction);
  m.repetition = repetition;
  m.series = "s";
  m.feed_mm_s = 50.0;
  m.payload_kg = 0.5;
  m.temperature_c = std::numeric_limits<double>::quiet_NaN();
  return m;
}

}  // namespace ballbar::test
