#include "rules/alarm_machine.hpp"

#include <gtest/gtest.h>

#include <random>
#include <string>

namespace ballbar {
namespace {

// Feeds runs ('x' bad, '.' clean) and writes down the state after each by its first letter.
std::string states(const std::string& runs, int hold_runs, int keep_runs) {
  AlarmStatus status;
  std::string letters;
  std::int64_t at_us = 0;
  for (const char run : runs) {
    status = advance(status, run == 'x', hold_runs, keep_runs, ++at_us);
    letters += to_string(status.state)[0];
  }
  return letters;
}

TEST(AlarmMachine, FollowsTheTable) {
  EXPECT_EQ(states("x.xx..", 2, 1), "pipffr");  // one bad run is no alarm, one clean run no cure
  EXPECT_EQ(states("xxx...", 1, 0), "fffrii");  // hold 1 fires at once, keep 0 resolves at once
  EXPECT_EQ(states("xxx...", 3, 1), "ppffri");
  EXPECT_EQ(states("xx.x..", 2, 1), "pffffr");  // a bad run in between begins the count of clean ones anew
  EXPECT_EQ(states("xx...xx", 2, 1), "pffripf");
  EXPECT_EQ(states("xx..xx", 2, 1), "pffrpf");  // from resolved as from inactive
  EXPECT_EQ(states("x..x", 1, 1), "ffrf");
  EXPECT_EQ(states("x.x.x.", 2, 1), "pipipi");
  EXPECT_EQ(states("x....", 1, 3), "ffffr");
  EXPECT_EQ(states("...", 1, 1), "iii");
}

TEST(AlarmMachine, SinceIsTheRunThatChangedTheStateAndJudgedTheLastOne) {
  AlarmStatus status;
  status = advance(status, true, 2, 1, 10);
  EXPECT_EQ(status.since_us, 10);
  status = advance(status, true, 2, 1, 20);
  status = advance(status, true, 2, 1, 30);
  EXPECT_EQ(status.state, AlarmState::kFiring);
  EXPECT_EQ(status.since_us, 20);
  EXPECT_EQ(status.judged_us, 30);
  EXPECT_EQ(status.bad_runs, 3);
  EXPECT_EQ(status.clean_runs, 0);
}

TEST(AlarmMachine, LeavesKeySeverityAndTextAlone) {
  AlarmStatus before;
  before.key = {"x", "r1", "A", -1, ""};
  before.severity = "critical";
  before.text = "why";
  const AlarmStatus after = advance(before, true, 1, 1, 5);
  EXPECT_EQ(after.key, before.key);
  EXPECT_EQ(after.severity, "critical");
  EXPECT_EQ(after.text, "why");
}

// What a database keeps of a status: each field by itself, states and severities as words.
AlarmStatus stored_and_read(const AlarmStatus& status) {
  AlarmStatus read;
  read.key = status.key;
  read.state = alarm_state_from(to_string(status.state));
  read.severity = status.severity;
  read.since_us = status.since_us;
  read.judged_us = status.judged_us;
  read.bad_runs = status.bad_runs;
  read.clean_runs = status.clean_runs;
  read.text = status.text;
  return read;
}

TEST(AlarmMachine, ARestartAfterAnyRunChangesNothing) {
  constexpr int kSeed = 42;
  std::mt19937 random(kSeed);
  for (int trial = 0; trial < 50; ++trial) {
    const int hold_runs = 1 + static_cast<int>(random() % 3);
    const int keep_runs = static_cast<int>(random() % 3);
    AlarmStatus through;
    AlarmStatus restarted;
    for (int run = 1; run <= 30; ++run) {
      const bool bad = random() % 2 == 0;
      through = advance(through, bad, hold_runs, keep_runs, run);
      restarted = advance(stored_and_read(restarted), bad, hold_runs, keep_runs, run);
      ASSERT_EQ(through, restarted) << "seed " << kSeed << ", trial " << trial << ", run " << run;
    }
  }
}

}  // namespace
}  // namespace ballbar
