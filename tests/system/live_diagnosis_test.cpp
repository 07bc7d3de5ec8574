// The end of a series, heard live: a diagnosis in a process of its own, stored, published, the same as the
// tool's; and whatever becomes of that process, the service goes on.

#include <gtest/gtest.h>

#include <algorithm>
#include <ballbar/test_mark_t.hpp>
#include <filesystem>
#include <fstream>
#include <memory>
#include <nlohmann/json.hpp>
#include <sstream>

#include "store/store.hpp"
#include "support/live_daemon.hpp"

namespace ballbar {
namespace {

using nlohmann::json;
using test::LiveDaemon;
namespace fs = std::filesystem;

const fs::path kCase = fs::path(BALLBAR_SHARED_DIR) / "data" / "practice" / "09";
constexpr double kSpeed = 50.0;

/// The case's robot, whose URDF is `urdf`, with [diagnosis] before it.
std::string robot_with(const std::string& diagnosis, const std::string& urdf) {
  std::string text = test::read_file((kCase / "ballbard.toml").string());
  const std::string name = "\"lrmate200ic.urdf\"";
  text.replace(text.find(name), name.size(), "\"" + urdf + "\"");
  return "[diagnosis]\n" + diagnosis + text;
}

/// The recording as if it had been driven without a break: the log's own times, not those in the messages.
/// @param most  circles
void without_breaks(const std::string& from, const std::string& to, int most) {
  constexpr std::int64_t kLongestUs = 20'000;
  lcm::LogFile in(from, "r");
  lcm::LogFile out(to, "w");
  std::int64_t last = 0, now = 0;
  while (const lcm::LogEvent* event = in.readNextEvent()) {
    now += last == 0 ? 0 : std::clamp<std::int64_t>(event->timestamp - last, 0, kLongestUs);
    last = event->timestamp;
    lcm::LogEvent copy = *event;
    copy.timestamp = now;
    out.writeEvent(&copy);
    if (event->channel != "TEST_MARK") continue;
    test_mark_t mark;
    mark.decode(event->data, 0, event->datalen);
    if (mark.mark == 2 && --most == 0) return;
  }
}

class LiveDiagnosisTest : public testing::Test {
 protected:
  void SetUp() override {
    if (!fs::exists(kCase)) GTEST_SKIP() << kCase << " is not there";
    const std::string failure = test::enter_private_network();
    ASSERT_EQ(failure, "") << "these tests need a network namespace (root, or user namespaces allowed)";
    listener = std::make_unique<test::Listener>();
    fs::copy_file(kCase / "lrmate200ic.urdf", dir.path() + "/robot.urdf");
    without_breaks((kCase / "recording.lcm").string(), log(), 100);
    without_breaks((kCase / "recording.lcm").string(), short_log(), 2);
  }
  std::string urdf() const { return dir.path() + "/robot.urdf"; }
  std::string log() const { return dir.path() + "/recording.lcm"; }
  std::string short_log() const { return dir.path() + "/two.lcm"; }

  test::TempDir dir;
  std::unique_ptr<test::Listener> listener;
};

TEST_F(LiveDiagnosisTest, IsStoredAndPublishedAndTheSameAsTheTools) {
  LiveDaemon daemon(robot_with("series_ends_after_s = 2\n", urdf()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  ASSERT_EQ(test::play(log(), kSpeed), 0);
  ASSERT_TRUE(listener->until([&] { return !listener->gaps.empty(); }, 120)) << daemon.log();
  const gap_result_t heard = listener->gaps.back();
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();

  const std::vector<StoredGap> stored = Store::open_read_only(daemon.db()).gaps();
  ASSERT_EQ(stored.size(), 1u) << daemon.log();
  const GapRecord& record = stored[0].record;
  const test::Outcome tool =
      test::run({test::kBallbar, "diagnose", "--series", heard.series + "," + heard.series + "-held-out",
                 "--config", daemon.config(), "--json"});
  EXPECT_EQ(json::parse(stored[0].json), json::parse(tool.out, nullptr, false)) << tool.err;

  EXPECT_EQ(heard.robot, "lrmate-1");
  EXPECT_EQ(heard.verdict, record.verdict);
  EXPECT_EQ(heard.time_us, record.ended_us);
  EXPECT_EQ(heard.seq, 1);
  EXPECT_GT(heard.rms_before_um, 20.0);
  EXPECT_NEAR(heard.rms_before_um, 1e6 * record.rms_before, 1e-9);
  ASSERT_EQ(static_cast<std::size_t>(heard.effects), record.left_out.size());
  bool named = false;  // concealed by a generator of others: lost motion of joint 2
  for (std::size_t i = 0; i < record.left_out.size(); ++i) {
    EXPECT_EQ(heard.effect[i], record.left_out[i].effect);
    EXPECT_EQ(heard.joint[i], record.left_out[i].joint);
    named =
        named || (heard.effect[i] == "joint_lost_motion" && heard.joint[i] == 2 && !heard.kind[i].empty());
  }
  EXPECT_TRUE(named) << heard.says;
  EXPECT_NE(heard.says.find("joint 2"), std::string::npos) << heard.says;
}

/// The child of a process that diagnoses; 0 where there is none.
pid_t diagnosis_of(pid_t daemon) {
  const std::string id = std::to_string(daemon);
  std::istringstream children(test::read_file("/proc/" + id + "/task/" + id + "/children"));
  for (pid_t child = 0; children >> child;)
    if (test::read_file("/proc/" + std::to_string(child) + "/cmdline").find("--diagnose") !=
        std::string::npos)
      return child;
  return 0;
}

TEST_F(LiveDiagnosisTest, WhoseProcessIsKilledCostsNothingAndIsTakenUpAtTheNextStart) {
  LiveDaemon daemon(robot_with("series_ends_after_s = 1\n", urdf()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  ASSERT_EQ(test::play(short_log(), kSpeed), 0);
  pid_t child = 0;
  const auto end = std::chrono::steady_clock::now() + std::chrono::seconds(60);
  while (child == 0 && std::chrono::steady_clock::now() < end) {
    child = diagnosis_of(daemon.process().pid());
    if (child == 0) usleep(500);
  }
  ASSERT_GT(child, 0) << daemon.log();
  ASSERT_EQ(kill(child, SIGKILL), 0);
  EXPECT_TRUE(listener->until(
      [&] { return daemon.log().find("is not diagnosed: its process ended with 137") != std::string::npos; },
      test::kPatienceS))
      << daemon.log();
  EXPECT_TRUE(listener->gaps.empty());
  listener->status.reset();
  EXPECT_TRUE(listener->until([&] { return listener->status.has_value(); }, test::kPatienceS))
      << "the service goes on";
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();

  test::Background again({test::kBallbard, "--config", daemon.config()}, dir.path() + "/again");
  EXPECT_TRUE(listener->until([&] { return !listener->gaps.empty(); }, 150)) << again.err();
  again.signal(SIGTERM);
  EXPECT_EQ(again.wait(), 0);
  listener->gaps.clear();
  test::Background once_more({test::kBallbard, "--config", daemon.config()}, dir.path() + "/once_more");
  EXPECT_FALSE(listener->until([&] { return !listener->gaps.empty(); }, 3)) << "it has its diagnosis";
}

TEST_F(LiveDiagnosisTest, ThatCannotBeMadeIsSaidInOneLineAndThatIsAll) {
  LiveDaemon daemon(robot_with("series_ends_after_s = 1\n", urdf()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  fs::remove(urdf());
  ASSERT_EQ(test::play(short_log(), kSpeed), 0);
  EXPECT_TRUE(
      listener->until([&] { return daemon.log().find("is not diagnosed: ") != std::string::npos; }, 150))
      << daemon.log();
  EXPECT_TRUE(listener->gaps.empty());
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
}

TEST_F(LiveDiagnosisTest, IsLeftToTheToolWhereTheConfigurationSaysSo) {
  LiveDaemon daemon(robot_with("live = false\nseries_ends_after_s = 1\n", urdf()));
  ASSERT_TRUE(daemon.ready()) << daemon.log();
  ASSERT_EQ(test::play(short_log(), kSpeed), 0);
  EXPECT_FALSE(listener->until([&] { return !listener->gaps.empty(); }, 4));
  EXPECT_EQ(daemon.log().find("is diagnosed"), std::string::npos) << daemon.log();
  EXPECT_EQ(daemon.stop(), 0) << daemon.log();
}

}  // namespace
}  // namespace ballbar
