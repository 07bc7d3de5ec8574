// LCM logs as files, whole and damaged.

#include "bus/log_file.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <lcm/lcm-cpp.hpp>

#include "core/error.hpp"
#include "support/messages.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

TEST(InspectLog, SaysWhatIsWrongWithAFile) {
  const test::TempDir dir;
  const auto message = [](const std::string& path) -> std::string {
    try {
      inspect_log(path);
    } catch (const Error& error) {
      return error.what();
    }
    return "";
  };
  EXPECT_NE(message(dir.path() + "/none.lcm").find("cannot be read"), std::string::npos);
  EXPECT_NE(message(dir.path()).find("folder"), std::string::npos);
  std::ofstream(dir.path() + "/text.lcm") << "angle;deviation\n";
  EXPECT_NE(message(dir.path() + "/text.lcm").find("not an LCM log"), std::string::npos);
  EXPECT_NE(message(dir.path() + "/a?b.lcm").find("'?' in its name"), std::string::npos);
  std::ofstream(dir.path() + "/empty.lcm").flush();
  EXPECT_NE(message(dir.path() + "/empty.lcm").find("not an LCM log"), std::string::npos);
}

TEST(InspectLog, FindsTheFirstDamage) {
  const test::TempDir dir;
  const std::string path = dir.path() + "/run.lcm";
  {
    lcm::LCM writer("file://" + path + "?mode=w");
    for (int i = 0; i < 100; ++i) {
      const joint_samples_t joints = test::joint_message(test::kEpochUs + i, i, {0.1, 0.2});
      writer.publish("JOINTS", &joints);
    }
  }
  const LogFile log = inspect_log(path);
  EXPECT_TRUE(log.whole());
  EXPECT_EQ(log.events, 100);
  const std::int64_t event = log.bytes / 100;
  std::fstream(path, std::ios::in | std::ios::out | std::ios::binary).seekp(40 * event).write("garbage", 7);
  EXPECT_EQ(inspect_log(path).events, 40);
  EXPECT_EQ(inspect_log(path).good_bytes, 40 * event);
  EXPECT_FALSE(inspect_log(path).whole());
  std::filesystem::resize_file(path, static_cast<std::uintmax_t>(20 * event + 5));
  EXPECT_EQ(inspect_log(path).events, 20);
}

}  // namespace
}  // namespace ballbar
