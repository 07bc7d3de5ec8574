// The real service on disks, networks and clocks that fail: what it says, and that no run is lost.

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <set>

#include "store/store.hpp"
#include "support/circle_feed.hpp"
#include "support/live_daemon.hpp"

namespace ballbar {
namespace {

using test::CircleFeed;
using test::LiveDaemon;

/// Runs of the database by begin, with their status.
std::map<std::int64_t, std::string> stored(const std::string& db) {
  Store store = Store::open_read_only(db);
  std::map<std::int64_t, std::string> runs;
  Statement query(store.database(), "SELECT started_us, status FROM run");
  while (query.step()) runs[query.integer(0)] = query.text(1);
  return runs;
}

class Fault : public testing::Test {
 protected:
  void SetUp() override {
    const std::string failure = test::enter_private_network();
    ASSERT_EQ(failure, "") << "these tests need a network namespace (root, or user namespaces allowed)";
    listener = std::make_unique<test::Listener>();
  }
  void send(std::int64_t first, std::int64_t last) {
    for (std::int64_t number = first; number <= last; ++number) feed.send(listener->lcm(), number);
  }
  bool published(std::size_t circles, double seconds = 60) {
    return listener->until([&] { return listener->circles.size() >= circles; }, seconds);
  }
  static bool said(const LiveDaemon& daemon, const std::string& text, double seconds = 60) {
    const auto end = std::chrono::steady_clock::now() + std::chrono::duration<double>(seconds);
    while (daemon.log().find(text) == std::string::npos) {
      if (std::chrono::steady_clock::now() > end) return false;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return true;
  }
  static void expect_all_ok(const std::string& db, std::int64_t first, std::int64_t last) {
    const std::map<std::int64_t, std::string> runs = stored(db);
    EXPECT_EQ(runs.size(), static_cast<std::size_t>(last - first + 1));
    for (std::int64_t number = first; number <= last; ++number) {
      const auto run = runs.find(CircleFeed::started_us(number));
      ASSERT_NE(run, runs.end()) << "circle " << number << " is missing";
      EXPECT_EQ(run->second, "ok") << "circle " << number;
    }
  }
  /// The environment of a ballbard whose disk does what the file fault() says.
  std::vector<std::string> faulty() const {
    const char* asan = std::getenv("ASAN_OPTIONS");
    return {"LD_PRELOAD=" BALLBAR_FAULTY_DISK, "BALLBAR_FAULT=" + fault(),
            "ASAN_OPTIONS=" + std::string(asan ? asan : "") + ":verify_asan_link_order=0"};
  }
  std::string fault() const { return dir.path() + "/fault"; }

  test::TempDir dir;
  std::unique_ptr<test::Listener> listener;
  CircleFeed feed;
};

TEST_F(Fault, OnAFullDiskRunsWaitInMemoryAndAreStoredWhenThereIsRoom) {
  const std::string disk = dir.path() + "/disk";
  std::filesystem::create_directory(disk);
  if (unshare(CLONE_NEWNS) != 0 || mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
      mount("ballbar", disk.c_str(), "tmpfs", 0, "size=2m") != 0)
    GTEST_SKIP() << "this machine allows no mount";
  {
    LiveDaemon daemon(test::planar_robot(dir.path()), {}, disk + "/b.db");
    ASSERT_TRUE(daemon.ready()) << daemon.log();
    send(1, 2);
    ASSERT_TRUE(published(2)) << daemon.log();
    test::write_file(disk + "/filler", std::string(3'000'000, 'x'));
    send(3, 6);
    EXPECT_TRUE(said(daemon, "free disk space, then try again")) << daemon.log();
    EXPECT_TRUE(listener->until([&] { return listener->status && listener->status->runs_waiting == 4; }, 60));
    EXPECT_EQ(listener->circles.size(), 2u) << "nothing is published that is not stored";
    std::filesystem::remove(disk + "/filler");
    EXPECT_TRUE(published(6)) << daemon.log();
    EXPECT_TRUE(said(daemon, "the database can be written again")) << daemon.log();
    EXPECT_EQ(daemon.stop(), 0) << daemon.log();
    expect_all_ok(daemon.db(), 1, 6);
  }
  umount(disk.c_str());
}

TEST_F(Fault, OnADiskThatTurnsReadOnlyRunsWaitLikewise) {
  LiveDaemon daemon(test::planar_robot(dir.path()), faulty());
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  send(1, 1);
  ASSERT_TRUE(published(1)) << daemon.log();
  test::write_file(fault(), "readonly");
  send(2, 3);
  EXPECT_TRUE(listener->until([&] { return listener->status && listener->status->runs_waiting == 2; }, 60));
  EXPECT_NE(daemon.log().find("runs wait in memory and are tried again"), std::string::npos) << daemon.log();
  test::write_file(fault(), "");
  EXPECT_TRUE(published(3)) << daemon.log();
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 1, 3);
}

TEST_F(Fault, ADiskThatNeedsSecondsForEverySyncLosesNothingAndSigtermWaitsForTheCommit) {
  LiveDaemon daemon(test::planar_robot(dir.path()), faulty());
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  test::write_file(fault(), "slow 600");
  send(1, 3);
  ASSERT_TRUE(published(1)) << daemon.log();
  std::this_thread::sleep_for(std::chrono::milliseconds(300));  // in the second commit
  daemon.process().signal(SIGTERM);
  EXPECT_EQ(daemon.process().wait(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 1, 3);
}

TEST_F(Fault, WhileAnotherProgramHoldsTheDatabaseRunsWait) {
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  {
    Database other(daemon.db(), Database::Mode::kReadWrite, 1000);
    const Transaction transaction(other);
    send(1, 1);
    EXPECT_TRUE(said(daemon, "another program holds the database")) << daemon.log();
  }
  EXPECT_TRUE(published(1)) << daemon.log();
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 1, 1);
}

/// Garbage over all pages but the first.
void damage(const std::string& db) {
  std::string bytes = test::read_file(db);
  ASSERT_GT(bytes.size(), 3u * 4096);
  std::fstream file(db, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp(4096);
  file << std::string(bytes.size() - 4096, '\x7f');
}

TEST_F(Fault, ADatabaseThatIsDamagedAtTheStartIsSetAsideAndANewOneBegun) {
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  send(1, 1);
  ASSERT_TRUE(published(1)) << daemon.log();
  ASSERT_EQ(daemon.stop(), 0);
  damage(daemon.db());
  const std::string damaged = test::read_file(daemon.db());
  listener->status.reset();
  daemon.start();
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  const std::string aside = daemon.db() + ".damaged-1";
  EXPECT_NE(daemon.log().find(aside), std::string::npos) << daemon.log();
  EXPECT_EQ(test::read_file(aside), damaged) << "nothing of it is changed";
  EXPECT_TRUE(listener->until([&] { return !listener->alarms.empty(); }, 60)) << daemon.log();
  EXPECT_EQ(listener->alarms.at(0).rule, "database_damaged");
  EXPECT_EQ(listener->alarms.at(0).severity, "critical");
  send(2, 3);
  EXPECT_TRUE(published(3)) << daemon.log();
  ASSERT_TRUE(listener->until([&] { return listener->status.has_value(); }, 60)) << daemon.log();
  EXPECT_NE(listener->status->last_error.find("ballbar db recover"), std::string::npos);
  EXPECT_EQ(listener->status->alarms_firing, 1);
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 2, 3);
}

TEST_F(Fault, ADatabaseThatIsDamagedWhileTheServiceRunsCostsNoRunThatComesLater) {
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  send(1, 1);
  ASSERT_TRUE(published(1)) << daemon.log();
  {  // another writer, so that the service reads its pages again
    Database other(daemon.db(), Database::Mode::kReadWrite, 1000);
    other.integer("PRAGMA wal_checkpoint(TRUNCATE)");
    other.execute("CREATE TABLE other (n)");
    damage(daemon.db());
    other.set_checkpoint_on_close(false);
  }
  send(2, 3);
  EXPECT_TRUE(published(3)) << daemon.log();
  EXPECT_TRUE(std::filesystem::exists(daemon.db() + ".damaged-1")) << daemon.log();
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 2, 3);
}

/// Garbage over the index of runs by time: the service sees it at the start, and no run needs it.
void damage_index(const std::string& db) {
  std::streamoff page = 0;
  {
    Store store(db);
    page = store.database().integer("SELECT rootpage FROM sqlite_schema WHERE name = 'run_time'");
  }
  std::fstream file(db, std::ios::in | std::ios::out | std::ios::binary);
  file.seekp((page - 1) * 4096);
  file << std::string(4096, '\x7f');
}

TEST_F(Fault, WhatIsRecoveredOfADamagedDatabaseIsBackAndTheAlarmEnds) {
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  send(1, 2);
  ASSERT_TRUE(published(2)) << daemon.log();
  ASSERT_EQ(daemon.stop(), 0);
  damage_index(daemon.db());
  daemon.start();
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  send(3, 3);
  ASSERT_TRUE(published(3)) << daemon.log();
  ASSERT_TRUE(listener->until([&] { return !listener->alarms.empty(); }, 60)) << daemon.log();
  listener->alarms.clear();

  const std::string aside = daemon.db() + ".damaged-1";
  const test::Outcome outcome =
      test::run({test::kBallbar, "db", "recover", aside, "--config", daemon.config()});
  EXPECT_EQ(outcome.code, 0) << outcome.err;
  EXPECT_NE(outcome.out.find("2 runs recovered, 2 with their recording; 0 runs"), std::string::npos)
      << outcome.out;
  EXPECT_FALSE(std::filesystem::exists(aside));
  EXPECT_TRUE(std::filesystem::exists(aside + ".recovered-1"));
  EXPECT_TRUE(listener->until(
      [&] { return !listener->alarms.empty() && listener->alarms.back().state == "resolved"; }, 60))
      << daemon.log();
  listener->status.reset();
  ASSERT_TRUE(listener->until([&] { return listener->status.has_value(); }, 60)) << daemon.log();
  EXPECT_EQ(listener->status->alarms_firing, 0);
  EXPECT_EQ(listener->status->last_error, "");
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 1, 3);
}

TEST_F(Fault, ADamagedDatabaseThatHoldsNothingMoreStaysAndTheToolSaysSo) {
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  ASSERT_EQ(daemon.stop(), 0);
  const std::string aside = daemon.db() + ".damaged-1";
  std::filesystem::copy_file(daemon.db(), aside);
  damage(aside);
  const test::Outcome outcome =
      test::run({test::kBallbar, "db", "recover", aside, "--config", daemon.config()});
  EXPECT_EQ(outcome.code, 3) << outcome.out;
  EXPECT_NE(outcome.err.find(aside + ": nothing of it can be read"), std::string::npos) << outcome.err;
  EXPECT_TRUE(std::filesystem::exists(aside));
}

TEST_F(Fault, ClocksOfProducersMayStepByHoursAndProducersMayChange) {
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  constexpr std::int64_t kHour = 120;  // circles
  CircleFeed another;                  // counts its messages from 1 again
  feed.send(listener->lcm(), 10'000);
  feed.send(listener->lcm(), 10'000 + 3 * kHour);
  feed.send(listener->lcm(), 10'000 - 5 * kHour);
  another.send(listener->lcm(), 10'000 - 4 * kHour);
  feed.send(listener->lcm(), 10'001);
  EXPECT_TRUE(published(5)) << daemon.log();
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  const std::map<std::int64_t, std::string> runs = stored(daemon.db());
  EXPECT_EQ(runs.size(), 5u);
  for (const auto& [begin, status] : runs) EXPECT_EQ(status, "ok") << begin;
}

TEST_F(Fault, AnInterfaceThatIsDeletedAndMadeAgainIsHeardAgain) {
  const auto ip = [](const std::string& words) { return test::run({"sh", "-c", "ip " + words}).code == 0; };
  const auto make = [&] {
    return ip("link add cell0 type veth peer name cell1") && ip("addr add 10.99.0.1/24 dev cell0") &&
           ip("link set cell0 up") && ip("link set cell1 up") &&
           ip("route replace 239.255.76.67/32 dev cell0 src 10.99.0.1");
  };
  listener.reset();
  if (!make()) GTEST_SKIP() << "this machine makes no veth interface";
  listener = std::make_unique<test::Listener>();
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  send(1, 1);
  EXPECT_TRUE(published(1)) << daemon.log();
  ASSERT_TRUE(ip("link del cell0"));
  ASSERT_TRUE(make());
  EXPECT_TRUE(said(daemon, "not even the service's own status is heard", 60)) << daemon.log();
  listener = std::make_unique<test::Listener>();
  EXPECT_TRUE(listener->until(
      [&] {
        return listener->status && listener->status->receiver_restarts == 1 &&
               listener->status->state == "listening";
      },
      60))
      << daemon.log();
  send(2, 2);
  EXPECT_TRUE(published(1)) << daemon.log();
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 1, 2);
  listener.reset();
  EXPECT_TRUE(ip("link del cell0"));
  EXPECT_TRUE(ip("route replace 239.255.76.67/32 dev lo src 127.0.0.1"));
}

TEST_F(Fault, WithoutMemoryItEndsIsStartedAgainAndHasLostNothingThatWasStored) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "a sanitizer needs memory of its own";
#endif
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  send(1, 2);
  ASSERT_TRUE(published(2)) << daemon.log();
  std::ifstream statm("/proc/" + std::to_string(daemon.process().pid()) + "/statm");
  rlim_t pages = 0;
  statm >> pages;
  const rlimit none{pages * 4096 + 200'000, pages * 4096 + 200'000};
  ASSERT_EQ(prlimit(daemon.process().pid(), RLIMIT_AS, &none, nullptr), 0);
  CircleFeed large(2000, 1000);  // half a million numbers
  large.send(listener->lcm(), 3, 10);
  large.send(listener->lcm(), 4, 10);
  listener->until([&] { return !daemon.process().alive(); }, 2);
  daemon.kill();
  daemon.start();  // as systemd does
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  listener->circles.clear();
  send(10, 11);
  EXPECT_TRUE(published(2)) << daemon.log();
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  const std::map<std::int64_t, std::string> runs = stored(daemon.db());
  for (const std::int64_t number : {1, 2, 10, 11}) {
    const auto run = runs.find(CircleFeed::started_us(number));
    ASSERT_NE(run, runs.end()) << number;
    EXPECT_EQ(run->second, "ok") << number;
  }
}

}  // namespace
}  // namespace ballbar
