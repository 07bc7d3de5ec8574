// A run into messages, and through the real decoder and assembler back into a run.

#include "bus/run_messages.hpp"

#include <gtest/gtest.h>

#include <random>

#include "bus/assembler.hpp"
#include "bus/decode.hpp"
#include "bus/encode.hpp"

namespace ballbar {
namespace {

constexpr std::int64_t kBegin = 1'773'219'600'000'000;

RobotSpec robot() {
  RobotSpec spec;
  spec.name = "r1";
  spec.tests.resize(2);
  spec.tests[0].name = "A";
  spec.tests[1].name = "Y";
  spec.tests[1].kind = TestKind::kLine;
  return spec;
}

/// Uneven times to the microsecond, joints with torques where wanted.
ballbar::Run circle(std::int64_t started_us, bool torque) {
  std::mt19937 random(5);
  std::uniform_int_distribution<int> step_us(900, 5000);
  ballbar::Run run;
  run.robot = "r1";
  run.test = "A";
  run.direction = -1;
  run.repetition = 3;
  run.series = "before";
  run.started_us = started_us;
  run.feed = 0.05;
  run.payload = 0.4;
  run.temperature = 21.5;
  run.joints = 2;
  std::int64_t bar = 20, joint = 0;
  for (int i = 0; i < 300; ++i) {
    run.bar_time.push_back(static_cast<double>(bar += step_us(random)) * 1e-6);
    run.bar_deviation.push_back(1e-9 * (i % 97));
    run.joint_time.push_back(static_cast<double>(joint += step_us(random)) * 1e-6);
    for (const double q : {0.1 + 1e-3 * i, 0.2 - 1e-3 * i}) run.joint_position.push_back(q);
    if (torque)
      for (const double t : {1.0, 2.0}) run.joint_torque.push_back(t + i);
  }
  run.ended_us = started_us + std::max(bar, joint) + 1000;
  return run;
}

struct Assembled {
  std::vector<ballbar::Run> runs;
  AssemblerCounters counters;
};

Assembled assembled(const std::vector<ballbar::Run>& runs) {
  Assembler assembler({robot()});
  RunMessages messages;
  Assembled found;
  for (const ballbar::Run& run : runs)
    for (const Sample& sample : messages.of(run)) {
      const Encoded encoded = encode(sample);
      const Decoded decoded = decode(encoded.channel, encoded.bytes);
      const std::int64_t time_us = std::visit([](const auto& s) { return s.header.time_us; }, sample);
      assembler.take(std::get<Sample>(decoded), time_us, found.runs);
      assembler.tick(time_us, found.runs);
    }
  assembler.close_all(RunEnd::kSilence, found.runs);
  found.counters = assembler.counters();
  return found;
}

void expect_near(const std::vector<double>& found, const std::vector<double>& wanted, double tolerance) {
  ASSERT_EQ(found.size(), wanted.size());
  for (std::size_t i = 0; i < wanted.size(); ++i) ASSERT_NEAR(found[i], wanted[i], tolerance) << i;
}

TEST(RunMessages, AreAssembledIntoTheSameRun) {
  for (const bool torque : {false, true}) {
    const std::vector<ballbar::Run> sent{circle(kBegin, torque), circle(kBegin + 20'000'000, torque)};
    const Assembled found = assembled(sent);
    EXPECT_EQ(found.counters.lost_messages, 0);
    EXPECT_EQ(found.counters.refused_total(), 0);
    EXPECT_EQ(found.counters.producer_restarts, 0);
    ASSERT_EQ(found.runs.size(), 2U);
    for (std::size_t i = 0; i < 2; ++i) {
      const ballbar::Run &back = found.runs[i], &run = sent[i];
      EXPECT_EQ(back.robot, run.robot);
      EXPECT_EQ(back.test, run.test);
      EXPECT_EQ(back.direction, run.direction);
      EXPECT_EQ(back.repetition, run.repetition);
      EXPECT_EQ(back.series, run.series);
      EXPECT_EQ(back.started_us, run.started_us);
      EXPECT_EQ(back.ended_us, run.ended_us);
      EXPECT_EQ(back.end, RunEnd::kMark);
      EXPECT_DOUBLE_EQ(back.feed, run.feed);
      EXPECT_EQ(back.payload, run.payload);
      EXPECT_EQ(back.temperature, run.temperature);
      expect_near(back.bar_time, run.bar_time, 1e-9);
      expect_near(back.bar_deviation, run.bar_deviation, 1e-18);
      expect_near(back.joint_time, run.joint_time, 1e-9);
      EXPECT_EQ(back.joint_position, run.joint_position);
      EXPECT_EQ(back.joint_torque, run.joint_torque);
    }
  }
}

TEST(RunMessages, OfALineAreItsReadings) {
  ballbar::Run run;
  run.robot = "r1";
  run.test = "Y";
  run.kind = TestKind::kLine;
  run.direction = 1;
  run.started_us = kBegin;
  for (int i = 0; i < 10; ++i)
    run.readings.push_back({i % 2 ? 'X' : 'Z', 0.5 * (i / 2), 0.1 * i, 1e-6 * i});  // two at a time
  run.ended_us = kBegin + 5'000'000;
  const Assembled found = assembled({run});
  ASSERT_EQ(found.runs.size(), 1U);
  ASSERT_EQ(found.runs[0].readings.size(), 10U);
  for (std::size_t i = 0; i < 10; ++i) {
    EXPECT_EQ(found.runs[0].readings[i].axis, run.readings[i].axis);
    EXPECT_NEAR(found.runs[0].readings[i].time, run.readings[i].time, 1e-9);
    EXPECT_NEAR(found.runs[0].readings[i].position, run.readings[i].position, 1e-15);
    EXPECT_NEAR(found.runs[0].readings[i].deviation, run.readings[i].deviation, 1e-18);
  }
}

TEST(RunMessages, OfAnAbortedRunEndWithAnAbort) {
  ballbar::Run run = circle(kBegin, false);
  run.end = RunEnd::kAborted;
  const Assembled found = assembled({run});
  ASSERT_EQ(found.runs.size(), 1U);
  EXPECT_EQ(found.runs[0].end, RunEnd::kAborted);
  run.end = RunEnd::kSilence;
  RunMessages messages;
  EXPECT_THROW(messages.of(run), std::invalid_argument);
}

}  // namespace
}  // namespace ballbar
