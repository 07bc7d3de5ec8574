// A robot that sends no marks: what is kept, what is handed on, and when marks win. The recogniser is one
// that does as the joints tell it.

#include "bus/unmarked.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <set>

#include "bus/assembler.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kUnmarkedT0 = 1'700'000'000'000'000;

/// J1 = 1: a circle is being driven; J1 falls to 0: it is over. J2 is its direction.
class Obedient : public Recogniser {
 public:
  void take(std::int64_t time_us, std::span<const double> q, std::vector<RecognisedCircle>& found) override {
    if (q[0] == 0.0) return end_path(found);
    if (!begin_us_) begin_us_ = time_us;
    direction_ = q[1] < 0.0 ? -1 : 1;
    end_us_ = time_us;
  }
  void end_path(std::vector<RecognisedCircle>& found) override {
    if (begin_us_) found.push_back({0, direction_, *begin_us_, end_us_, 0.05});
    reset();
  }
  void reset() override { begin_us_.reset(); }
  std::optional<std::int64_t> needed_since_us() const override { return begin_us_; }

 private:
  std::optional<std::int64_t> begin_us_;
  std::int64_t end_us_ = 0;
  int direction_ = 1;
};

class UnmarkedCell {
 public:
  explicit UnmarkedCell(const AssemblerLimits& limits = {}) : assembler({robot()}, limits, recogniser()) {}
  static RobotSpec robot() {
    RobotSpec spec;
    spec.name = "r1";
    spec.payload = 0.4;
    spec.tests.emplace_back().name = "A";
    return spec;
  }
  static MakeRecogniser recogniser() {
    return [](const RobotSpec&) { return std::make_unique<Obedient>(); };
  }
  void joints(double at_s, double on, double direction = 1.0, std::int64_t skip = 0) {
    joint_seq += 1 + skip;
    take(JointSample{header(at_s, joint_seq), {on, direction}, {}}, at_s);
  }
  /// One joint sample each 10 ms from begin to end, and one at the end that says the circle is over.
  void circle(double begin_s, double end_s, double direction = 1.0, bool with_bar = false) {
    for (double t = begin_s; t < end_s - 0.005; t += 0.01) {
      joints(t, 1.0, direction);
      const auto ms = static_cast<std::int64_t>(t * 1000.0 + 0.5);
      if (with_bar && ms % 200 == 0) bar(t);
    }
    joints(end_s, 0.0);
  }
  /// 50 samples, 4 ms apart.
  void bar(double at_s, std::int64_t skip = 0) {
    bar_seq += 1 + skip;
    take(BallbarBlock{header(at_s, bar_seq), 0.004, std::vector<double>(50, 1e-6)}, at_s);
  }
  void mark(double at_s, Mark mark, const std::string& test = "A") {
    TestMark m;
    m.header = header(at_s, ++mark_seq);
    m.test = test;
    m.mark = mark;
    m.direction = 1;
    m.repetition = 1;
    take(m, at_s);
  }
  SampleHeader header(double at_s, std::int64_t seq) const {
    return {clock_us + static_cast<std::int64_t>(at_s * 1e6 + 0.5), seq, "r1"};
  }
  void take(const Sample& sample, double at_s) {
    assembler.take(sample, static_cast<std::int64_t>(at_s * 1e6), finished);
  }
  void wait_until(double at_s) { assembler.tick(static_cast<std::int64_t>(at_s * 1e6), finished); }

  Assembler assembler;
  std::vector<Run> finished;
  std::int64_t clock_us = kUnmarkedT0;
  std::int64_t mark_seq = 0, bar_seq = 50, joint_seq = 7;
};

TEST(Unmarked, ACircleBecomesARunWithItsJoints) {
  UnmarkedCell cell;
  for (double t = 0.0; t < 2.0; t += 0.01) cell.joints(t, 0.0);
  cell.circle(2.0, 5.0);
  EXPECT_TRUE(cell.finished.empty()) << "blocks of the bar may still come";
  cell.wait_until(5.5);
  ASSERT_EQ(cell.finished.size(), 1u);
  const ballbar::Run& run = cell.finished[0];
  EXPECT_EQ(run.end, RunEnd::kGeometry);
  EXPECT_EQ(run.robot, "r1");
  EXPECT_EQ(run.test, "A");
  EXPECT_EQ(run.series, "");
  EXPECT_EQ(run.direction, 1);
  EXPECT_EQ(run.repetition, 1);
  EXPECT_EQ(run.started_us, kUnmarkedT0 + 2'000'000);
  EXPECT_EQ(run.ended_us, kUnmarkedT0 + 4'990'000);
  EXPECT_EQ(run.joints, 2);
  EXPECT_EQ(run.joint_time.size(), 300u);
  EXPECT_TRUE(run.bar_time.empty());
  EXPECT_DOUBLE_EQ(run.feed, 0.05);
  EXPECT_DOUBLE_EQ(run.payload, 0.4) << "the robot's, for the test has none";
}

TEST(Unmarked, TheBarsSamplesBetweenBeginAndEndGoWithIt) {
  for (const int way : {0, 1, 2}) {
    UnmarkedCell cell;
    cell.bar(1.9);  // began before the circle
    cell.circle(2.0, 5.0, 1.0, true);
    cell.bar(4.99, 0);
    if (way == 0) cell.wait_until(5.6);
    if (way == 1) cell.joints(5.6, 0.0);
    if (way == 2) cell.assembler.close_all(RunEnd::kInterrupted, cell.finished);
    ASSERT_EQ(cell.finished.size(), 1u) << "way " << way;
    const ballbar::Run& run = cell.finished[0];
    EXPECT_NEAR(run.bar_time.front(), 0.0, 0.0041);
    EXPECT_NEAR(run.bar_time.back(), 2.99, 0.0041);
    EXPECT_NEAR(static_cast<double>(run.bar_time.size()), 2.99 / 0.004, 2.0);
    EXPECT_TRUE(std::is_sorted(run.bar_time.begin(), run.bar_time.end()));
  }
}

/// Two neighbouring arcs whose overshoots reach further than the path: both begin where the path does.
class Twins : public Obedient {
 public:
  void end_path(std::vector<RecognisedCircle>& found) override {
    const std::size_t before = found.size();
    Obedient::end_path(found);
    if (found.size() == before) return;
    found.push_back(found.back());
    found.back().direction = -found.back().direction;
  }
};

TEST(Unmarked, TwoCirclesOfOneBeginAreTwoRuns) {
  UnmarkedCell cell;
  cell.assembler =
      Assembler({UnmarkedCell::robot()}, {}, [](const RobotSpec&) { return std::make_unique<Twins>(); });
  cell.circle(2.0, 5.0);
  cell.circle(6.0, 9.0);
  cell.wait_until(20.0);
  ASSERT_EQ(cell.finished.size(), 4u);
  std::set<std::int64_t> begins;  // by which a robot's runs are known
  for (const ballbar::Run& run : cell.finished) {
    begins.insert(run.started_us);
    EXPECT_EQ(run.joint_time.size(), 300u) << "no sample is lost";
  }
  EXPECT_EQ(begins.size(), 4u);
}

TEST(Unmarked, RepetitionsCountPerDirection) {
  UnmarkedCell cell;
  for (int i = 0; i < 6; ++i) cell.circle(10.0 * i, 10.0 * i + 3.0, i % 2 == 0 ? 1.0 : -1.0);
  cell.wait_until(100.0);
  ASSERT_EQ(cell.finished.size(), 6u);
  for (int i = 0; i < 6; ++i) {
    EXPECT_EQ(cell.finished[static_cast<std::size_t>(i)].repetition, 1 + i / 2);
    EXPECT_EQ(cell.finished[static_cast<std::size_t>(i)].direction, i % 2 == 0 ? 1 : -1);
  }
}

TEST(Unmarked, ARunWithMarksIsNotRecognisedASecondTime) {
  UnmarkedCell cell;
  cell.mark(0.9, Mark::kBegin);
  cell.circle(1.0, 4.0);
  cell.mark(4.1, Mark::kEnd);
  cell.circle(10.0, 13.0);  // this one's begin mark was lost
  cell.circle(599.0, 602.0);
  cell.wait_until(603.0);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].end, RunEnd::kMark);
  cell.circle(605.0, 608.0);
  cell.wait_until(609.0);
  ASSERT_EQ(cell.finished.size(), 2u) << "ten minutes without a mark: it sends none any more";
  EXPECT_EQ(cell.finished[1].end, RunEnd::kGeometry);
  EXPECT_EQ(cell.finished[1].joint_time.size(), 300u);
}

TEST(Unmarked, TheFirstMarkOfARobotWins) {
  UnmarkedCell begin_lost;
  begin_lost.circle(1.0, 4.0);
  begin_lost.mark(4.1, Mark::kEnd);
  begin_lost.wait_until(10.0);
  ASSERT_EQ(begin_lost.finished.size(), 1u);
  EXPECT_EQ(begin_lost.finished[0].end, RunEnd::kNoBegin) << "its labels are not known: no run without";

  UnmarkedCell within;
  for (double t = 1.0; t < 2.0; t += 0.01) within.joints(t, 1.0);
  within.mark(2.0, Mark::kBegin);
  within.circle(2.01, 4.0);
  within.mark(4.1, Mark::kEnd);
  within.wait_until(10.0);
  ASSERT_EQ(within.finished.size(), 1u);
  EXPECT_EQ(within.finished[0].end, RunEnd::kMark);

  UnmarkedCell before;  // the circle before it was driven without marks
  before.circle(1.0, 4.0);
  before.mark(4.1, Mark::kBegin);
  ASSERT_EQ(before.finished.size(), 1u);
  EXPECT_EQ(before.finished[0].end, RunEnd::kGeometry);

  UnmarkedCell stranger;  // a mark of a test that is not configured is a mark
  stranger.mark(0.0, Mark::kBegin, "no such test");
  stranger.circle(1.0, 4.0);
  stranger.wait_until(10.0);
  EXPECT_TRUE(stranger.finished.empty());
}

TEST(Unmarked, LostMessagesAreCountedInTheRunTheyFallInto) {
  UnmarkedCell cell;
  cell.joints(0.0, 0.0);
  cell.joints(0.99, 0.0, 1.0, 5);
  for (int i = 0; i < 100; ++i) cell.joints(1.0 + 0.01 * i, 1.0, 1.0, i == 50 ? 2 : 0);
  cell.bar(1.2);
  cell.bar(1.6, 1);
  cell.joints(2.0, 0.0, 1.0, 7);
  cell.wait_until(3.0);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].lost_messages, 3);
}

TEST(Unmarked, SilenceEndsAPath) {
  UnmarkedCell cell;
  for (double t = 1.0; t < 3.995; t += 0.01) cell.joints(t, 1.0);
  cell.wait_until(5.9);
  EXPECT_TRUE(cell.finished.empty());
  cell.wait_until(6.1);
  cell.wait_until(6.7);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].joint_time.size(), 300u);
  EXPECT_EQ(cell.finished[0].ended_us, kUnmarkedT0 + 3'990'000);
}

TEST(Unmarked, AHoleOfUnknownSizeForgetsThePath) {
  UnmarkedCell cell;
  cell.circle(1.0, 4.0);
  for (double t = 4.1; t < 5.0; t += 0.01) {
    cell.joints(t, 1.0);
    if (t < 4.105) cell.assembler.receiver_restarted();
  }
  cell.assembler.receiver_restarted();
  cell.joints(5.0, 0.0);
  cell.wait_until(9.0);
  ASSERT_EQ(cell.finished.size(), 1u) << "the circle that was over stays";
  EXPECT_EQ(cell.finished[0].receiver_restarts, 1);
  EXPECT_EQ(cell.finished[0].joint_time.size(), 300u);
}

TEST(Unmarked, AProducerThatRestartsStartsAnew) {
  UnmarkedCell cell;
  for (double t = 1000.0; t < 1003.0; t += 0.01) cell.joints(t, 1.0);
  cell.joint_seq = 0;
  cell.circle(1.0, 4.0);
  cell.wait_until(2000.0);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].started_us, kUnmarkedT0 + 1'000'000);
  EXPECT_EQ(cell.finished[0].joint_time.size(), 300u);
}

TEST(Unmarked, AnotherConfigurationHandsOnWhatIsOver) {
  UnmarkedCell cell;
  cell.circle(1.0, 4.0);
  for (double t = 4.1; t < 5.0; t += 0.01) cell.joints(t, 1.0);
  cell.assembler.configure({UnmarkedCell::robot()}, UnmarkedCell::recogniser(), cell.finished);
  ASSERT_EQ(cell.finished.size(), 1u);
  cell.joints(5.0, 0.0);
  cell.circle(6.0, 9.0);
  cell.wait_until(20.0);
  ASSERT_EQ(cell.finished.size(), 2u);
  EXPECT_EQ(cell.finished[1].started_us, kUnmarkedT0 + 6'000'000);
  EXPECT_EQ(cell.finished[1].repetition, 2) << "counted on";
}

TEST(Unmarked, WithoutRecogniserNothingHappens) {
  UnmarkedCell cell;
  cell.assembler.configure({UnmarkedCell::robot()}, {}, cell.finished);
  cell.circle(1.0, 4.0, 1.0, true);
  cell.wait_until(20.0);
  EXPECT_TRUE(cell.finished.empty());
}

/// UnmarkedRuns by itself, to look into its memory.
class Alone {
 public:
  explicit Alone(const UnmarkedLimits& limits) : runs(limits) {
    runs.configure(UnmarkedCell::robot(), std::make_unique<Obedient>());
  }
  void joints(std::int64_t at_us, double on) {
    runs.take(JointSample{{kUnmarkedT0 + at_us, ++seq, "r1"}, {on, 1.0}, {}}, 0, at_us, finished);
    most = std::max(most, runs.kept());
  }
  void bar(std::int64_t at_us, std::size_t samples) {
    runs.take(BallbarBlock{{kUnmarkedT0 + at_us, ++seq, "r1"}, 0.0, std::vector<double>(samples, 0.0)}, 0,
              finished);
    most = std::max(most, runs.kept());
  }
  UnmarkedRuns runs;
  std::vector<Run> finished;
  std::size_t most = 0;
  std::int64_t seq = 0;
};

TEST(Unmarked, WhereNoCircleIsDrivenNothingIsKept) {
  Alone alone(UnmarkedLimits{});
  for (std::int64_t i = 0; i < 200'000; ++i) alone.joints(i * 4000, 0.0);
  EXPECT_LE(alone.most, 1u);
  for (std::int64_t i = 0; i < 20'000; ++i) alone.bar(i * 200'000, 50);
  EXPECT_LE(alone.most, 600u) << "the last two seconds";
}

TEST(Unmarked, ACircleThatNeverEndsStaysWithinTheStatedMemory) {
  UnmarkedLimits limits;
  limits.joint_samples = 1000;
  limits.bar_samples = 2000;
  limits.blocks = 100;
  Alone alone(limits);
  for (std::int64_t i = 0; i < 50'000; ++i) {
    alone.joints(i * 4000, 1.0);
    alone.bar(i * 4000, i % 7 == 0 ? 50 : 1);
  }
  EXPECT_LE(alone.most, limits.joint_samples + limits.bar_samples);
  alone.joints(50'000 * 4000, 0.0);
  alone.runs.end_path(alone.finished);
  EXPECT_TRUE(alone.finished.empty()) << "its begin is gone: no run of a part";
  for (std::int64_t i = 50'001; i < 50'500; ++i) alone.joints(i * 4000, 1.0);
  alone.runs.end_path(alone.finished);
  EXPECT_EQ(alone.finished.size(), 1u) << "the next one is whole";
}

}  // namespace
}  // namespace ballbar
