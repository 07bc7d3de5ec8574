#include "bus/unmarked.hpp"

#include <algorithm>
#include <cmath>

#include "bus/append.hpp"
#include "core/units.hpp"

namespace ballbar {
namespace {

std::int64_t end_of(const BallbarBlock& block) {
  const double last = static_cast<double>(block.deviation.size()) * block.period;
  return block.header.time_us + std::llround(last / kSecondsPerUs);
}

}  // namespace

void UnmarkedRuns::configure(RobotSpec robot, std::unique_ptr<Recogniser> recogniser) {
  drop();
  robot_ = std::move(robot);
  recogniser_ = std::move(recogniser);
}

void UnmarkedRuns::take(const JointSample& sample, std::int64_t lost, std::int64_t arrival_us,
                        std::vector<Run>& finished) {
  if (!recogniser_) return;
  close_before(sample.header.time_us, finished);
  joints_.push_back({sample, lost});
  joints_us_ = sample.header.time_us;
  joints_arrival_us_ = arrival_us;
  path_open_ = true;
  std::vector<RecognisedCircle> found;
  recogniser_->take(joints_us_, sample.position, found);
  wait_for_blocks(found, arrival_us);
  forget_joints();
}

void UnmarkedRuns::take(const BallbarBlock& block, std::int64_t lost, std::vector<Run>& finished) {
  if (!recogniser_) return;
  close_before(block.header.time_us, finished);
  blocks_.push_back({block, lost});
  bar_samples_ += block.deviation.size();
  forget_blocks();
}

void UnmarkedRuns::tick(std::int64_t arrival_us, std::vector<Run>& finished) {
  if (path_open_ && arrival_us - joints_arrival_us_ > limits_.silence_us) {
    std::vector<RecognisedCircle> found;
    recogniser_->end_path(found);
    path_open_ = false;
    wait_for_blocks(found, arrival_us);
    joints_.clear();
  }
  for (Waiting& waiting : waiting_)
    if (arrival_us - waiting.arrival_us >= limits_.settle_us) close(waiting, finished);
  std::erase_if(waiting_, [](const Waiting& waiting) { return waiting.run.robot.empty(); });
}

void UnmarkedRuns::end_path(std::vector<Run>& finished) {
  if (!recogniser_) return;
  std::vector<RecognisedCircle> found;
  recogniser_->end_path(found);
  wait_for_blocks(found, joints_arrival_us_);
  drop_path(finished);
}

void UnmarkedRuns::drop_path(std::vector<Run>& finished) {
  close_all(finished);
  drop();
}

void UnmarkedRuns::hole() {
  if (recogniser_) recogniser_->reset();
  joints_.clear();
  for (Waiting& waiting : waiting_) ++waiting.run.receiver_restarts;
}

void UnmarkedRuns::drop() {
  if (recogniser_) recogniser_->reset();
  joints_.clear();
  blocks_.clear();
  bar_samples_ = 0;
  path_open_ = false;
  waiting_.clear();
}

/// Makes runs of circles that are over. One whose first samples had to be forgotten gives none.
void UnmarkedRuns::wait_for_blocks(const std::vector<RecognisedCircle>& found, std::int64_t arrival_us) {
  for (const RecognisedCircle& circle : found) {
    if (joints_.empty() || joints_.front().sample.header.time_us > circle.begin_us) continue;
    const TestSpec& test = robot_.tests.at(circle.test);
    Run run;
    run.robot = robot_.name;
    run.test = test.name;
    run.kind = test.kind;
    run.direction = circle.direction;
    run.repetition = ++repetitions_[{test.name, circle.direction}];
    run.started_us = circle.begin_us;
    run.ended_us = circle.end_us;
    run.end = RunEnd::kGeometry;
    run.feed = circle.feed;
    run.payload = test.payload.value_or(robot_.payload);
    for (const auto& [sample, lost] : joints_) {
      if (sample.header.time_us < circle.begin_us || sample.header.time_us > circle.end_us) continue;
      if (sample.header.time_us > circle.begin_us) run.lost_messages += lost;
      append(run, sample);
    }
    waiting_.push_back({std::move(run), arrival_us});
  }
}

/// Closes what ended long enough before this producer's time.
void UnmarkedRuns::close_before(std::int64_t time_us, std::vector<Run>& finished) {
  for (Waiting& waiting : waiting_)
    if (time_us > waiting.run.ended_us + limits_.settle_us || waiting_.size() > limits_.waiting)
      close(waiting, finished);
  std::erase_if(waiting_, [](const Waiting& waiting) { return waiting.run.robot.empty(); });
}

/// Leaves a run without name behind.
void UnmarkedRuns::close(Waiting& waiting, std::vector<Run>& finished) {
  Run run = std::move(waiting.run);
  waiting.run.robot.clear();
  for (const auto& [block, lost] : blocks_) {
    if (block.header.time_us > run.started_us && block.header.time_us <= run.ended_us)
      run.lost_messages += lost;
    append(run, block);
  }
  cut_to_end(run);
  finished.push_back(std::move(run));
}

void UnmarkedRuns::close_all(std::vector<Run>& finished) {
  for (Waiting& waiting : waiting_) close(waiting, finished);
  waiting_.clear();
}

void UnmarkedRuns::forget_joints() {
  const std::int64_t since = recogniser_->needed_since_us().value_or(joints_us_);
  while (!joints_.empty() &&
         (joints_.front().sample.header.time_us < since || joints_.size() > limits_.joint_samples))
    joints_.pop_front();
}

void UnmarkedRuns::forget_blocks() {
  std::int64_t since = blocks_.back().sample.header.time_us - limits_.lead_us;
  if (const auto needed = recogniser_->needed_since_us()) since = std::min(since, *needed);
  for (const Waiting& waiting : waiting_) since = std::min(since, waiting.run.started_us);
  while (!blocks_.empty() && (end_of(blocks_.front().sample) < since || blocks_.size() > limits_.blocks ||
                              bar_samples_ > limits_.bar_samples)) {
    bar_samples_ -= blocks_.front().sample.deviation.size();
    blocks_.pop_front();
  }
}

}  // namespace ballbar
