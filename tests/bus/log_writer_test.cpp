// Samples to bytes and back, and logs that liblcm reads.

#include "bus/log_writer.hpp"

#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <lcm/lcm-cpp.hpp>

#include "bus/decode.hpp"
#include "bus/log_file.hpp"
#include "core/error.hpp"
#include "support/messages.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

namespace fs = std::filesystem;

SampleHeader header(std::int64_t time_us, std::int64_t seq) {
  SampleHeader made;
  made.time_us = time_us;
  made.seq = seq;
  made.robot = "r1";
  return made;
}

/// What a test's own message says of the same sample.
TEST(Encode, GivesTheBytesOfTheGeneratedTypes) {
  const std::int64_t t = test::kEpochUs;
  const Encoded bar = encode(BallbarBlock{header(t, 7), 4e-3, {1.5e-6, -2.25e-6}});
  EXPECT_EQ(bar.channel, Channel::kBallbar);
  EXPECT_EQ(bar.bytes,
            test::bytes_of(test::bar_message(t, 7, {1.5e-6 / 1e-6, -2.25e-6 / 1e-6}, 4e-3 / 1e-6)));

  const Encoded joints = encode(JointSample{header(t, 8), {0.1, -0.2, 0.3}, {}});
  EXPECT_EQ(joints.channel, Channel::kJoints);
  EXPECT_EQ(joints.bytes, test::bytes_of(test::joint_message(t, 8, {0.1, -0.2, 0.3})));

  const Encoded reading = encode(InterferometerBlock{header(t, 9), 'Z', {0.25}, {4e-6}});
  EXPECT_EQ(reading.channel, Channel::kInterferometer);
  EXPECT_EQ(reading.bytes, test::bytes_of(test::interferometer_message(t, 9, 0.25 / 1e-3, 4e-6 / 1e-6, "Z")));
}

TEST(Encode, EverySampleComesBackFromDecodeAsItWas) {
  const std::int64_t t = test::kEpochUs;
  TestMark mark{header(t, 3), "A", Mark::kEnd, -1, 4, "after", 0.05533, 0.438, {}};
  for (const std::optional<double> temperature : {std::optional<double>(), std::optional<double>(21.5)}) {
    mark.temperature = temperature;
    const Encoded encoded = encode(mark);
    const Decoded decoded = decode(encoded.channel, encoded.bytes);
    ASSERT_TRUE(std::holds_alternative<Sample>(decoded));
    const auto& back = std::get<TestMark>(std::get<Sample>(decoded));
    EXPECT_EQ(back.header.time_us, t);
    EXPECT_EQ(back.header.seq, 3);
    EXPECT_EQ(back.test, "A");
    EXPECT_EQ(back.mark, Mark::kEnd);
    EXPECT_EQ(back.direction, -1);
    EXPECT_EQ(back.repetition, 4);
    EXPECT_EQ(back.series, "after");
    EXPECT_DOUBLE_EQ(back.feed, 0.05533);
    EXPECT_EQ(back.payload, 0.438);
    EXPECT_EQ(back.temperature, temperature);
  }
  const JointSample held{header(t, 1), {0.5, 0.6}, {3.0, -4.0}};
  const Encoded encoded = encode(held);
  const auto back = std::get<JointSample>(std::get<Sample>(decode(encoded.channel, encoded.bytes)));
  EXPECT_EQ(back.position, held.position);
  EXPECT_EQ(back.torque, held.torque);
}

TEST(LogWriter, LiblcmReadsWhatItWrote) {
  const test::TempDir dir;
  const std::string path = dir.path() + "/x.lcm";
  std::vector<Encoded> sent;
  {
    LogWriter log(path);
    for (int i = 0; i < 20; ++i) {
      sent.push_back(i % 2 ? encode(JointSample{header(test::kEpochUs + i, i), {0.1 * i}, {}})
                           : encode(BallbarBlock{header(test::kEpochUs + i, i), 1e-3, {1e-6 * i}}));
      log.write(sent.back(), test::kEpochUs + 100 * i);
      EXPECT_FALSE(fs::exists(path)) << "nothing before it is complete";
    }
    log.keep();
    EXPECT_EQ(log.events(), 20);
  }
  EXPECT_TRUE(inspect_log(path).whole());
  EXPECT_EQ(inspect_log(path).events, 20);
  lcm::LogFile log(path, "r");
  ASSERT_TRUE(log.good());
  for (int i = 0; i < 20; ++i) {
    const lcm::LogEvent* event = log.readNextEvent();
    ASSERT_NE(event, nullptr);
    EXPECT_EQ(event->eventnum, i);
    EXPECT_EQ(event->timestamp, test::kEpochUs + 100 * i);
    EXPECT_EQ(event->channel, i % 2 ? "JOINTS" : "BALLBAR");
    const auto* data = static_cast<const std::uint8_t*>(event->data);
    EXPECT_EQ(std::vector<std::uint8_t>(data, data + event->datalen),
              sent[static_cast<std::size_t>(i)].bytes);
  }
  EXPECT_EQ(log.readNextEvent(), nullptr);
}

TEST(LogWriter, WholeLogOrNothing) {
  const test::TempDir dir;
  const std::string path = dir.path() + "/x.lcm";
  std::ofstream(path) << "what stood there";
  {
    LogWriter log(path);
    log.write(encode(JointSample{header(test::kEpochUs, 1), {0.1}, {}}), test::kEpochUs);
  }
  std::ifstream file(path);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(file), {}), "what stood there");
  EXPECT_EQ(std::distance(fs::directory_iterator(dir.path()), {}), 1) << "no draft is left";
}

TEST(LogWriter, SaysWhyItCannotWrite) {
  const test::TempDir dir;
  const auto cause_of = [](const std::string& path, const std::string& says) {
    try {
      LogWriter log(path);
    } catch (const Error& error) {
      EXPECT_NE(std::string(error.what()).find(path + ": " + says), std::string::npos) << error.what();
      return error.cause() == Cause::kInput ? 2 : 3;
    }
    return 0;
  };
  EXPECT_EQ(cause_of(dir.path() + "/none/x.lcm", "cannot be written: No such file"), 3);
  EXPECT_EQ(cause_of(dir.path() + "/a?b.lcm", "has a '?' in its name"), 2);
  EXPECT_EQ(cause_of(dir.path(), "is a folder"), 2);
}

}  // namespace
}  // namespace ballbar
