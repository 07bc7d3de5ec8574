#include "bus/encode.hpp"

#include <ballbar/ballbar_samples_t.hpp>
#include <ballbar/interferometer_samples_t.hpp>
#include <ballbar/joint_samples_t.hpp>
#include <ballbar/test_mark_t.hpp>
#include <limits>
#include <string>

#include "core/units.hpp"

namespace ballbar {
namespace {

std::vector<double> outside(const std::vector<double>& values, double (*convert)(double)) {
  std::vector<double> out(values);
  for (double& v : out) v = convert(v);
  return out;
}

template <typename Message>
Message message_with(const SampleHeader& header) {
  Message m{};
  m.time_us = header.time_us;
  m.seq = header.seq;
  m.robot = header.robot;
  return m;
}

std::vector<std::uint8_t> message_of(const BallbarBlock& block) {
  auto m = message_with<ballbar_samples_t>(block.header);
  m.period_us = block.period / kSecondsPerUs;
  m.count = static_cast<std::int32_t>(block.deviation.size());
  m.deviation_um = outside(block.deviation, to_um);
  return bytes_of(m);
}

std::vector<std::uint8_t> message_of(const InterferometerBlock& block) {
  auto m = message_with<interferometer_samples_t>(block.header);
  m.axis = std::string(1, block.axis);
  m.count = static_cast<std::int32_t>(block.position.size());
  m.position_mm = outside(block.position, to_mm);
  m.deviation_um = outside(block.deviation, to_um);
  return bytes_of(m);
}

std::vector<std::uint8_t> message_of(const JointSample& sample) {
  auto m = message_with<joint_samples_t>(sample.header);
  m.joints = static_cast<std::int32_t>(sample.position.size());
  m.position_rad = sample.position;
  m.torque_count = static_cast<std::int32_t>(sample.torque.size());
  m.torque_nm = sample.torque;
  return bytes_of(m);
}

std::vector<std::uint8_t> message_of(const TestMark& mark) {
  auto m = message_with<test_mark_t>(mark.header);
  m.test = mark.test;
  m.mark = static_cast<std::int8_t>(mark.mark);
  m.direction = static_cast<std::int8_t>(mark.direction);
  m.repetition = mark.repetition;
  m.series = mark.series;
  m.feed_mm_s = to_mm(mark.feed);
  m.payload_kg = mark.payload;
  m.temperature_c = mark.temperature.value_or(std::numeric_limits<double>::quiet_NaN());
  return bytes_of(m);
}

}  // namespace

Encoded encode(const Sample& sample) {
  return {channel_of(sample), std::visit([](const auto& s) { return message_of(s); }, sample)};
}

}  // namespace ballbar
