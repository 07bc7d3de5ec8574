// Streams into runs: a producer's day, told message by message.

#include "bus/assembler.hpp"

#include <gtest/gtest.h>

#include <limits>

namespace ballbar {
namespace {

constexpr std::int64_t kT0 = 1'700'000'000'000'000;
constexpr std::int64_t kSecond = 1'000'000;

/// A robot with a circle A and a line Y, its streams, and a receiver's clock that follows the producer's.
class Cell {
 public:
  explicit Cell(AssemblerLimits limits = {}) : assembler({robot()}, limits) {}

  static RobotSpec robot() {
    RobotSpec spec;
    spec.name = "r1";
    TestSpec circle;
    circle.name = "A";
    circle.feed = 0.05;
    TestSpec line;
    line.name = "Y";
    line.kind = TestKind::kLine;
    spec.tests = {circle, line};
    return spec;
  }

  void mark(double at_s, Mark mark, const std::string& test = "A", int direction = 1, int repetition = 1) {
    TestMark m;
    m.header = header(at_s, ++mark_seq);
    m.test = test;
    m.mark = mark;
    m.direction = direction;
    m.repetition = repetition;
    m.series = "s";
    m.feed = feed;
    take(m, at_s);
  }
  /// 50 samples, 4 ms apart.
  void bar(double at_s, std::int64_t skip = 0) {
    bar_seq += 1 + skip;
    take(BallbarBlock{header(at_s, bar_seq), 0.004, std::vector<double>(50, 1e-6)}, at_s);
  }
  void joints(double at_s, std::int64_t skip = 0) {
    joint_seq += 1 + skip;
    take(JointSample{header(at_s, joint_seq), {0, 1, 2, 3, 4, 5}, {}}, at_s);
  }
  void reading(double at_s, double position) {
    take(InterferometerBlock{header(at_s, ++reading_seq), 'X', {position}, {1e-6}}, at_s);
  }
  SampleHeader header(double at_s, std::int64_t seq) const {
    return {clock_us + static_cast<std::int64_t>(at_s * 1e6), seq, "r1"};
  }
  void take(const Sample& sample, double at_s) {
    assembler.take(sample, static_cast<std::int64_t>(at_s * 1e6), finished);
  }
  void wait_until(double at_s) { assembler.tick(static_cast<std::int64_t>(at_s * 1e6), finished); }

  Assembler assembler;
  std::vector<Run> finished;
  std::int64_t clock_us = kT0;  ///< producer's clock at second 0
  std::int64_t mark_seq = 100, bar_seq = 2000, joint_seq = 5, reading_seq = 77;
  double feed = 0.0;
};

TEST(Assembler, ARunIsWhatLiesBetweenItsMarks) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(-0.1);  // sent when it was full: its first half lies before the begin
  cell.joints(0.01);
  cell.bar(0.1);
  cell.joints(0.2);
  cell.bar(0.3);
  cell.mark(0.4, Mark::kEnd);
  EXPECT_TRUE(cell.finished.empty()) << "blocks that began before the end may still come";
  cell.wait_until(1.0);
  ASSERT_EQ(cell.finished.size(), 1u);
  const ballbar::Run& run = cell.finished[0];
  EXPECT_EQ(run.end, RunEnd::kMark);
  EXPECT_EQ(run.robot, "r1");
  EXPECT_EQ(run.test, "A");
  EXPECT_EQ(run.started_us, kT0);
  EXPECT_EQ(run.ended_us, kT0 + 400'000);
  EXPECT_EQ(run.joint_time.size(), 2u);
  EXPECT_EQ(run.joints, 6);
  EXPECT_EQ(run.bar_time.size(), 101u);  // 25 of the first block, 50, and 26 of the last: 0.3, 0.304, ... 0.4
  EXPECT_LE(run.bar_time.back(), 0.4);
  EXPECT_DOUBLE_EQ(run.feed, 0.05);  // as configured, for the mark says 0
  EXPECT_EQ(run.lost_messages, 0);
}

TEST(Assembler, ACalibrationIsNoRunAndEndsNone) {
  Cell cell;
  cell.mark(0, Mark::kBegin);
  for (double t = 0.5; t < 5; t += 0.2) cell.bar(t);
  cell.mark(5, Mark::kCalibrated, "");
  for (double t = 5.1; t < 10; t += 0.2) cell.bar(t);
  cell.mark(10, Mark::kEnd);
  cell.mark(20, Mark::kCalibrated, "Y");
  cell.mark(21, Mark::kCalibrated, "Q");
  EXPECT_EQ(cell.assembler.last_refusal(), Refusal::kUnknownTest);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished.front().end, RunEnd::kMark);
  const std::vector<BaselineMark> said = cell.assembler.calibrations();
  ASSERT_EQ(said.size(), 2u);
  EXPECT_EQ(said[0].robot, "r1");
  EXPECT_EQ(said[0].test, "") << "all tests";
  EXPECT_EQ(said[0].at_us, kT0 + 5 * kSecond);
  EXPECT_EQ(said[0].note, "s");
  EXPECT_EQ(said[1].test, "Y");
  EXPECT_TRUE(cell.assembler.calibrations().empty()) << "each is told once";
  for (int i = 0; i < 200; ++i) cell.mark(30 + i, Mark::kCalibrated, "");
  EXPECT_EQ(cell.assembler.calibrations().size(), 100u) << "the stated maximum";
}

TEST(Assembler, ABlockThatComesAfterTheEndMarkStillCounts) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  cell.mark(0.39, Mark::kEnd);
  cell.bar(0.2);  // began before the end, was sent after it
  cell.wait_until(2.0);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].bar_time.size(), 98u);
}

TEST(Assembler, TheSameRunComesOutWhetherTimeOrTheNextMessageClosesIt) {
  for (const int way : {0, 1, 2}) {
    Cell cell;
    cell.mark(0.0, Mark::kBegin);
    cell.bar(0.0);
    cell.mark(0.5, Mark::kEnd);
    cell.bar(0.2);
    if (way == 0) cell.wait_until(1.2);
    if (way == 1) cell.bar(3.0);
    if (way == 2) cell.mark(3.0, Mark::kBegin);
    ASSERT_EQ(cell.finished.size(), 1u) << "way " << way;
    EXPECT_EQ(cell.finished[0].end, RunEnd::kMark);
    EXPECT_EQ(cell.finished[0].bar_time.size(), 100u);
    EXPECT_EQ(cell.finished[0].ended_us, kT0 + 500'000);
  }
}

TEST(Assembler, CountsHolesInSeqInTheRunTheyFallInto) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  cell.bar(0.2, 3);
  cell.joints(0.3);
  cell.joints(0.4, 1);
  cell.mark(0.5, Mark::kEnd);
  cell.wait_until(2.0);
  cell.joints(9.0, 10);  // between the runs: a loss of the stream, of no run
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].lost_messages, 4);
  EXPECT_EQ(cell.assembler.counters().lost_messages, 14);
}

TEST(Assembler, AHoleBeforeTheLastMessageOfARunIsSeenByTheFirstOneBehindIt) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  cell.mark(0.4, Mark::kEnd);
  cell.bar(5.0, 1);  // the block before the end was lost
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].lost_messages, 1);
}

TEST(Assembler, AnAbortedRunLeavesARow) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  cell.mark(0.3, Mark::kAbort);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].end, RunEnd::kAborted);
  EXPECT_EQ(cell.assembler.open_runs(), 0);
}

TEST(Assembler, ARunWithoutEndClosesAfterTheStatedSilence) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  cell.wait_until(30.0);
  EXPECT_TRUE(cell.finished.empty());
  cell.wait_until(30.1);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].end, RunEnd::kSilence);
  EXPECT_EQ(cell.finished[0].ended_us, kT0 + 196'000);  // the last sample that came
}

TEST(Assembler, SilenceIsSeenInTheProducersTimeToo) {
  Cell cell;  // as in a fast replay: the receiver's clock hardly moves
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  cell.assembler.take(JointSample{cell.header(40.0, 6), {0, 1, 2, 3, 4, 5}, {}}, 1000, cell.finished);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].end, RunEnd::kSilence);
  EXPECT_TRUE(cell.finished[0].joint_time.empty());
}

TEST(Assembler, TheNextBeginClosesARunWithoutEnd) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  cell.mark(5.0, Mark::kBegin, "A", -1, 2);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].end, RunEnd::kNextBegin);
  EXPECT_EQ(cell.assembler.open_runs(), 1);
}

TEST(Assembler, AProducerThatRestartsStartsAnew) {
  Cell cell;
  cell.mark(100.0, Mark::kBegin);
  for (int i = 0; i < 5; ++i) cell.bar(100.0 + 0.2 * i);
  // The log is played again from its start: seq and time of all streams fall back, one after the other.
  cell.mark_seq = 0;
  cell.bar_seq = 1000;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  cell.bar(0.2);
  cell.mark(0.4, Mark::kEnd);
  cell.wait_until(200.0);
  ASSERT_EQ(cell.finished.size(), 2u);
  EXPECT_EQ(cell.finished[0].end, RunEnd::kProducerRestart);
  EXPECT_EQ(cell.finished[1].end, RunEnd::kMark);
  EXPECT_EQ(cell.finished[1].started_us, kT0);
  EXPECT_EQ(cell.finished[1].bar_time.size(), 100u);
  EXPECT_EQ(cell.finished[1].lost_messages, 0);
}

TEST(Assembler, AStreamThatFallsBackInTheMiddleEndsTheRun) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  cell.bar(10.0);
  cell.clock_us -= 3600 * kSecond;  // the producer's clock is set back by an hour
  cell.bar(10.2);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].end, RunEnd::kProducerRestart);
}

TEST(Assembler, ABridgeThatCountsAnewWhileTimeGoesOnCostsAtLeastOneMessage) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  cell.bar_seq = 0;
  cell.bar(0.4);
  cell.mark(0.6, Mark::kEnd);
  cell.wait_until(2.0);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].lost_messages, 1);
  EXPECT_EQ(cell.assembler.counters().producer_restarts, 1);
}

TEST(Assembler, ASessionOfAnotherDayCountsAnewAndLosesNothing) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  cell.mark(0.2, Mark::kEnd);
  cell.mark_seq = 3;
  cell.bar_seq = 7;
  cell.mark(86400.0, Mark::kBegin);
  cell.bar(86400.0);
  cell.mark(86400.2, Mark::kEnd);
  cell.wait_until(86402.0);
  ASSERT_EQ(cell.finished.size(), 2u);
  EXPECT_EQ(cell.finished[1].lost_messages, 0);
  EXPECT_EQ(cell.assembler.counters().lost_messages, 0);
  EXPECT_EQ(cell.assembler.counters().producer_restarts, 2);
}

TEST(Assembler, DuplicatesAndOvertakenMessagesAreRefused) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  const BallbarBlock same{cell.header(0.0, cell.bar_seq), 0.004, std::vector<double>(50, 9e-6)};
  cell.take(same, 0.0);
  cell.bar(0.2);
  cell.bar(0.6, 1);
  cell.take(BallbarBlock{cell.header(0.4, cell.bar_seq - 1), 0.004, std::vector<double>(50, 9e-6)}, 0.6);
  cell.mark(1.0, Mark::kEnd);
  cell.wait_until(2.0);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].bar_time.size(), 150u);
  EXPECT_EQ(cell.finished[0].lost_messages, 1);
  EXPECT_EQ(cell.assembler.counters().refused[static_cast<std::size_t>(Refusal::kOutOfOrder)], 2);
}

TEST(Assembler, StrangersAreRefusedAndCounted) {
  Cell cell;
  TestMark mark;
  mark.header = {kT0, 1, "somebody"};
  mark.test = "A";
  cell.take(mark, 0.0);
  cell.mark(0.0, Mark::kBegin, "no such test");
  EXPECT_EQ(cell.assembler.open_runs(), 0);
  EXPECT_EQ(cell.assembler.counters().refused[static_cast<std::size_t>(Refusal::kUnknownRobot)], 1);
  EXPECT_EQ(cell.assembler.counters().refused[static_cast<std::size_t>(Refusal::kUnknownTest)], 1);
  EXPECT_EQ(cell.assembler.counters().messages, 0);
}

TEST(Assembler, ABeginOfAnUnknownTestDoesNotPourIntoTheRunBeforeIt) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  cell.mark(1.0, Mark::kBegin, "no such test");
  cell.bar(1.2);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].bar_time.size(), 50u);
}

// What a receiver that dies between two runs leaves behind: the end of the first and the begin of the second
// are gone.
TEST(Assembler, TwoRunsWhoseMarksWereLostAreNotTakenForOne) {
  for (const bool same_labels : {false, true}) {
    Cell cell;
    cell.mark(0.0, Mark::kBegin, "A", 1);
    cell.bar(0.0);
    cell.mark_seq += 2;
    cell.bar(4.0);
    cell.mark(5.0, Mark::kEnd, "A", same_labels ? 1 : -1);
    cell.wait_until(7.0);
    ASSERT_EQ(cell.finished.size(), same_labels ? 1u : 2u);
    EXPECT_EQ(cell.finished[0].end, RunEnd::kMarksLost);
    if (!same_labels) {
      EXPECT_EQ(cell.finished[1].end, RunEnd::kNoBegin);
      EXPECT_EQ(cell.finished[1].direction, -1);
      EXPECT_EQ(cell.finished[1].started_us, kT0 + 5 * kSecond);
    }
  }
}

TEST(Assembler, AnEndWithoutBeginLeavesARow) {
  Cell cell;
  cell.bar(0.0);
  cell.mark(1.0, Mark::kEnd);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].end, RunEnd::kNoBegin);
  cell.mark(1.0, Mark::kEnd);  // the same again, by a bridge that sends marks twice
  EXPECT_EQ(cell.finished.size(), 1u);
}

TEST(Assembler, MarksThatAreSentTwiceMakeOneRun) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  cell.mark(0.5, Mark::kEnd);
  cell.mark(0.5, Mark::kEnd);
  cell.wait_until(2.0);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].end, RunEnd::kMark);
  EXPECT_EQ(cell.finished[0].bar_time.size(), 50u);
}

TEST(Assembler, JointsAloneDoNotKeepARunAliveWhoseBarFellSilent) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  for (int i = 0; i < 40; ++i) cell.joints(1.0 + i);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].end, RunEnd::kSilence);
}

TEST(Assembler, ALossBeforeTheBeginIsNotTheRunsOwn) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  cell.mark(0.4, Mark::kEnd);
  cell.mark(10.0, Mark::kBegin);
  cell.bar(10.0, 5);  // five messages lost in 10 s, of which the run saw none
  cell.mark(10.4, Mark::kEnd);
  cell.wait_until(12.0);
  ASSERT_EQ(cell.finished.size(), 2u);
  EXPECT_EQ(cell.finished[1].lost_messages, 0);
  EXPECT_EQ(cell.assembler.counters().lost_messages, 5);
}

// The bar speaks every 0.2 s, in runs only; its cable is out for the whole second run and for `late` messages
// of the third.
TEST(Assembler, WhatWasLostInTheRunsBeforeIsNotThisOnes) {
  for (const int late : {0, 1, 3}) {
    Cell cell;
    for (const double begin : {0.0, 10.0, 20.0}) {
      cell.mark(begin, Mark::kBegin);
      for (int i = 0; i < 5; ++i) {
        const double at = begin + 0.2 * i + 0.01;
        cell.joints(at);
        if (begin == 10.0 || (begin == 20.0 && i < late))
          ++cell.bar_seq;
        else
          cell.bar(at);
      }
      cell.mark(begin + 1.0, Mark::kEnd);
      cell.wait_until(begin + 5.0);
    }
    ASSERT_EQ(cell.finished.size(), 3u);
    EXPECT_EQ(cell.finished[0].lost_messages, 0);
    EXPECT_TRUE(cell.finished[1].bar_time.empty());
    EXPECT_EQ(cell.finished[1].lost_messages, 0) << "it was over before anybody could know";
    EXPECT_EQ(cell.finished[2].lost_messages, late);
    EXPECT_EQ(cell.assembler.counters().lost_messages, 5 + late);
  }
}

TEST(Assembler, SeqMayBeAnything) {
  Cell cell;
  cell.mark_seq = std::numeric_limits<std::int64_t>::max() - 1;
  cell.mark(0.0, Mark::kBegin);
  cell.bar_seq = std::numeric_limits<std::int64_t>::min();
  cell.bar(0.0);
  cell.bar_seq = std::numeric_limits<std::int64_t>::max() - 1;
  cell.bar(0.2);
  cell.wait_until(100.0);
  EXPECT_EQ(cell.finished.size(), 1u);
}

TEST(Assembler, ADeadReceiverIsAHoleInEveryOpenRun) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  cell.assembler.receiver_restarted();
  cell.bar(1.0, 4);
  cell.mark(1.5, Mark::kEnd);
  cell.wait_until(3.0);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].receiver_restarts, 1);
  EXPECT_EQ(cell.finished[0].lost_messages, 4);
  EXPECT_EQ(cell.finished[0].end, RunEnd::kMark);
}

TEST(Assembler, ARunThatNeverEndsStopsAtTheStatedMaximum) {
  AssemblerLimits limits;
  limits.bar_samples = 120;
  Cell cell(limits);
  cell.mark(0.0, Mark::kBegin);
  for (int i = 0; i < 4; ++i) cell.bar(0.2 * i);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].end, RunEnd::kTooLong);
}

TEST(Assembler, ALineCollectsItsReadings) {
  Cell cell;
  cell.feed = 0.1;
  cell.mark(0.0, Mark::kBegin, "Y");
  for (int i = 0; i < 5; ++i) cell.reading(1.0 + i, 0.1 * i);
  cell.mark(6.0, Mark::kEnd, "Y");
  cell.wait_until(8.0);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].kind, TestKind::kLine);
  ASSERT_EQ(cell.finished[0].readings.size(), 5u);
  EXPECT_DOUBLE_EQ(cell.finished[0].readings[4].position, 0.4);
  EXPECT_DOUBLE_EQ(cell.finished[0].feed, 0.1);
}

TEST(Assembler, StoppingTheServiceClosesWhatIsOpen) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  cell.assembler.close_all(RunEnd::kInterrupted, cell.finished);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].end, RunEnd::kInterrupted);
  EXPECT_EQ(cell.finished[0].bar_time.size(), 50u);
}

TEST(Assembler, AnotherConfigurationLeavesOpenRunsOfRobotsThatStay) {
  Cell cell;
  cell.mark(0.0, Mark::kBegin);
  cell.bar(0.0);
  RobotSpec other = Cell::robot();
  other.name = "r2";
  cell.assembler.configure({Cell::robot(), other}, {}, cell.finished);
  EXPECT_TRUE(cell.finished.empty());
  cell.bar(0.2);
  cell.mark(0.4, Mark::kEnd);
  cell.wait_until(2.0);
  ASSERT_EQ(cell.finished.size(), 1u);
  EXPECT_EQ(cell.finished[0].lost_messages, 0);
  cell.assembler.configure({other}, {}, cell.finished);
  EXPECT_EQ(cell.finished.size(), 1u);
}

}  // namespace
}  // namespace ballbar
