#pragma once
/// Runs of one robot that sends no marks: its circles are recognised, and their samples kept until they are
/// whole.

#include <cstdint>
#include <deque>
#include <map>
#include <memory>
#include <optional>
#include <utility>
#include <vector>

#include "core/recognition.hpp"
#include "core/run.hpp"
#include "core/samples.hpp"

namespace ballbar {

/// Stated maxima and waits.
struct UnmarkedLimits {
  std::size_t joint_samples = 100'000;  ///< kept while a circle is driven: nearly seven minutes at 250 Hz
  std::size_t bar_samples = 250'000;    ///< likewise
  std::size_t blocks = 20'000;          ///< that hold them
  std::size_t waiting = 16;             ///< circles that are over and not yet handed on
  std::int64_t settle_us = 500'000;     ///< after a circle is over, blocks that began before may still come
  std::int64_t lead_us = 2'000'000;     ///< by so much BALLBAR may come before the JOINTS of the same time
  std::int64_t silence_us = 2'000'000;  ///< without JOINTS (receiver's time) a path is over
};

/// Times called "arrival" are as in Assembler.
class UnmarkedRuns {
 public:
  explicit UnmarkedRuns(UnmarkedLimits limits = {}) : limits_(limits) {}

  /// @param recogniser  null: nothing is recognised and nothing kept
  void configure(RobotSpec robot, std::unique_ptr<Recogniser> recogniser);

  /// @param lost  messages of the same stream that are missing before this one
  void take(const JointSample& sample, std::int64_t lost, std::int64_t arrival_us,
            std::vector<Run>& finished);
  void take(const BallbarBlock& block, std::int64_t lost, std::vector<Run>& finished);

  void tick(std::int64_t arrival_us, std::vector<Run>& finished);

  /// The path ends here; circles that are complete are handed on.
  void end_path(std::vector<Run>& finished);

  /// Forgets the path so far; circles that were over are handed on.
  void drop_path(std::vector<Run>& finished);

  /// Something is missing, nobody knows how much: the path so far is of no use, circles that are over stay.
  void hole();

  /// Forgets all but the repetitions.
  void drop();

  /// Samples in memory, of joints and bar.
  std::size_t kept() const { return joints_.size() + bar_samples_; }

 private:
  template <typename T>
  struct Kept {
    T sample;
    std::int64_t lost = 0;  ///< messages that are missing before it
  };
  struct Waiting {
    Run run;
    std::int64_t arrival_us = 0;
  };

  void wait_for_blocks(const std::vector<RecognisedCircle>& found, std::int64_t arrival_us);
  void close_before(std::int64_t time_us, std::vector<Run>& finished);
  void close(Waiting& waiting, std::vector<Run>& finished);
  void close_all(std::vector<Run>& finished);
  void forget_joints();
  void forget_blocks();

  UnmarkedLimits limits_;
  RobotSpec robot_;
  std::unique_ptr<Recogniser> recogniser_;
  std::deque<Kept<JointSample>> joints_;
  std::deque<Kept<BallbarBlock>> blocks_;
  std::size_t bar_samples_ = 0;  ///< in blocks_
  std::int64_t joints_us_ = 0;   ///< producer's time of the last joint sample
  std::int64_t joints_arrival_us_ = 0;
  bool path_open_ = false;                                  ///< JOINTS have come since the path ended last
  std::vector<Waiting> waiting_;                            ///< circles that are over
  std::map<std::pair<std::string, int>, int> repetitions_;  ///< by test and direction
};

}  // namespace ballbar
