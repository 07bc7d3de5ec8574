#pragma once
/// What the instruments and the robot say, decoded: SI units, the sender's clock.

#include <cstdint>
#include <optional>
#include <string>
#include <variant>
#include <vector>

namespace ballbar {

struct SampleHeader {
  std::int64_t time_us = 0;  ///< sender's clock at the first sample, microseconds since the epoch
  std::int64_t seq = 0;      ///< +1 per message of one channel and robot; a gap is a loss
  std::string robot;
};

struct BallbarBlock {
  SampleHeader header;
  double period = 0.0;            ///< [s] between samples; 0 only for a single sample
  std::vector<double> deviation;  ///< [m] bar length - nominal length, + = longer
};

struct InterferometerBlock {
  SampleHeader header;
  char axis = 'X';                ///< direction of the deviation: X, Y or Z of the robot's world
  std::vector<double> position;   ///< [m] along the line, from its start
  std::vector<double> deviation;  ///< [m] perpendicular to the beam
};

struct JointSample {
  SampleHeader header;
  std::vector<double> position;  ///< [rad] in the robot's joint convention
  std::vector<double> torque;    ///< [Nm] empty, or one per joint
};

/// kCalibrated is of no run: what comes behind it is the new normal, `series` says why; test "" is all tests.
enum class Mark { kBegin = 1, kEnd = 2, kAbort = 3, kCalibrated = 4 };

struct TestMark {
  SampleHeader header;
  std::string test;
  Mark mark = Mark::kBegin;
  int direction = 0;   ///< +1 counter-clockwise / forward, -1 clockwise / backward, 0 not known
  int repetition = 0;  ///< 1, 2, ...
  std::string series;
  double feed = 0.0;                  ///< [m/s] programmed speed, 0 = as configured
  double payload = 0.0;               ///< [kg] on the flange
  std::optional<double> temperature;  ///< [degC]
};

using Sample = std::variant<BallbarBlock, InterferometerBlock, JointSample, TestMark>;

inline const SampleHeader& header_of(const Sample& sample) {
  return std::visit([](const auto& s) -> const SampleHeader& { return s.header; }, sample);
}

}  // namespace ballbar
