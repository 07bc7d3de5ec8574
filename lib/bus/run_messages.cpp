#include "bus/run_messages.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/units.hpp"

namespace ballbar {
SampleHeader RunMessages::header(const Run& run, Channel channel, double time) {
  return {run.started_us + std::llround(time / kSecondsPerUs), ++sent_[{run.robot, channel}], run.robot};
}

std::vector<Sample> RunMessages::of(const Run& run) {
  if (run.end != RunEnd::kMark && run.end != RunEnd::kAborted)
    throw std::invalid_argument("run messages: the run did not end with a mark");
  std::vector<Sample> messages;
  TestMark mark{header(run, Channel::kTestMark, 0.0),
                run.test,
                Mark::kBegin,
                run.direction,
                run.repetition,
                run.series,
                run.feed,
                run.payload,
                run.temperature};
  messages.emplace_back(mark);
  for (std::size_t i = 0; i < run.bar_time.size(); ++i)
    messages.emplace_back(
        BallbarBlock{header(run, Channel::kBallbar, run.bar_time[i]), 0.0, {run.bar_deviation[i]}});
  const auto joints = static_cast<std::ptrdiff_t>(run.joints);
  for (std::size_t i = 0; i < run.joint_time.size(); ++i) {
    const auto row = static_cast<std::ptrdiff_t>(i) * joints;
    JointSample sample{header(run, Channel::kJoints, run.joint_time[i]), {}, {}};
    sample.position.assign(run.joint_position.begin() + row, run.joint_position.begin() + row + joints);
    if (!run.joint_torque.empty())
      sample.torque.assign(run.joint_torque.begin() + row, run.joint_torque.begin() + row + joints);
    messages.emplace_back(std::move(sample));
  }
  for (const InterferometerReading& r : run.readings)
    messages.emplace_back(InterferometerBlock{
        header(run, Channel::kInterferometer, r.time), r.axis, {r.position}, {r.deviation}});
  std::stable_sort(messages.begin() + 1, messages.end(), [](const Sample& a, const Sample& b) {
    return header_of(a).time_us < header_of(b).time_us;
  });
  mark.mark = run.end == RunEnd::kMark ? Mark::kEnd : Mark::kAbort;
  mark.header = header(run, Channel::kTestMark, 0.0);
  mark.header.time_us = run.ended_us;
  messages.emplace_back(std::move(mark));
  return messages;
}

}  // namespace ballbar
