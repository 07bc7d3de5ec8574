#include "bus/assembler.hpp"

#include <algorithm>
#include <cmath>

#include "core/units.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kReorderedMessages =
    64;  // UDP may overtake; further back is a producer that started again
constexpr std::int64_t kReorderedUs = 2'000'000;     // likewise in time
constexpr std::int64_t kBelievableLoss = 1'000'000;  // a larger jump in seq is a new count, not a loss

Channel channel_of(const Sample& sample) {
  struct Visitor {
    Channel operator()(const BallbarBlock&) const { return Channel::kBallbar; }
    Channel operator()(const InterferometerBlock&) const { return Channel::kInterferometer; }
    Channel operator()(const JointSample&) const { return Channel::kJoints; }
    Channel operator()(const TestMark&) const { return Channel::kTestMark; }
  };
  return std::visit(Visitor{}, sample);
}

const SampleHeader& header_of(const Sample& sample) {
  return std::visit([](const auto& s) -> const SampleHeader& { return s.header; }, sample);
}

double since(const Run& run, std::int64_t time_us) {
  return static_cast<double>(time_us - run.started_us) * kSecondsPerUs;
}

/// Time of the last sample that a run holds.
std::int64_t last_sample_us(const Run& run) {
  double last = 0.0;
  if (!run.bar_time.empty()) last = std::max(last, run.bar_time.back());
  if (!run.joint_time.empty()) last = std::max(last, run.joint_time.back());
  if (!run.readings.empty()) last = std::max(last, run.readings.back().time);
  return run.started_us + std::llround(last / kSecondsPerUs);
}

/// Blocks that were sent before the end mark may hold samples behind it, and begin before the begin mark.
void cut_to_end(Run& run) {
  const double end = since(run, run.ended_us) + 0.5 * kSecondsPerUs;  // marks are whole microseconds
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

}  // namespace

Assembler::Assembler(std::vector<RobotSpec> robots, AssemblerLimits limits) : limits_(limits) {
  std::vector<Run> none;
  configure(std::move(robots), none);
}

void Assembler::configure(std::vector<RobotSpec> robots, std::vector<Run>& finished) {
  std::map<std::string, Robot> next;
  for (RobotSpec& spec : robots) {
    Robot& robot = next[spec.name];
    if (const auto old = robots_.find(spec.name); old != robots_.end()) {
      robot = std::move(old->second);
      robots_.erase(old);
    }
    robot.spec = std::move(spec);
    if (robot.run && !robot.spec.find_test(robot.run->test)) close(robot, RunEnd::kInterrupted, finished);
  }
  for (auto& [name, robot] : robots_) close(robot, RunEnd::kInterrupted, finished);
  robots_ = std::move(next);
}

void Assembler::take(const Sample& sample, std::int64_t arrival_us, std::vector<Run>& finished) {
  const SampleHeader& header = header_of(sample);
  const auto found = robots_.find(header.robot);
  if (found == robots_.end()) return refuse(Refusal::kUnknownRobot);
  Robot& robot = found->second;
  if (!follow(robot, channel_of(sample), header, finished)) return refuse(Refusal::kOutOfOrder);
  robot.heard_us = arrival_us;
  close_by_time(robot, header, finished);
  robot.newest_us = std::max(robot.newest_us, header.time_us);

  if (const auto* test_mark = std::get_if<TestMark>(&sample)) {
    if (!mark(robot, *test_mark, arrival_us, finished)) return refuse(Refusal::kUnknownTest);
  } else if (robot.run) {
    if (const auto* bar = std::get_if<BallbarBlock>(&sample)) add(robot, *bar);
    if (const auto* interferometer = std::get_if<InterferometerBlock>(&sample)) add(robot, *interferometer);
    if (const auto* joints = std::get_if<JointSample>(&sample)) add(robot, *joints);
    if (full(*robot.run)) close(robot, RunEnd::kTooLong, finished);
  }
  ++counters_.messages;
}

/// Keeps account of one stream's seq and time. False: a duplicate, or overtaken by later ones.
bool Assembler::follow(Robot& robot, Channel channel, const SampleHeader& header,
                       std::vector<Run>& finished) {
  Stream& stream = robot.streams[static_cast<std::size_t>(channel)];
  const std::int64_t seq_step = header.seq - stream.seq;
  const std::int64_t time_step = header.time_us - stream.time_us;
  std::int64_t lost = 0;
  if (stream.seen) {
    const bool fell_back = time_step < 0 && (seq_step <= 0 || time_step < -kReorderedUs);
    if (seq_step == 0 && time_step == 0) return false;
    if (fell_back && seq_step > -kReorderedMessages && time_step > -kReorderedUs) return false;
    if (seq_step <= 0 || seq_step > kBelievableLoss) {
      ++counters_.producer_restarts;
      // Behind a silence it is another session. Else how many are lost is not known: at least one.
      lost = fell_back || time_step > limits_.silence_us ? 0 : 1;
    } else {
      lost = seq_step - 1;
    }
    if (fell_back) {
      // A run of the time that now lies ahead cannot go on. One that began after the fall is not touched: the
      // other streams of the same producer fall back a moment later.
      const bool of_this_run = stream.run_number == robot.run_number;
      if (robot.run && (of_this_run || header.time_us < robot.run->started_us - kReorderedUs))
        close(robot, RunEnd::kProducerRestart, finished);
      robot.newest_us = header.time_us;
    }
  }
  stream = {true, header.seq, header.time_us, robot.run ? robot.run_number : 0};
  counters_.lost_messages += lost;
  if (robot.run) robot.run->lost_messages += lost;
  return true;
}

void Assembler::close_by_time(Robot& robot, const SampleHeader& header, std::vector<Run>& finished) {
  if (!robot.run) return;
  if (robot.ending && header.time_us > robot.run->ended_us + limits_.settle_us)
    close(robot, RunEnd::kMark, finished);
  else if (!robot.ending && header.time_us > robot.newest_us + limits_.silence_us)
    close(robot, RunEnd::kSilence, finished);
}

void Assembler::tick(std::int64_t arrival_us, std::vector<Run>& finished) {
  for (auto& [name, robot] : robots_) {
    if (!robot.run) continue;
    if (robot.ending && arrival_us - robot.ending_us >= limits_.settle_us)
      close(robot, RunEnd::kMark, finished);
    else if (!robot.ending && arrival_us - robot.heard_us > limits_.silence_us)
      close(robot, RunEnd::kSilence, finished);
  }
}

/// @return false for a test that is not configured
bool Assembler::mark(Robot& robot, const TestMark& mark, std::int64_t arrival_us,
                     std::vector<Run>& finished) {
  const TestSpec* test = robot.spec.find_test(mark.test);
  if (mark.mark == Mark::kBegin) {
    close(robot, robot.ending ? RunEnd::kMark : RunEnd::kNextBegin,
          finished);  // also by one that is not known
    if (test) begin(robot, mark, *test);
    robot.newest_us = mark.header.time_us;
  } else if (test && robot.run && !robot.ending && robot.run->test == mark.test) {
    robot.run->ended_us = mark.header.time_us;
    if (mark.mark == Mark::kAbort) {
      close(robot, RunEnd::kAborted, finished);
    } else {
      robot.ending = true;
      robot.ending_us = arrival_us;
    }
  }
  return test != nullptr;
}

void Assembler::begin(Robot& robot, const TestMark& mark, const TestSpec& test) {
  Run& run = robot.run.emplace();
  run.robot = robot.spec.name;
  run.test = test.name;
  run.kind = test.kind;
  run.direction = mark.direction;
  run.repetition = mark.repetition;
  run.series = mark.series;
  run.started_us = mark.header.time_us;
  run.feed = mark.feed > 0.0 ? mark.feed : test.feed;
  run.payload = mark.payload;
  run.temperature = mark.temperature;
  robot.ending = false;
  ++robot.run_number;
}

void Assembler::add(Robot& robot, const BallbarBlock& block) {
  Run& run = *robot.run;
  const double first = since(run, block.header.time_us);
  for (std::size_t i = 0; i < block.deviation.size(); ++i) {
    const double time = first + static_cast<double>(i) * block.period;
    if (time < 0.0 || (!run.bar_time.empty() && time <= run.bar_time.back())) continue;
    run.bar_time.push_back(time);
    run.bar_deviation.push_back(block.deviation[i]);
  }
}

void Assembler::add(Robot& robot, const InterferometerBlock& block) {
  Run& run = *robot.run;
  const double time = since(run, block.header.time_us);
  if (time < 0.0) return;
  for (std::size_t i = 0; i < block.position.size(); ++i)
    run.readings.push_back({block.axis, time, block.position[i], block.deviation[i]});
}

void Assembler::add(Robot& robot, const JointSample& sample) {
  Run& run = *robot.run;
  const double time = since(run, sample.header.time_us);
  const int joints = static_cast<int>(sample.position.size());
  if (time < 0.0 || (!run.joint_time.empty() && time <= run.joint_time.back())) return;
  if (run.joint_time.empty()) run.joints = joints;
  if (joints != run.joints) return refuse(Refusal::kCount);
  const bool first_with_torque = run.joint_time.empty() && !sample.torque.empty();
  run.joint_time.push_back(time);
  run.joint_position.insert(run.joint_position.end(), sample.position.begin(), sample.position.end());
  if (first_with_torque || !run.joint_torque.empty()) {
    if (sample.torque.empty())
      run.joint_torque.clear();  // torque that comes and goes is of no use
    else
      run.joint_torque.insert(run.joint_torque.end(), sample.torque.begin(), sample.torque.end());
  }
}

bool Assembler::full(const Run& run) const {
  return run.bar_time.size() > limits_.bar_samples || run.joint_time.size() > limits_.joint_samples ||
         run.readings.size() > limits_.readings;
}

void Assembler::close(Robot& robot, RunEnd end, std::vector<Run>& finished) {
  if (!robot.run) return;
  Run run = std::move(*robot.run);
  robot.run.reset();
  run.end = robot.ending && end != RunEnd::kAborted ? RunEnd::kMark : end;
  robot.ending = false;
  if (run.end != RunEnd::kMark && run.end != RunEnd::kAborted) run.ended_us = last_sample_us(run);
  cut_to_end(run);
  finished.push_back(std::move(run));
}

void Assembler::close_all(RunEnd end, std::vector<Run>& finished) {
  for (auto& [name, robot] : robots_) close(robot, end, finished);
}

void Assembler::receiver_restarted() {
  for (auto& [name, robot] : robots_)
    if (robot.run) ++robot.run->receiver_restarts;
}

int Assembler::open_runs() const {
  return static_cast<int>(std::count_if(robots_.begin(), robots_.end(),
                                        [](const auto& entry) { return entry.second.run.has_value(); }));
}

}  // namespace ballbar
