#include "rules/alarm_machine.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <random>
#include <string>
#include <vector>

namespace ballbar {
namespace {

// Feeds runs ('x' bad, '.' clean) and writes down the state after each by its first letter.
// @param every_s  seconds between the ends of two runs
std::string states(const std::string& runs, const AlarmDelays& delays, double every_s = 1.0) {
  AlarmStatus status;
  std::string letters;
  std::int64_t at_us = 0;
  for (const char run : runs) {
    at_us += static_cast<std::int64_t>(every_s * 1e6);
    status = advance(status, run == 'x', delays, at_us);
    letters += to_string(status.state)[0];
  }
  return letters;
}

std::string states(const std::string& runs, int hold_runs, int keep_runs) {
  return states(runs, AlarmDelays{hold_runs, keep_runs});
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

TEST(AlarmMachine, TimesCountFromTheFirstRunInARow) {
  AlarmDelays delays;
  delays.hold_s = 3.0;
  EXPECT_EQ(states("xxxxx", delays), "pppff");        // 3 s after the first bad run, that is, at the fourth
  EXPECT_EQ(states("xxx.xxxx", delays), "pppipppf");  // a clean run begins the time anew
  EXPECT_EQ(states("xx", delays, 3.0), "pf");
  EXPECT_EQ(states("xx", delays, 2.9), "pp");
  delays.hold_runs = 3;
  EXPECT_EQ(states("xxx", delays, 1000.0), "ppf");  // both the count and the time
  AlarmDelays keep;
  keep.keep_s = 3.0;
  EXPECT_EQ(states("x......", keep), "ffffrii");
  EXPECT_EQ(states("x..x....", keep), "fffffffr");
  EXPECT_EQ(states("x..", keep, 3600.0), "ffr");
}

TEST(AlarmMachine, AClockThatStepsBackNeitherFiresNorResolves) {
  AlarmDelays delays;
  delays.hold_s = 60.0;
  AlarmStatus status = advance({}, true, delays, 1'000'000'000);
  status = advance(status, true, delays, 1);
  EXPECT_EQ(status.state, AlarmState::kPending);
}

TEST(AlarmMachine, OneThatFlapsIsSaidOnceUntilItHasBeenQuiet) {
  AlarmDelays delays{1, 0};
  delays.flap_fires = 3;
  delays.flap_runs = 8;
  //                          fires at 1, 3 and 5; the first of them is 8 runs old at run 9
  EXPECT_EQ(states("x.x.x......", delays), "frfrffffrii");
  EXPECT_EQ(states("x.x.x.x.x.x.x", delays), "frfrfffffrfrf");
  delays.flap_fires = 0;
  EXPECT_EQ(states("x.x.x.x.x.x.x", delays), "frfrfrfrfrfrf");  // never damped
}

TEST(AlarmMachine, DampingSaysAtMostFlapFiresOfAnyFlapRuns) {
  constexpr int kSeed = 7;
  std::mt19937 random(kSeed);
  for (int trial = 0; trial < 200; ++trial) {
    AlarmDelays delays{1, 0};
    delays.flap_fires = 2 + static_cast<int>(random() % 3);
    delays.flap_runs = 5 + static_cast<int>(random() % 50);
    AlarmStatus status;
    std::vector<int> fired;
    for (int run = 1; run <= 300; ++run) {
      const AlarmState before = status.state;
      status = advance(status, random() % 2 == 0, delays, run);
      if (status.state == AlarmState::kFiring && before != AlarmState::kFiring) fired.push_back(run);
      const auto recent =
          std::count_if(fired.begin(), fired.end(), [&](int f) { return f > run - delays.flap_runs; });
      ASSERT_LE(recent, delays.flap_fires) << "seed " << kSeed << ", trial " << trial << ", run " << run;
    }
    ASSERT_GT(fired.size(), 3u);
  }
}

TEST(AlarmMachine, AnAcknowledgementEndsWithItsAlarm) {
  AlarmStatus status = advance({}, true, AlarmDelays{1, 0}, 1);
  status.acknowledged = {"anna", "seen", 2};
  status.shelved = {"bo", "repair", 1000};
  status = advance(status, true, AlarmDelays{1, 0}, 3);
  EXPECT_EQ(status.acknowledged.by, "anna") << "one more bad run is the same alarm";
  status = advance(status, false, AlarmDelays{1, 0}, 4);
  EXPECT_EQ(status.state, AlarmState::kResolved);
  EXPECT_EQ(status.acknowledged.by, "anna") << "on record while it is shown as resolved";
  status = advance(status, true, AlarmDelays{1, 0}, 5);
  EXPECT_EQ(status.acknowledged.by, "") << "fires anew: nobody has seen that";
  EXPECT_EQ(status.shelved.by, "bo") << "shelving ends by time alone";
}

TEST(AlarmMachine, SinceIsTheRunThatChangedTheStateAndJudgedTheLastOne) {
  AlarmStatus status;
  status = advance(status, true, AlarmDelays{2, 1}, 10);
  EXPECT_EQ(status.since_us, 10);
  status = advance(status, true, AlarmDelays{2, 1}, 20);
  status = advance(status, true, AlarmDelays{2, 1}, 30);
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
  const AlarmStatus after = advance(before, true, AlarmDelays{}, 5);
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
  read.streak_us = status.streak_us;
  read.fires = status.fires;
  read.flapping = status.flapping;
  return read;
}

TEST(AlarmMachine, ARestartAfterAnyRunChangesNothing) {
  constexpr int kSeed = 42;
  std::mt19937 random(kSeed);
  for (int trial = 0; trial < 50; ++trial) {
    AlarmDelays delays{1 + static_cast<int>(random() % 3), static_cast<int>(random() % 3)};
    delays.hold_s = static_cast<double>(random() % 3) * 1e-6;
    delays.keep_s = static_cast<double>(random() % 3) * 1e-6;
    delays.flap_fires = static_cast<int>(random() % 4);
    AlarmStatus through;
    AlarmStatus restarted;
    for (int run = 1; run <= 30; ++run) {
      const bool bad = random() % 2 == 0;
      through = advance(through, bad, delays, run);
      restarted = advance(stored_and_read(restarted), bad, delays, run);
      ASSERT_EQ(through, restarted) << "seed " << kSeed << ", trial " << trial << ", run " << run;
    }
  }
}

}  // namespace
}  // namespace ballbar
