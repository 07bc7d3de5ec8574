// Two processes and real UDP multicast: what is heard live is what a replay of the same log gives, bit for
// bit.

#include <arpa/inet.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <filesystem>
#include <functional>
#include <limits>
#include <memory>
#include <nlohmann/json.hpp>

#include "support/lcm_log.hpp"
#include "support/live_daemon.hpp"
#include "support/messages.hpp"

namespace ballbar {
namespace {

using nlohmann::json;
using test::LiveDaemon;

const std::string kRecordings = BALLBAR_SHARED_DIR "/data/recordings";
const std::string kDemo = BALLBAR_SOURCE_DIR "/scripts/demo.lcm";

/// The LR Mate and its tests A, B and Y, as shipped.
std::string lrmate_robot() {
  std::string text = test::read_file(BALLBAR_SOURCE_DIR "/scripts/robots/lrmate200ic.toml");
  const std::string from = "urdf = \"";
  const std::size_t at = text.find(from) + from.size();
  text.replace(at, text.find('"', at) - at, BALLBAR_SOURCE_DIR "/scripts/robots/lrmate200ic.urdf");
  return text.substr(text.find("\n[[robot]]") + 1);
}

class Live : public testing::Test {
 protected:
  void SetUp() override {
    const std::string failure = test::enter_private_network();
    ASSERT_EQ(failure, "") << "these tests need a network namespace (root, or user namespaces allowed)";
    listener = std::make_unique<test::Listener>();
  }

  /// Plays `logs` one after another at `speed` and compares with their replay.
  void expect_live_equals_replay(const std::vector<std::string>& logs, double speed) {
    LiveDaemon daemon(lrmate_robot());
    ASSERT_TRUE(daemon.ready()) << daemon.log();
    for (const std::string& log : logs) ASSERT_EQ(test::play(log, speed), 0);
    const test::TempDir dir;
    std::vector<std::string> command{test::kBallbar, "replay"};
    command.insert(command.end(), logs.begin(), logs.end());
    for (const std::string& word :
         {std::string("--config"), daemon.config(), std::string("--db"), dir.path() + "/r.db"})
      command.push_back(word);
    const test::Outcome replay = test::run(command);
    ASSERT_EQ(replay.code, 0) << replay.err;
    const std::string expected =
        test::run({test::kBallbar, "export", "--json", "--db", dir.path() + "/r.db"}).out;
    const auto runs = static_cast<std::int64_t>(json::parse(expected)["runs"].size());
    ASSERT_GT(runs, 0);
    EXPECT_TRUE(listener->until([&] { return listener->status && listener->status->runs_stored >= runs; },
                                test::kPatienceS))
        << daemon.log();
    EXPECT_EQ(listener->status->runs_stored, runs);
    EXPECT_EQ(listener->status->runs_ok, runs);
    EXPECT_EQ(listener->status->lost_messages, 0);
    EXPECT_EQ(listener->status->refused, 0);
    EXPECT_EQ(listener->status->kernel_drops, 0);
    EXPECT_EQ(daemon.stop(), 0) << daemon.log();
    EXPECT_TRUE(daemon.exported() == expected) << "live and replay differ";
  }

  std::unique_ptr<test::Listener> listener;
};

TEST_F(Live, TheRecordingsAtFiftyTimesRealSpeedGiveWhatTheirReplayGives) {
  if (!std::filesystem::exists(kRecordings)) GTEST_SKIP() << "no recordings at " << kRecordings;
  expect_live_equals_replay({kRecordings + "/paper-before.lcm", kRecordings + "/paper-after.lcm"}, 50);
}

// Forty minutes and four minutes: scripts/proof live.
TEST_F(Live, DISABLED_TheRecordingsAtRealSpeedGiveWhatTheirReplayGives) {
  expect_live_equals_replay({kRecordings + "/paper-before.lcm", kRecordings + "/paper-after.lcm"}, 1);
}

TEST_F(Live, DISABLED_TheRecordingsAtTenTimesRealSpeedGiveWhatTheirReplayGives) {
  expect_live_equals_replay({kRecordings + "/paper-before.lcm", kRecordings + "/paper-after.lcm"}, 10);
}

TEST_F(Live, TheShippedRecordingAtTenTimesRealSpeedGivesWhatItsReplayGives) {
  expect_live_equals_replay({kDemo}, 10);
}

TEST_F(Live, WithoutMarksItsCirclesAreRecognisedLiveAsInItsReplay) {
  const test::TempDir dir;
  test::copy_log(kDemo, dir.path() + "/unmarked.lcm", [](test_mark_t&) { return false; });
  expect_live_equals_replay({dir.path() + "/unmarked.lcm"}, 50);
}

TEST_F(Live, ResultsAppearOnTheBusAfterTheyAreStored) {
  LiveDaemon daemon(lrmate_robot());
  std::filesystem::copy(BALLBAR_SOURCE_DIR "/scripts/rules", daemon.rules(),
                        std::filesystem::copy_options::recursive);
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  daemon.process().signal(SIGHUP);
  ASSERT_TRUE(daemon.notify().until("READY=1", test::kPatienceS));
  ASSERT_EQ(test::play(kDemo, 50), 0);
  EXPECT_TRUE(listener->until(  // a status comes behind the results that it counts
      [&] { return listener->status && listener->status->runs_stored == 16; }, test::kPatienceS))
      << daemon.log();
  EXPECT_FALSE(listener->lines.empty());
  EXPECT_FALSE(listener->circles.empty());
  EXPECT_EQ(daemon.stop(), 0);
  const json runs = json::parse(daemon.exported())["runs"];
  std::size_t circles = 0;
  for (const json& run : runs) {
    if (run["kind"] != "circle") continue;
    const circle_result_t& sent = listener->circles.at(circles++);
    EXPECT_EQ(sent.started_us, run["started_us"]);
    EXPECT_EQ(sent.ovality_um, run["ovality_um"].get<double>());
    EXPECT_EQ(sent.orders, 30);
    EXPECT_EQ(sent.seq, static_cast<std::int64_t>(circles));
  }
  EXPECT_EQ(circles, listener->circles.size());
  const bool fired = std::any_of(listener->alarms.begin(), listener->alarms.end(), [](const alarm_t& a) {
    return a.rule == "ovality_drift" && a.state == "firing";
  });
  EXPECT_TRUE(fired) << "the shipped recording drifts at its end\n" << daemon.log();
}

/// The first runs of the shipped recording.
void cut_demo(const std::string& path, int runs) {
  lcm::LogFile in(kDemo, "r");
  lcm::LogFile out(path, "w");
  int begins = 0;
  while (const lcm::LogEvent* event = in.readNextEvent()) {
    if (event->channel == "TEST_MARK") {
      test_mark_t mark;
      mark.decode(event->data, 0, event->datalen);
      if (mark.mark == 1 && ++begins > runs) return;
    }
    lcm::LogEvent copy = *event;
    out.writeEvent(&copy);
  }
}

/// Sends bytes that are no LCM message to the port that every receiver is bound to.
void send_datagram(const std::string& bytes) {
  const int fd = socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0);
  sockaddr_in to{};
  to.sin_family = AF_INET;
  to.sin_port = htons(7667);
  to.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  ASSERT_EQ(sendto(fd, bytes.data(), bytes.size(), 0, reinterpret_cast<sockaddr*>(&to), sizeof to),
            static_cast<ssize_t>(bytes.size()));
  close(fd);
}

/// A first fragment that ends inside its channel's name: liblcm's arithmetic on its size wraps, and it copies
/// 4 GB.
void send_deadly_datagram() {
  send_datagram(std::string(200, '\0'));  // is refused, and leaves zeros in liblcm's buffer
  send_datagram(std::string("LC03") + std::string("\0\0\0\7\0\0\3\350\0\0\0\1\0\0\0\2", 16) + "BALLBAR");
}

TEST_F(Live, ADatagramThatKillsLiblcmCostsAHoleInTheRunInProgressAndNothingElse) {
  listener.reset();  // it would die as well
  LiveDaemon daemon(lrmate_robot());
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  const auto status_says = [](const std::function<bool(const daemon_status_t&)>& what) {
    test::Listener now;
    return now.until([&] { return now.status && what(*now.status); }, test::kPatienceS);
  };
  const test::TempDir dir;
  cut_demo(dir.path() + "/six.lcm", 6);
  lcm::LogFile log(dir.path() + "/six.lcm", "r");
  lcm::LCM sender(test::kLiveUrl);
  int sent = 0;
  const auto send = [&](int most) {
    const lcm::LogEvent* event = nullptr;
    for (; sent < most && (event = log.readNextEvent()) != nullptr; ++sent) {
      sender.publish(event->channel, event->data, static_cast<unsigned>(event->datalen));
      if (sent % 16 == 0) test::wait_for_readers(100'000);
    }
  };
  send(250);  // to the middle of the first circle
  ASSERT_TRUE(status_says([](const daemon_status_t& s) { return s.messages == 250 && s.runs_open == 1; }))
      << daemon.log();
  send_deadly_datagram();
  ASSERT_TRUE(status_says([](const daemon_status_t& s) {
    return s.receiver_restarts == 1 && s.state == "listening";
  })) << daemon.log();
  send(std::numeric_limits<int>::max());
  EXPECT_TRUE(status_says([](const daemon_status_t& s) { return s.runs_stored == 6; })) << daemon.log();
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  const json runs = json::parse(daemon.exported())["runs"];
  ASSERT_EQ(runs.size(), 6u) << daemon.log();
  EXPECT_EQ(runs[0]["run"], "A+1#1");
  EXPECT_EQ(runs[0]["receiver_restarts"], 1) << daemon.log();
  for (std::size_t i = 1; i < 6; ++i) {
    EXPECT_EQ(runs[i]["status"], "ok") << i;
    EXPECT_EQ(runs[i]["receiver_restarts"], 0) << i;
    EXPECT_EQ(runs[i]["lost_messages"], 0) << i;
  }
}

TEST_F(Live, StrangersAreCountedAndNotBelieved) {
  LiveDaemon daemon(lrmate_robot());
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  const joint_samples_t stranger = test::joint_message(test::kEpochUs, 1, {0, 0, 0, 0, 0, 0}, "somebody");
  listener->lcm().publish("JOINTS", &stranger);
  const test_mark_t unknown = test::mark_message(test::kEpochUs, 1, 1, "Q", 1, 1, "lrmate-1");
  listener->lcm().publish("TEST_MARK", &unknown);
  ballbar_samples_t nan =
      test::bar_message(test::kEpochUs, 1, {1.0, std::numeric_limits<double>::quiet_NaN()}, 4000, "lrmate-1");
  listener->lcm().publish("BALLBAR", &nan);
  listener->lcm().publish("BALLBAR", "garbage", 7);
  EXPECT_TRUE(
      listener->until([&] { return listener->status && listener->status->refused == 4; }, test::kPatienceS))
      << (listener->status ? listener->status->refused : -1);
  EXPECT_EQ(listener->status->messages, 0);
  EXPECT_EQ(daemon.stop(), 0);
}

TEST_F(Live, AMarkOfACalibrationBeginsANewBaseline) {
  LiveDaemon daemon(lrmate_robot());
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  const auto send = [&](std::int64_t seconds, std::int64_t seq, const std::string& test,
                        const std::string& why) {
    test_mark_t mark =
        test::mark_message(test::kEpochUs + seconds * 1'000'000, seq, 4, test, 0, 0, "lrmate-1");
    mark.series = why;
    listener->lcm().publish("TEST_MARK", &mark);
  };
  send(0, 1, "", "mastered");
  send(0, 2, "", "mastered");  // some bridges send marks twice
  send(60, 3, "A", "new ball");
  send(70, 4, "Q", "no such test");
  EXPECT_TRUE(listener->until([&] { return listener->status && listener->status->refused == 1; }, 5));
  EXPECT_EQ(listener->status->messages, 3);
  const std::string list = test::run({test::kBallbar, "baseline", "list", "--db", daemon.db()}).out;
  EXPECT_EQ(list,
            "2023-11-14 22:13:20  lrmate-1  all tests  mastered\n"
            "2023-11-14 22:14:20  lrmate-1  A  new ball\n");
  EXPECT_NE(
      daemon.log().find("lrmate-1, test A: calibrated at 2023-11-14 22:14:20 UTC, a new baseline begins: "
                        "new ball"),
      std::string::npos)
      << daemon.log();
  EXPECT_EQ(daemon.stop(), 0);
}

TEST_F(Live, ARunInProgressLeavesARowWhenTheServiceStops) {
  LiveDaemon daemon(lrmate_robot());
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  const test_mark_t begin = test::mark_message(test::kEpochUs, 1, 1, "A", 1, 1, "lrmate-1");
  listener->lcm().publish("TEST_MARK", &begin);
  const ballbar_samples_t bar =
      test::bar_message(test::kEpochUs + 1000, 1, std::vector<double>(50, 1.0), 4000, "lrmate-1");
  listener->lcm().publish("BALLBAR", &bar);
  EXPECT_TRUE(listener->until([&] { return listener->status && listener->status->runs_open == 1; },
                              test::kPatienceS));
  EXPECT_EQ(daemon.stop(), 0);
  EXPECT_TRUE(daemon.notify().until("STOPPING=1", test::kPatienceS));
  const json runs = json::parse(daemon.exported())["runs"];
  ASSERT_EQ(runs.size(), 1u);
  EXPECT_EQ(runs[0]["status"], "interrupted");
}

TEST_F(Live, WhatHasArrivedBeforeTheStopIsStored) {
  LiveDaemon daemon(lrmate_robot());
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  const test::TempDir dir;
  const std::string two = dir.path() + "/two.lcm";
  cut_demo(two, 2);
  daemon.process().signal(SIGSTOP);  // busy, e.g. with a slow disk, while two circles arrive
  ASSERT_EQ(test::play(two, 50), 0);
  daemon.process().signal(SIGTERM);
  daemon.process().signal(SIGCONT);
  EXPECT_EQ(daemon.process().wait(), 0) << daemon.log();
  const json runs = json::parse(daemon.exported())["runs"];
  ASSERT_EQ(runs.size(), 2u) << daemon.log();
  for (const json& run : runs) {
    EXPECT_EQ(run["status"], "ok") << run["run"];
    EXPECT_EQ(run["lost_messages"], 0);
  }
}

TEST_F(Live, ReloadTakesGoodChangesAndKeepsTheLastGoodOfBadOnes) {
  LiveDaemon daemon(lrmate_robot());
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  const auto reload = [&] {
    daemon.process().signal(SIGHUP);
    EXPECT_TRUE(daemon.notify().until("RELOADING=1", test::kPatienceS));
    EXPECT_TRUE(daemon.notify().until("READY=1", test::kPatienceS));
  };
  const auto rules_are = [&](int rules) {
    listener->status.reset();
    return listener->until([&] { return listener->status && listener->status->rules == rules; },
                           test::kPatienceS);
  };
  const std::string rule =
      "return { name = 'r', on = 'circle', when = function(result) return false end, text = 't' }\n";
  test::write_file(daemon.rules() + "/r.lua", rule);
  reload();
  EXPECT_TRUE(rules_are(1)) << daemon.log();
  test::write_file(daemon.rules() + "/r.lua", rule + "this is no Lua\n");
  test::write_file(
      daemon.rules() + "/second.lua",
      "return { name = 's', on = 'circle', when = function(result) return false end, text = 't' }\n");
  reload();
  EXPECT_TRUE(rules_are(1)) << "a set that does not pass is not taken, not in part either\n" << daemon.log();
  EXPECT_NE(daemon.log().find("r.lua:2:"), std::string::npos) << "file and line\n" << daemon.log();
  test::write_file(daemon.rules() + "/r.lua", rule);
  reload();
  EXPECT_TRUE(rules_are(2)) << daemon.log();
  test::write_file(daemon.config(), "[store]\npfad = \"x\"\n");
  reload();
  EXPECT_NE(daemon.log().find("ballbard.toml:2:1: unknown key 'pfad'"), std::string::npos) << daemon.log();
  EXPECT_TRUE(rules_are(2)) << "the running configuration stays\n" << daemon.log();
  EXPECT_EQ(daemon.stop(), 0);
}

TEST_F(Live, AnAlarmSurvivesARestartOfTheService) {
  const std::string rule =
      "return { name = 'always', on = 'circle', hold_runs = 3, when = function(result) return true end, text "
      "= 'bad' }\n";
  const test::TempDir dir;
  std::filesystem::create_directory(dir.path() + "/rules.d");
  test::write_file(dir.path() + "/rules.d/always.lua", rule);
  test::write_file(dir.path() + "/ballbard.toml", "[rules]\ndirectory = \"rules.d\"\n" + lrmate_robot());
  const auto alarms = [&] { return test::run({test::kBallbar, "alarms", "--db", dir.path() + "/a.db"}).out; };
  // Two processes after one another on one database: the second goes on counting where the first one stopped.
  const std::string cut = dir.path() + "/first.lcm";
  cut_demo(cut, 8);  // all before "production": circle A forward came twice
  const auto replay = [&](const std::string& log) {
    return test::run({test::kBallbar, "replay", log, "--config", dir.path() + "/ballbard.toml", "--db",
                      dir.path() + "/a.db"});
  };
  ASSERT_EQ(replay(cut).code, 0);
  EXPECT_NE(alarms().find("pending"), std::string::npos) << alarms();
  const test::Outcome second = replay(kDemo);  // the first runs are known already
  EXPECT_NE(second.out.find("alarm firing (warning) always lrmate-1 A"), std::string::npos) << second.out;
  EXPECT_EQ(second.out.find("A+1#1 (production): ok, "), second.out.find("A+1#1 (production)")) << second.out;
  const std::size_t fired = second.out.find("alarm firing");
  EXPECT_LT(second.out.find("(production)"), fired) << second.out;
  EXPECT_GT(second.out.find("A+1#2 (production)"), fired)
      << "two runs counted before the restart, one after it";
}

TEST_F(Live, WaitsForTheNetworkAndSaysSo) {
  ASSERT_EQ(test::run({"ip", "route", "del", "239.255.76.67/32", "dev", "lo"}).code, 0);
  LiveDaemon daemon(lrmate_robot());
  EXPECT_TRUE(daemon.says("waiting for the network")) << daemon.log();
  EXPECT_TRUE(daemon.says("ip route add 239.255.76.67/32 dev lo src 127.0.0.1")) << "what to do\n"
                                                                                 << daemon.log();
  ASSERT_EQ(test::run({"ip", "route", "add", "239.255.76.67/32", "dev", "lo", "src", "127.0.0.1"}).code, 0);
  EXPECT_TRUE(daemon.ready()) << daemon.log();
  EXPECT_TRUE(listener->until([&] { return listener->status && listener->status->state == "listening"; },
                              test::kPatienceS));
  EXPECT_EQ(daemon.stop(), 0);
}

TEST_F(Live, TheWatchdogIsFed) {
  LiveDaemon daemon(lrmate_robot(), {"WATCHDOG_USEC=1000000"});
  ASSERT_TRUE(daemon.ready());
  EXPECT_TRUE(daemon.notify().until("WATCHDOG=1", test::kPatienceS));
  EXPECT_EQ(daemon.stop(), 0);
}

}  // namespace
}  // namespace ballbar
