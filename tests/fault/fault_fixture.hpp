#pragma once
/// A cell and the real service that hears it, on a loopback of their own.

#include <gtest/gtest.h>
#include <sched.h>
#include <sys/mount.h>

#include <cstdlib>
#include <filesystem>
#include <map>
#include <memory>
#include <string>
#include <vector>

#include "store/store.hpp"
#include "support/circle_feed.hpp"
#include "support/live_daemon.hpp"

namespace ballbar {

using test::CircleFeed;
using test::LiveDaemon;

/// Runs of the database by begin, with their status.
inline std::map<std::int64_t, std::string> stored(const std::string& db) {
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
  bool published(std::size_t circles, double seconds = test::kPatienceS) {
    return listener->until([&] { return listener->circles.size() >= circles; }, seconds);
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
  /// More than there is memory for, behind circles 1 and 2; then a new start, as systemd does it.
  void starve(LiveDaemon& daemon) {
    CircleFeed large(2000, 1000);  // half a million numbers
    large.send(listener->lcm(), 3, 10);
    large.send(listener->lcm(), 4, 10);
    listener->until([&] { return !daemon.process().alive(); }, 2);  // or it has refused
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
  /// A disk of 2 MB that the test may fill. @return its folder; "" where this machine allows no mount
  std::string small_disk() const {
    const std::string disk = dir.path() + "/disk";
    std::filesystem::create_directory(disk);
    if (unshare(CLONE_NEWNS) != 0 || mount("none", "/", nullptr, MS_REC | MS_PRIVATE, nullptr) != 0 ||
        mount("ballbar", disk.c_str(), "tmpfs", 0, "size=2m") != 0)
      return "";
    return disk;
  }
  /// The environment of a ballbard whose disk and clock do what the file fault() says.
  std::vector<std::string> faulty() const {
    const char* asan = std::getenv("ASAN_OPTIONS");
    return {"LD_PRELOAD=" BALLBAR_FAULTY_MACHINE, "BALLBAR_FAULT=" + fault(),
            "ASAN_OPTIONS=" + std::string(asan ? asan : "") + ":verify_asan_link_order=0"};
  }
  std::string fault() const { return dir.path() + "/fault"; }

  test::TempDir dir;
  std::unique_ptr<test::Listener> listener;
  CircleFeed feed;
};

}  // namespace ballbar
