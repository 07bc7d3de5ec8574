#include "bus/assembler.hpp"

#include <algorithm>
#include <cmath>

#include "bus/append.hpp"
#include "core/units.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kReorderedMessages =
    64;  // UDP may overtake; further back is a producer that started again
constexpr std::int64_t kReorderedUs = 2'000'000;     // likewise in time
constexpr std::int64_t kBelievableLoss = 1'000'000;  // a larger jump in seq is a new count, not a loss

/// Time of the last sample that a run holds.
std::int64_t last_sample_us(const Run& run) {
  double last = 0.0;
  if (!run.bar_time.empty()) last = std::max(last, run.bar_time.back());
  if (!run.joint_time.empty()) last = std::max(last, run.joint_time.back());
  if (!run.readings.empty()) last = std::max(last, run.readings.back().time);
  return run.started_us + std::llround(last / kSecondsPerUs);
}

/// How many of the messages that were lost between two times belong to the run. An instrument may speak in
/// runs only: as many as find room between its begin and the message that came. Where the room of one is not
/// known: by the share of that time.
std::int64_t share_of_run(const Run& run, std::int64_t before_us, std::int64_t after_us, std::int64_t step_us,
                          std::int64_t lost) {
  if (before_us >= run.started_us || after_us <= before_us) return lost;
  if (step_us > 0) {
    const double room = static_cast<double>(after_us - run.started_us) / static_cast<double>(step_us);
    return std::clamp(std::llround(room), 0LL, static_cast<long long>(lost));
  }
  const double share =
      static_cast<double>(after_us - run.started_us) / static_cast<double>(after_us - before_us);
  return std::llround(share * static_cast<double>(lost));
}

/// Whether a message says that the run goes on. The robot's joints may be sent for ever: where the instrument
/// speaks, it decides.
bool keeps_alive(const std::optional<Run>& run, Channel channel) {
  if (!run || channel == Channel::kTestMark) return true;
  const bool heard = run->kind == TestKind::kCircle ? !run->bar_time.empty() : !run->readings.empty();
  return !heard || channel == (run->kind == TestKind::kCircle ? Channel::kBallbar : Channel::kInterferometer);
}

/// Whether two marks are of one run.
bool same_run(const TestMark& a, const TestMark& b) {
  const bool direction = a.direction == b.direction || a.direction == 0 || b.direction == 0;
  return a.test == b.test && a.series == b.series && a.repetition == b.repetition && direction;
}

}  // namespace

Assembler::Assembler(std::vector<RobotSpec> robots, AssemblerLimits limits, const MakeRecogniser& recogniser)
    : limits_(limits) {
  std::vector<Run> none;
  configure(std::move(robots), recogniser, none);
}

void Assembler::configure(std::vector<RobotSpec> robots, const MakeRecogniser& recogniser,
                          std::vector<Run>& finished) {
  std::map<std::string, Robot> next;
  for (RobotSpec& spec : robots) {
    Robot& robot = next.try_emplace(spec.name, limits_.unmarked).first->second;
    if (const auto old = robots_.find(spec.name); old != robots_.end()) {
      robot = std::move(old->second);
      robots_.erase(old);
    }
    robot.spec = std::move(spec);
    if (robot.run && !robot.spec.find_test(robot.run->test)) close(robot, RunEnd::kInterrupted, finished);
    robot.unmarked.drop_path(finished);
    robot.unmarked.configure(robot.spec, recogniser ? recogniser(robot.spec) : nullptr);
  }
  for (auto& [name, robot] : robots_) {
    close(robot, RunEnd::kInterrupted, finished);
    robot.unmarked.drop_path(finished);
  }
  robots_ = std::move(next);
}

void Assembler::take(const Sample& sample, std::int64_t arrival_us, std::vector<Run>& finished) {
  const SampleHeader& header = header_of(sample);
  const auto found = robots_.find(header.robot);
  if (found == robots_.end()) return refuse(Refusal::kUnknownRobot);
  Robot& robot = found->second;
  if (!follow(robot, channel_of(sample), header, finished)) return refuse(Refusal::kOutOfOrder);
  close_by_time(robot, header, finished);
  if (keeps_alive(robot.run, channel_of(sample))) {
    robot.heard_us = arrival_us;
    robot.newest_us = std::max(robot.newest_us, header.time_us);
  }
  if (const auto* test_mark = std::get_if<TestMark>(&sample)) {
    if (const auto refusal = mark(robot, *test_mark, arrival_us, finished)) return refuse(*refusal);
  } else if (robot.run) {
    add_to_run(robot, sample, finished);
  } else {
    add_unmarked(robot, sample, arrival_us, finished);
  }
  ++counters_.messages;
}

/// Keeps account of one stream's seq and time. False: a duplicate, or overtaken by later ones.
bool Assembler::follow(Robot& robot, Channel channel, const SampleHeader& header,
                       std::vector<Run>& finished) {
  Stream& stream = robot.streams[static_cast<std::size_t>(channel)];
  // seq may be anything, from anybody: unsigned, for it may wrap
  const auto seq_step = static_cast<std::int64_t>(static_cast<std::uint64_t>(header.seq) -
                                                  static_cast<std::uint64_t>(stream.seq));
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
      robot.unmarked.drop_path(finished);
    }
  }
  counters_.lost_messages += lost;
  if (robot.run && lost > 0) {
    robot.run->lost_messages +=
        share_of_run(*robot.run, stream.time_us, header.time_us, stream.step_us, lost);
    if (channel == Channel::kTestMark) robot.marks_lost = true;
  }
  const std::int64_t run_number = robot.run ? robot.run_number : 0;
  const bool neighbours = stream.seen && seq_step == 1 && time_step > 0;
  if (neighbours && run_number > 0 && run_number == stream.run_number) stream.step_us = time_step;
  stream = {true, header.seq, header.time_us, run_number, lost, stream.step_us};
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
    robot.unmarked.tick(arrival_us, finished);
    if (!robot.run) continue;
    if (robot.ending && arrival_us - robot.ending_us >= limits_.settle_us)
      close(robot, RunEnd::kMark, finished);
    else if (!robot.ending && arrival_us - robot.heard_us > limits_.silence_us)
      close(robot, RunEnd::kSilence, finished);
  }
}

/// @return why the mark is not believed; nothing where it is
std::optional<Refusal> Assembler::mark(Robot& robot, const TestMark& mark, std::int64_t arrival_us,
                                       std::vector<Run>& finished) {
  const TestSpec* test = robot.spec.find_test(mark.test);
  if (mark.mark == Mark::kCalibrated) {
    if (!test && !mark.test.empty()) return Refusal::kUnknownTest;
    if (calibrations_.size() < limits_.calibrations)
      calibrations_.push_back({robot.spec.name, mark.test, mark.header.time_us, mark.series});
    return {};
  }
  robot.marked_us = mark.header.time_us;
  if (mark.mark == Mark::kBegin)
    robot.unmarked.drop_path(finished);
  else
    robot.unmarked.drop();  // of a circle that is just over it is the end: its begin mark was lost
  if (mark.mark == Mark::kBegin) {
    const bool again =
        robot.run && robot.run->started_us == mark.header.time_us && same_run(*robot.last_begin, mark);
    if (again) return Refusal::kOutOfOrder;      // some bridges send marks twice, for UDP may lose one
    close(robot, RunEnd::kNextBegin, finished);  // also by a begin that is not known
    if (test) begin(robot, mark, *test);
    robot.newest_us = mark.header.time_us;
  } else if (test) {
    end(robot, mark, *test, arrival_us, finished);
  }
  if (!test) return Refusal::kUnknownTest;
  return {};
}

/// End and abort.
void Assembler::end(Robot& robot, const TestMark& mark, const TestSpec& test, std::int64_t arrival_us,
                    std::vector<Run>& finished) {
  if (!robot.last_begin || !same_run(*robot.last_begin, mark)) {
    // The marks between were lost: the open run ended somewhere, and this one began somewhere.
    robot.marks_lost = true;
    close(robot, RunEnd::kMarksLost, finished);
    begin(robot, mark, test);
    robot.run->ended_us = mark.header.time_us;
    close(robot, mark.mark == Mark::kAbort ? RunEnd::kAborted : RunEnd::kNoBegin, finished);
  } else if (robot.run && !robot.ending) {
    robot.run->ended_us = mark.header.time_us;
    robot.lost_before_end = robot.marks_lost;
    if (mark.mark == Mark::kAbort) return close(robot, RunEnd::kAborted, finished);
    robot.ending = true;
    robot.ending_us = arrival_us;
  }
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
  robot.last_begin = mark;
  robot.marks_lost = false;
  robot.lost_before_end = false;
  robot.ending = false;
  ++robot.run_number;
}

void Assembler::add_to_run(Robot& robot, const Sample& sample, std::vector<Run>& finished) {
  Run& run = *robot.run;
  if (const auto* bar = std::get_if<BallbarBlock>(&sample)) append(run, *bar);
  if (const auto* interferometer = std::get_if<InterferometerBlock>(&sample)) append(run, *interferometer);
  if (const auto* joints = std::get_if<JointSample>(&sample))
    if (!append(run, *joints)) refuse(Refusal::kCount);
  if (full(run)) close(robot, RunEnd::kTooLong, finished);
}

void Assembler::add_unmarked(Robot& robot, const Sample& sample, std::int64_t arrival_us,
                             std::vector<Run>& finished) {
  if (robot.marked_us && std::abs(header_of(sample).time_us - *robot.marked_us) < limits_.marked_us) return;
  const std::int64_t lost = robot.streams[static_cast<std::size_t>(channel_of(sample))].lost;
  if (const auto* joints = std::get_if<JointSample>(&sample))
    robot.unmarked.take(*joints, lost, arrival_us, finished);
  if (const auto* bar = std::get_if<BallbarBlock>(&sample)) robot.unmarked.take(*bar, lost, finished);
}

bool Assembler::full(const Run& run) const {
  return run.bar_time.size() > limits_.bar_samples || run.joint_time.size() > limits_.joint_samples ||
         run.readings.size() > limits_.readings;
}

/// @param end  as it looks from outside; that the end mark came, or that marks are missing, counts more
void Assembler::close(Robot& robot, RunEnd end, std::vector<Run>& finished) {
  if (!robot.run) return;
  Run run = std::move(*robot.run);
  robot.run.reset();
  run.end = end;
  if (robot.ending && end != RunEnd::kAborted) run.end = RunEnd::kMark;
  if (robot.lost_before_end && run.end == RunEnd::kMark) run.end = RunEnd::kMarksLost;
  if (robot.marks_lost && run.end == RunEnd::kNextBegin) run.end = RunEnd::kMarksLost;
  const bool has_end = run.end == RunEnd::kMark || run.end == RunEnd::kAborted || run.end == RunEnd::kNoBegin;
  if (!has_end && !robot.ending) run.ended_us = last_sample_us(run);
  robot.ending = false;
  cut_to_end(run);
  finished.push_back(std::move(run));
}

void Assembler::close_all(RunEnd end, std::vector<Run>& finished) {
  for (auto& [name, robot] : robots_) {
    close(robot, end, finished);
    robot.unmarked.end_path(finished);
  }
}

void Assembler::receiver_restarted() {
  for (auto& [name, robot] : robots_) {
    if (robot.run) ++robot.run->receiver_restarts;
    robot.unmarked.hole();
  }
}

int Assembler::open_runs() const {
  return static_cast<int>(std::count_if(robots_.begin(), robots_.end(),
                                        [](const auto& entry) { return entry.second.run.has_value(); }));
}

}  // namespace ballbar
