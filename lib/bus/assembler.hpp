#pragma once
/// Samples and marks of configured robots into finished Runs. Pure: time comes in with every call.

#include <array>
#include <cstdint>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "bus/channels.hpp"
#include "bus/unmarked.hpp"
#include "core/baseline_mark.hpp"
#include "core/run.hpp"
#include "core/samples.hpp"
#include "core/spec.hpp"

namespace ballbar {

/// Stated maxima and waits of the assembler.
struct AssemblerLimits {
  /// A robot that sent a mark so short a time ago (its own clock) says itself what it drives: a mark that was
  /// lost must not turn a labelled run into one without labels.
  std::int64_t marked_us = 600'000'000;
  UnmarkedLimits unmarked;
  std::int64_t silence_us =
      30'000'000;                     ///< a run without end mark closes after this much silence of its robot
  std::int64_t settle_us = 500'000;   ///< after the end mark, blocks that began before it may still come
  std::size_t bar_samples = 250'000;  ///< per run: four minutes at 1 kHz
  std::size_t joint_samples = 250'000;  ///< per run
  std::size_t readings = 200'000;       ///< per run
  std::size_t calibrations = 100;       ///< marks that wait to be fetched; more are lost
};

struct AssemblerCounters {
  std::int64_t messages = 0;                      ///< believed
  std::array<std::int64_t, kRefusals> refused{};  ///< by reason
  std::int64_t lost_messages = 0;                 ///< by holes in seq, of all streams
  std::int64_t producer_restarts = 0;             ///< seq fell back

  std::int64_t refused_total() const {
    std::int64_t sum = 0;
    for (const std::int64_t n : refused) sum += n;
    return sum;
  }
};

/// Times called "arrival" are of one steady clock of the receiver (or the log's own times in a replay); they
/// only measure silence. All times in Runs are the producers'.
class Assembler {
 public:
  /// @param recogniser  for robots without marks; empty: only marks make runs
  explicit Assembler(std::vector<RobotSpec> robots, AssemblerLimits limits = {},
                     const MakeRecogniser& recogniser = {});

  /// Takes one message; runs that it finished are appended to `finished`.
  void take(const Sample& sample, std::int64_t arrival_us, std::vector<Run>& finished);

  /// What marks said of calibrations since the last call.
  std::vector<BaselineMark> calibrations() { return std::exchange(calibrations_, {}); }

  /// Counts a message that the decoder refused.
  void refuse(Refusal reason) {
    ++counters_.refused[static_cast<std::size_t>(reason)];
    last_refusal_ = reason;
  }
  Refusal last_refusal() const { return last_refusal_; }

  /// Closes what has been silent for too long. Call it at least twice a second.
  void tick(std::int64_t arrival_us, std::vector<Run>& finished);

  /// The receive path died and was started again: a hole of unknown size in every open run.
  void receiver_restarted();

  /// Closes all open runs, e.g. when the service stops (kInterrupted) or a log ends (kSilence).
  void close_all(RunEnd end, std::vector<Run>& finished);

  /// Another configuration. Open runs of robots that stay go on; a circle that is driven without marks at
  /// this moment is not recognised.
  void configure(std::vector<RobotSpec> robots, const MakeRecogniser& recogniser, std::vector<Run>& finished);

  const AssemblerCounters& counters() const { return counters_; }
  int open_runs() const;

 private:
  struct Stream {
    bool seen = false;
    std::int64_t seq = 0;
    std::int64_t time_us = 0;
    std::int64_t run_number = 0;  ///< of the run that was open at its last message; 0: none was
    std::int64_t lost = 0;        ///< messages that are missing before its last one
    std::int64_t step_us = 0;     ///< between two neighbouring messages of one run; 0: not known yet
  };
  struct Robot {
    explicit Robot(const UnmarkedLimits& limits) : unmarked(limits) {}
    UnmarkedRuns unmarked;
    RobotSpec spec;
    std::array<Stream, kInputChannels.size()> streams;
    std::optional<Run> run;
    std::int64_t run_number = 0;            ///< counts the runs of this robot
    std::optional<TestMark> last_begin;     ///< of the open run, or of the one that closed last
    bool marks_lost = false;                ///< since the open run's begin mark
    bool lost_before_end = false;           ///< likewise, when its end mark came
    bool ending = false;                    ///< the end mark came; late blocks may follow
    std::int64_t ending_us = 0;             ///< arrival of the end mark
    std::int64_t heard_us = 0;              ///< arrival of the last message that says the run goes on
    std::int64_t newest_us = 0;             ///< newest producer's time of such a message
    std::optional<std::int64_t> marked_us;  ///< producer's time of the last mark
  };

  bool follow(Robot& robot, Channel channel, const SampleHeader& header, std::vector<Run>& finished);
  void close(Robot& robot, RunEnd end, std::vector<Run>& finished);
  void close_by_time(Robot& robot, const SampleHeader& header, std::vector<Run>& finished);
  void begin(Robot& robot, const TestMark& mark, const TestSpec& test);
  std::optional<Refusal> mark(Robot& robot, const TestMark& mark, std::int64_t arrival_us,
                              std::vector<Run>& finished);
  void end(Robot& robot, const TestMark& mark, const TestSpec& test, std::int64_t arrival_us,
           std::vector<Run>& finished);
  void add_to_run(Robot& robot, const Sample& sample, std::vector<Run>& finished);
  void add_unmarked(Robot& robot, const Sample& sample, std::int64_t arrival_us, std::vector<Run>& finished);
  bool full(const Run& run) const;

  AssemblerLimits limits_;
  std::map<std::string, Robot> robots_;
  AssemblerCounters counters_;
  std::vector<BaselineMark> calibrations_;
  Refusal last_refusal_ = Refusal::kTruncated;
};

}  // namespace ballbar
