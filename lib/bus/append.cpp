#include "bus/append.hpp"

#include <algorithm>

#include "core/units.hpp"

namespace ballbar {
namespace {

double since(const Run& run, std::int64_t time_us) {
  return static_cast<double>(time_us - run.started_us) * kSecondsPerUs;
}

}  // namespace

void append(Run& run, const BallbarBlock& block) {
  const double first = since(run, block.header.time_us);
  for (std::size_t i = 0; i < block.deviation.size(); ++i) {
    const double time = first + static_cast<double>(i) * block.period;
    if (time < 0.0 || (!run.bar_time.empty() && time <= run.bar_time.back())) continue;
    run.bar_time.push_back(time);
    run.bar_deviation.push_back(block.deviation[i]);
  }
}

void append(Run& run, const InterferometerBlock& block) {
  const double time = since(run, block.header.time_us);
  if (time < 0.0) return;
  for (std::size_t i = 0; i < block.position.size(); ++i)
    run.readings.push_back({block.axis, time, block.position[i], block.deviation[i]});
}

bool append(Run& run, const JointSample& sample) {
  const double time = since(run, sample.header.time_us);
  const int joints = static_cast<int>(sample.position.size());
  if (time < 0.0 || (!run.joint_time.empty() && time <= run.joint_time.back())) return true;
  if (run.joint_time.empty()) run.joints = joints;
  if (joints != run.joints) return false;
  const bool first_with_torque = run.joint_time.empty() && !sample.torque.empty();
  run.joint_time.push_back(time);
  run.joint_position.insert(run.joint_position.end(), sample.position.begin(), sample.position.end());
  if (first_with_torque || !run.joint_torque.empty()) {
    if (sample.torque.empty())
      run.joint_torque.clear();  // torque that comes and goes is of no use
    else
      run.joint_torque.insert(run.joint_torque.end(), sample.torque.begin(), sample.torque.end());
  }
  return true;
}

void cut_to_end(Run& run) {
  const double end = since(run, run.ended_us) + 0.5 * kSecondsPerUs;  // times are whole microseconds
  const auto keep = [end](const std::vector<double>& time) {
    return static_cast<std::size_t>(std::upper_bound(time.begin(), time.end(), end) - time.begin());
  };
  const std::size_t bar = keep(run.bar_time);
  run.bar_time.resize(bar);
  run.bar_deviation.resize(bar);
  const std::size_t joints = keep(run.joint_time);
  run.joint_time.resize(joints);
  run.joint_position.resize(joints * static_cast<std::size_t>(run.joints));
  if (!run.joint_torque.empty()) run.joint_torque.resize(joints * static_cast<std::size_t>(run.joints));
  std::erase_if(run.readings, [end](const InterferometerReading& r) { return r.time > end; });
}

}  // namespace ballbar
