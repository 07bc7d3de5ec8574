// Everything that anybody may send: the service lives, its memory stays within bounds, the log stays short,
// and honest circles are stored whole.

#include <arpa/inet.h>
#include <gtest/gtest.h>
#include <sys/socket.h>

#include <algorithm>
#include <filesystem>
#include <map>
#include <random>
#include <utility>

#include "store/store.hpp"
#include "support/circle_feed.hpp"
#include "support/live_daemon.hpp"

namespace ballbar {
namespace {

/// Raw datagrams to the port that every receiver is bound to.
class Attacker {
 public:
  Attacker() : fd_(socket(AF_INET, SOCK_DGRAM | SOCK_CLOEXEC, 0)) {
    to_.sin_family = AF_INET;
    to_.sin_port = htons(7667);
    to_.sin_addr.s_addr = htonl(INADDR_LOOPBACK);
  }
  ~Attacker() { close(fd_); }
  void raw(const std::string& bytes) {
    sendto(fd_, bytes.data(), bytes.size(), 0, reinterpret_cast<const sockaddr*>(&to_), sizeof to_);
  }
  /// A well-formed short LCM packet.
  void message(const std::string& channel, const std::string& bytes) {
    std::string packet = "LC02";
    ++seq_;
    for (int shift = 24; shift >= 0; shift -= 8) packet += static_cast<char>(seq_ >> shift);
    raw(packet + channel + '\0' + bytes);
  }
  /// liblcm hands both on with a size of some 4 GB and a name made of what lay behind.
  void without_end_of_name_or_payload() {
    raw(std::string("LC02\0\0\0\1BALLBAR", 15));
    raw(std::string("LC02\0\0\0\1", 8));
  }
  /// A first fragment that ends inside its channel's name: liblcm copies 4 GB.
  void deadly() {
    raw(std::string(200, '\0'));
    raw(std::string("LC03") + std::string("\0\0\0\7\0\0\3\350\0\0\0\1\0\0\0\2", 16) + "BALLBAR");
  }

 private:
  int fd_;
  sockaddr_in to_{};
  std::uint32_t seq_ = 0;
};

/// [bytes] in use by a process; 0 where it is gone.
std::int64_t resident(pid_t pid) {
  std::ifstream statm("/proc/" + std::to_string(pid) + "/statm");
  std::int64_t total = 0;
  std::int64_t pages = 0;
  statm >> total >> pages;
  return pages * 4096;
}

std::vector<pid_t> children(pid_t pid) {
  std::ifstream list("/proc/" + std::to_string(pid) + "/task/" + std::to_string(pid) + "/children");
  std::vector<pid_t> found;
  for (pid_t child = 0; list >> child;) found.push_back(child);
  return found;
}

/// Whether every thread of a process waits for something.
bool sleeps(pid_t pid) {
  std::error_code gone;
  for (const auto& task :
       std::filesystem::directory_iterator("/proc/" + std::to_string(pid) + "/task", gone)) {
    const std::string stat = test::read_file(task.path() / "stat");
    const std::size_t name_end = stat.rfind(") ");
    if (name_end != std::string::npos && stat[name_end + 2] != 'S') return false;
  }
  return true;
}

/// Waits, for a minute at most, until nothing is unread, and service and receiver sleep: then nothing waits
/// in liblcm's queues either, which drop without a word where somebody is faster than this machine.
void let_catch_up(pid_t service) {
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(test::kPatienceS);
  const auto idle = [&] {
    const std::vector<pid_t> receivers = children(service);
    return test::unread_datagrams() == 0 && sleeps(service) &&
           std::all_of(receivers.begin(), receivers.end(), sleeps);
  };
  while (!idle() && std::chrono::steady_clock::now() < end)
    std::this_thread::sleep_for(std::chrono::microseconds(200));
}

class HostileWire : public testing::Test {
 protected:
  void SetUp() override {
    const std::string failure = test::enter_private_network();
    ASSERT_EQ(failure, "") << "these tests need a network namespace (root, or user namespaces allowed)";
    daemon = std::make_unique<test::LiveDaemon>(test::planar_robot(dir.path()));
    attacker = std::make_unique<Attacker>();  // its socket belongs to that network
    sender = std::make_unique<lcm::LCM>(test::kLiveUrl);
    ASSERT_TRUE(daemon->ready()) << daemon->log();
  }
  /// Sends circles like a cell, not faster than it is heard.
  void circles(std::int64_t first, std::int64_t last) {
    for (std::int64_t number = first; number <= last; ++number) feed.send(*sender, number, 300);
  }
  bool stored(std::size_t runs) {
    for (int i = 0; i < 20 * test::kPatienceS; ++i) {
      const std::string log = daemon->log();
      std::size_t lines = 0;
      for (std::size_t at = 0; (at = log.find(": ok, ovality", at)) != std::string::npos; ++at) ++lines;
      if (lines >= runs) return true;
      std::this_thread::sleep_for(std::chrono::milliseconds(50));
    }
    return false;
  }
  /// Waits until the service has dealt with all that was sent: nothing is unread, and from one second to the
  /// next nothing is counted. Not for when somebody may still send what kills a listener.
  bool caught_up() {
    test::Listener listener;
    std::int64_t before = -1;
    let_catch_up(daemon->process().pid());
    return listener.until(
        [&] {
          if (!listener.status) return false;
          const daemon_status_t now = *listener.status;
          listener.status.reset();
          const std::int64_t counted = now.messages + now.refused;
          return now.state == "listening" && std::exchange(before, counted) == counted;
        },
        test::kPatienceS);
  }
  void look_at_memory() {
    largest_service = std::max(largest_service, resident(daemon->process().pid()));
    for (const pid_t child : children(daemon->process().pid()))
      largest_receiver = std::max(largest_receiver, resident(child));
  }
  void expect_alive_bounded_and_quiet() {
    look_at_memory();
#ifndef __SANITIZE_ADDRESS__
    EXPECT_LT(largest_service, std::int64_t{100} << 20);
    EXPECT_LT(largest_receiver, std::int64_t{300} << 20);
#endif
    RecordProperty("service_kib", static_cast<int>(largest_service >> 10));
    RecordProperty("receiver_kib", static_cast<int>(largest_receiver >> 10));
    const std::string log = daemon->log();
    EXPECT_LT(std::count(log.begin(), log.end(), '\n'), 40) << log;
    EXPECT_EQ(daemon->stop(), 0) << log;
  }

  test::TempDir dir;
  std::unique_ptr<test::LiveDaemon> daemon;
  std::unique_ptr<lcm::LCM> sender;
  test::CircleFeed feed;
  std::unique_ptr<Attacker> attacker;
  std::int64_t largest_service = 0, largest_receiver = 0;
};

TEST_F(HostileWire, GarbageForgedLengthsAndStrangersAmongHonestCirclesCostNothing) {
  constexpr unsigned kSeed = 3;
  SCOPED_TRACE("seed " + std::to_string(kSeed));
  std::mt19937_64 rng(kSeed);
  const std::vector<std::uint8_t> good =
      test::bytes_of(test::bar_message(test::kEpochUs, 1, std::vector<double>(20, 1.0), 4000, "planar"));
  const std::vector<std::uint8_t> stranger =
      test::bytes_of(test::joint_message(test::kEpochUs, 1, {0, 0}, "somebody"));
  const pid_t service = daemon->process().pid();
  std::thread attack([&] {
    for (int i = 0; i < 6000; ++i) {
      std::string forged(good.begin(), good.end());
      const std::size_t field = rng() % 2 == 0 ? 24 : 43;  // the name's length, the count
      for (std::size_t k = 0; k < 4; ++k) forged[field + k] = static_cast<char>(rng());
      attacker->message("BALLBAR", forged);
      attacker->message("JOINTS", std::string(stranger.begin(), stranger.end()));
      attacker->message("TEST_MARK", std::string(rng() % 60, static_cast<char>(rng())));
      std::string noise(1 + rng() % 60, '\0');
      for (char& c : noise) c = static_cast<char>(rng());
      attacker->raw(noise);
      attacker->without_end_of_name_or_payload();
      usleep(100);
      if (i % 64 == 0) let_catch_up(service);
    }
  });
  circles(1, 4);
  attack.join();
  circles(5, 5);
  EXPECT_TRUE(stored(5)) << daemon->log();
  for (const char* reason : {"string", "unknown_robot", "truncated"})
    EXPECT_NE(daemon->log().find(std::string(": ") + reason + " ("), std::string::npos) << reason << "\n"
                                                                                        << daemon->log();
  expect_alive_bounded_and_quiet();
  Store store = Store::open_read_only(daemon->db());
  EXPECT_EQ(store.database().integer("SELECT count(*) FROM run"), 5);
  EXPECT_EQ(store.database().integer("SELECT sum(lost_messages) + sum(receiver_restarts) FROM run"), 0)
      << "of four runs under fire";
}

TEST_F(HostileWire, TwoHundredThousandChannelNamesStayWithinBounds) {
#ifdef __SANITIZE_ADDRESS__  // with its red zones they fill the receiver's 256 MiB, and it starts anew
  constexpr int kNames = 20'000;
#else
  constexpr int kNames = 200'000;
#endif
  look_at_memory();
  const std::int64_t before = largest_receiver;
  for (int i = 0; i < kNames; ++i) {
    attacker->message("CHANNEL_" + std::to_string(i), "x");
    if (i % 100 == 0) usleep(500);
    if (i % 20'000 == 0) look_at_memory();
  }
  ASSERT_TRUE(test::wait_for_readers(0)) << daemon->log();  // where they were too many, the kernel drops some
  look_at_memory();
  EXPECT_GT(largest_receiver - before, kNames * 30) << "most of them have arrived: each costs some 95 bytes";
  circles(1, 2);
  EXPECT_TRUE(stored(2)) << daemon->log();
  expect_alive_bounded_and_quiet();
}

TEST_F(HostileWire, OneWhoKillsTheReceiverAgainAndAgainCostsHolesOnly) {
  for (int i = 0; i < 60; ++i) {
    attacker->deadly();
    std::this_thread::sleep_for(std::chrono::milliseconds(40));
  }
  ASSERT_TRUE(caught_up()) << daemon->log();  // the last one was started again
  circles(1, 2);
  EXPECT_TRUE(stored(2)) << daemon->log();
  EXPECT_NE(daemon->log().find("the receiver died and is started again"), std::string::npos);
  test::Listener listener;
  EXPECT_TRUE(listener.until([&] { return listener.status.has_value(); }, test::kPatienceS));
  EXPECT_GE(listener.status->receiver_restarts, 3);
  expect_alive_bounded_and_quiet();
}

TEST_F(HostileWire, TenTimesAsManyMessagesOfOthersCostHonestCirclesNothing) {
  const auto bytes = [](const auto& message) {
    const std::vector<std::uint8_t> all = test::bytes_of(message);
    return std::string(all.begin(), all.end());
  };
  const std::string joints = bytes(test::joint_message(test::kEpochUs, 1, {0, 0}, "somebody"));
  const std::string bar =
      bytes(test::bar_message(test::kEpochUs, 1, std::vector<double>(50, 1.0), 4000, "somebody"));
  std::int64_t flood = 0;
  const auto ten_more = [&] {
    for (int i = 0; i < 10; ++i, ++flood)
      attacker->message(i % 2 == 0 ? "JOINTS" : "BALLBAR", i % 2 == 0 ? joints : bar);
    if (flood % 500 == 0) let_catch_up(daemon->process().pid());
  };
  const auto begin = std::chrono::steady_clock::now();
  for (std::int64_t number = 1; number <= 10; ++number) feed.send(*sender, number, ten_more);
  const std::chrono::duration<double> took = std::chrono::steady_clock::now() - begin;
  EXPECT_TRUE(stored(10)) << daemon->log();
  RecordProperty("flood_messages", static_cast<int>(flood));
  RecordProperty("flood_messages_per_second", static_cast<int>(static_cast<double>(flood) / took.count()));
  expect_alive_bounded_and_quiet();
  Store store = Store::open_read_only(daemon->db());
  EXPECT_EQ(store.database().integer("SELECT count(*) FROM run WHERE status = 'ok'"), 10);
  EXPECT_EQ(store.database().integer("SELECT sum(lost_messages) + sum(receiver_restarts) FROM run"), 0);
}

TEST_F(HostileWire, AFloodAndSamplesOfTheFutureEndAndHonestCirclesFollow) {
  for (std::int64_t i = 0; i < 20'000; ++i) {  // as fast as it goes
    const std::vector<std::uint8_t> future = test::bytes_of(test::bar_message(
        4'000'000'000'000'000 + i * 800'000, i + 1, std::vector<double>(200, 1.0), 4000, "planar"));
    attacker->message("BALLBAR", std::string(future.begin(), future.end()));
    if (i % 1000 == 0) look_at_memory();
  }
  ASSERT_TRUE(caught_up()) << daemon->log();
  circles(1, 2);
  EXPECT_TRUE(stored(2)) << daemon->log();
  expect_alive_bounded_and_quiet();
}

TEST_F(HostileWire, ForgedMarksOfAConfiguredRobotDoNotFillTheLog) {
  constexpr std::int64_t kMarks = 2'000;
  for (std::int64_t i = 0; i < kMarks; ++i) {  // each begins a run, and ends the one before
    const Encoded mark = encode(
        TestMark{{4'000'000'000'000'000 + i, i + 1, "planar"}, "A", Mark::kBegin, 1, 1, "s", 0.05, 0.5, {}});
    sender->publish(channel_name(mark.channel), mark.bytes.data(), static_cast<unsigned>(mark.bytes.size()));
    if (i % 16 == 0) let_catch_up(daemon->process().pid());
  }
  ASSERT_TRUE(caught_up()) << daemon->log();
  circles(1, 2);
  test::Listener listener;
  EXPECT_TRUE(
      listener.until([&] { return listener.status && listener.status->runs_ok == 2; }, test::kPatienceS))
      << daemon->log();
  look_at_memory();
#ifndef __SANITIZE_ADDRESS__
  EXPECT_LT(largest_service, std::int64_t{100} << 20);
#endif
  const std::string log = daemon->log();
  EXPECT_LT(std::count(log.begin(), log.end(), '\n'), kMarks / 4) << "200 at once, then two a second";
  EXPECT_EQ(daemon->stop(), 0);
  EXPECT_GT(Store::open_read_only(daemon->db()).counts().runs, kMarks / 2);
}

TEST_F(HostileWire, ARunAsLongAsTheyMayBeStaysWithinTheUnitsMemory) {
  test::CircleFeed long_run(12'500, 12.5);  // 210,000 readings, of 250,000
  long_run.send(*sender, 1, 50);
  EXPECT_TRUE(stored(1)) << daemon->log();
  const std::string status = test::read_file("/proc/" + std::to_string(daemon->process().pid()) + "/status");
  const std::int64_t peak_kib = std::stoll(status.substr(status.find("VmHWM:") + 6));
  RecordProperty("peak_kib", static_cast<int>(peak_kib));
#ifndef __SANITIZE_ADDRESS__
  EXPECT_LT(peak_kib, 400 << 10) << "MemoryMax= is 512 MiB, receiver and what waits have their share";
#endif
  circles(2, 3);
  EXPECT_TRUE(stored(3)) << daemon->log();
  EXPECT_EQ(daemon->stop(), 0) << daemon->log();
}

}  // namespace
}  // namespace ballbar
