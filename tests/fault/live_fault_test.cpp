// The real service on disks, networks and clocks that fail: what it says, and that no run is lost.

#include <gtest/gtest.h>
#include <sys/mount.h>
#include <sys/resource.h>

#include <chrono>
#include <cmath>
#include <filesystem>

#include "fault/fault_fixture.hpp"

namespace ballbar {
namespace {

TEST_F(Fault, OnAFullDiskRunsWaitInMemoryAndAreStoredWhenThereIsRoom) {
  const std::string disk = small_disk();
  if (disk.empty()) GTEST_SKIP() << "this machine allows no mount";
  {
    LiveDaemon daemon(test::planar_robot(dir.path()), {}, disk + "/b.db");
    ASSERT_TRUE(daemon.ready()) << daemon.log();
    send(1, 2);
    ASSERT_TRUE(published(2)) << daemon.log();
    test::write_file(disk + "/filler", std::string(3'000'000, 'x'));
    send(3, 6);
    EXPECT_TRUE(daemon.says("free disk space, then try again")) << daemon.log();
    EXPECT_TRUE(listener->until([&] { return listener->status && listener->status->runs_waiting == 4; },
                                test::kPatienceS));
    EXPECT_EQ(listener->circles.size(), 2u) << "nothing is published that is not stored";
    std::filesystem::remove(disk + "/filler");
    EXPECT_TRUE(published(6)) << daemon.log();
    EXPECT_TRUE(daemon.says("the database can be written again")) << daemon.log();
    EXPECT_EQ(daemon.stop(), 0) << daemon.log();
    expect_all_ok(daemon.db(), 1, 6);
  }
  umount(disk.c_str());
}

TEST_F(Fault, OnADiskThatIsFullAtTheStartRunsWaitLikewise) {
  const std::string disk = small_disk();
  if (disk.empty()) GTEST_SKIP() << "this machine allows no mount";
  {
    LiveDaemon daemon(test::planar_robot(dir.path()), {}, disk + "/b.db");
    ASSERT_TRUE(daemon.ready()) << daemon.log();
    send(1, 2);
    ASSERT_TRUE(published(2)) << daemon.log();
    ASSERT_EQ(daemon.stop(), 0) << daemon.log();
    test::write_file(disk + "/filler", std::string(3'000'000, 'x'));
    listener->status.reset();
    daemon.start();
    ASSERT_TRUE(daemon.ready()) << daemon.log();
    send(3, 4);
    EXPECT_TRUE(listener->until([&] { return listener->status && listener->status->runs_waiting == 2; },
                                test::kPatienceS))
        << daemon.log();
    EXPECT_TRUE(daemon.says("free disk space, then try again")) << daemon.log();
    std::filesystem::remove(disk + "/filler");
    EXPECT_TRUE(published(4)) << daemon.log();
    EXPECT_EQ(daemon.stop(), 0) << daemon.log();
    expect_all_ok(daemon.db(), 1, 4);
  }
  umount(disk.c_str());
}

TEST_F(Fault, WithoutRoomForANewDatabaseItEndsAndSaysWhatToDo) {
  const std::string disk = small_disk();
  if (disk.empty()) GTEST_SKIP() << "this machine allows no mount";
  test::write_file(disk + "/filler", std::string(3'000'000, 'x'));
  {
    LiveDaemon daemon(test::planar_robot(dir.path()), {}, disk + "/b.db");
    EXPECT_EQ(daemon.process().wait(), 3) << daemon.log();
    EXPECT_NE(daemon.log().find("free disk space, then try again"), std::string::npos) << daemon.log();
    std::filesystem::remove(disk + "/filler");
    daemon.start();  // as systemd does every half second
    ASSERT_TRUE(daemon.ready()) << daemon.log();
    send(1, 1);
    EXPECT_TRUE(published(1)) << daemon.log();
    EXPECT_EQ(daemon.stop(), 0) << daemon.log();
    expect_all_ok(daemon.db(), 1, 1);
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
  EXPECT_TRUE(listener->until([&] { return listener->status && listener->status->runs_waiting == 2; },
                              test::kPatienceS));
  EXPECT_NE(daemon.log().find("runs wait in memory and are tried again"), std::string::npos) << daemon.log();
  test::write_file(fault(), "");
  EXPECT_TRUE(published(3)) << daemon.log();
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 1, 3);
}

TEST_F(Fault, ADiskThatNeedsSecondsForEverySyncLosesNothingAndSigtermWaitsForTheCommit) {
  LiveDaemon daemon(test::planar_robot(dir.path()), faulty());
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  test::write_file(fault(), "slow 2500");
  send(1, 3);
  ASSERT_TRUE(published(1)) << daemon.log();
  std::this_thread::sleep_for(std::chrono::milliseconds(1000));  // in the second commit
  daemon.process().signal(SIGTERM);
  EXPECT_EQ(daemon.process().wait(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 1, 3);
}

/// A turn of the loop that lasts longer than the watchdog's time would end in SIGABRT, and what waits in
/// memory would be lost.
TEST_F(Fault, TheWatchdogIsFedWhileRunsWaitForALockedDatabaseAndForASlowDisk) {
  std::vector<std::string> environment = faulty();
  environment.emplace_back("WATCHDOG_USEC=5000000");  // of the unit: 30 s
  LiveDaemon daemon(test::planar_robot(dir.path()), environment);
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  const auto is_fed = [&](double seconds) {
    using Clock = std::chrono::steady_clock;
    for (const auto end = Clock::now() + std::chrono::duration<double>(seconds); Clock::now() < end;)
      if (!daemon.notify().until("WATCHDOG=1", 5.0)) return false;
    return true;
  };
  {
    Database other(daemon.db(), Database::Mode::kReadWrite, 1000);
    other.execute("BEGIN IMMEDIATE");
    test::write_file(daemon.rules() + "/broken.lua", "no rule");  // an alarm that waits, too
    daemon.process().signal(SIGHUP);
    send(1, 10);
    EXPECT_TRUE(is_fed(8.0)) << daemon.log();
    EXPECT_TRUE(daemon.process().alive());
    EXPECT_TRUE(listener->circles.empty());
    other.execute("ROLLBACK");
  }
  EXPECT_TRUE(published(10)) << daemon.log();
  test::write_file(fault(), "slow 2500");
  send(11, 14);
  EXPECT_TRUE(is_fed(9.0)) << daemon.log();
  EXPECT_TRUE(published(14)) << daemon.log();
  test::write_file(fault(), "");
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 1, 14);
}

TEST_F(Fault, WhatCannotBeStoredAtTheEndIsSaid) {
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  Database other(daemon.db(), Database::Mode::kReadWrite, 1000);
  other.execute("BEGIN IMMEDIATE");
  send(1, 2);
  ASSERT_TRUE(daemon.says("2 runs wait in memory")) << daemon.log();
  daemon.process().signal(SIGTERM);
  EXPECT_EQ(daemon.process().wait(), 0) << daemon.log();
  EXPECT_NE(daemon.log().find("2 runs could not be stored and are lost"), std::string::npos) << daemon.log();
  other.execute("ROLLBACK");
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

TEST_F(Fault, TheMachinesOwnClockMayStepByHours) {
  LiveDaemon daemon(test::planar_robot(dir.path()), faulty());
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  constexpr std::int64_t kHourUs = 3'600'000'000;
  const auto ahead_hours = [&] {  // as the service's own status says
    using namespace std::chrono;
    const auto now = duration_cast<microseconds>(system_clock::now().time_since_epoch()).count();
    const double hours = static_cast<double>(listener->status->time_us - now) / kHourUs;
    return static_cast<int>(std::lround(hours));
  };
  std::int64_t circle = 0;
  for (const int hours : {0, 5, -3, 1000, 0}) {
    SCOPED_TRACE(hours);
    test::write_file(fault(), "clock " + std::to_string(3600 * hours));
    listener->status.reset();
    EXPECT_TRUE(listener->until([&] { return listener->status && ahead_hours() == hours; }, test::kPatienceS))
        << daemon.log();
    ++circle;
    send(circle, circle);
    EXPECT_TRUE(published(static_cast<std::size_t>(circle))) << daemon.log();
    EXPECT_EQ(listener->status->state, "listening");
    EXPECT_EQ(listener->status->receiver_restarts, 0);
  }
  EXPECT_EQ(listener->alarms.size(), 0u);
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
  expect_all_ok(daemon.db(), 1, circle);
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
  EXPECT_TRUE(daemon.says("not even the service's own status is heard")) << daemon.log();
  listener = std::make_unique<test::Listener>();
  EXPECT_TRUE(listener->until(
      [&] {
        return listener->status && listener->status->receiver_restarts == 1 &&
               listener->status->state == "listening";
      },
      test::kPatienceS))
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
  starve(daemon);
}

/// A control group of the kernel for memory, as systemd makes one for the unit's MemoryMax=. Gone with this
/// object.
class MemoryGroup {
 public:
  explicit MemoryGroup(std::int64_t bytes) {
    const std::string name = "/ballbar-test-" + std::to_string(getpid());
    for (const std::string& root : {std::string("/sys/fs/cgroup/memory"), std::string("/sys/fs/cgroup")}) {
      std::error_code none;
      if (!std::filesystem::create_directory(root + name, none) || none) continue;
      path_ = root + name;
      for (const char* limit : {"/memory.limit_in_bytes", "/memory.max"})  // version 1, version 2
        if (std::filesystem::exists(path_ + limit, none)) {
          test::write_file(path_ + limit, std::to_string(bytes));
          test::write_file(path_ + "/memory.swap.max", "0");
          return;
        }
      std::filesystem::remove(path_, none);
      path_.clear();
    }
  }
  ~MemoryGroup() {
    std::error_code none;
    if (!path_.empty()) std::filesystem::remove(path_, none);
  }
  MemoryGroup(const MemoryGroup&) = delete;
  MemoryGroup& operator=(const MemoryGroup&) = delete;

  bool exists() const { return !path_.empty(); }
  void take_in(pid_t pid) const { test::write_file(path_ + "/cgroup.procs", std::to_string(pid)); }
  std::int64_t kills() const {
    std::istringstream words(test::read_file(path_ + "/memory.oom_control") + " " +
                             test::read_file(path_ + "/memory.events"));
    for (std::string word; words >> word;)
      if (std::int64_t n = 0; word == "oom_kill" && words >> n) return n;
    return 0;
  }

 private:
  std::string path_;
};

TEST_F(Fault, AtTheLimitOfItsControlGroupTheKernelKillsAndNothingThatWasStoredIsLost) {
#ifdef __SANITIZE_ADDRESS__
  GTEST_SKIP() << "a sanitizer needs memory of its own";
#endif
  const MemoryGroup group(std::int64_t{1} << 20);
  if (!group.exists()) GTEST_SKIP() << "this machine lets nobody make a control group for memory";
  LiveDaemon daemon(test::planar_robot(dir.path()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  send(1, 2);
  ASSERT_TRUE(published(2)) << daemon.log();
  group.take_in(daemon.process().pid());
  starve(daemon);
  EXPECT_GT(group.kills(), 0);
}

}  // namespace
}  // namespace ballbar
