// The bus inside one process.

#include "bus/subscriber.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <cstdlib>
#include <filesystem>
#include <fstream>
#include <lcm/lcm-cpp.hpp>

#include "bus/assembler.hpp"
#include "bus/decode.hpp"
#include "bus/log_file.hpp"
#include "core/error.hpp"
#include "support/messages.hpp"
#include "support/temp_dir.hpp"

namespace ballbar {
namespace {

TEST(Subscriber, ARunGoesOverTheBusInsideOneProcess) {
  RobotSpec robot;
  robot.name = "r1";
  TestSpec circle;
  circle.name = "A";
  robot.tests = {circle};
  Assembler assembler({robot});
  std::vector<ballbar::Run> finished;
  Subscriber bus("memq://",
                 [&](Channel channel, std::span<const std::uint8_t> bytes, std::int64_t arrival_us) {
                   const Decoded decoded = decode(channel, bytes);
                   if (const Sample* sample = std::get_if<Sample>(&decoded))
                     assembler.take(*sample, arrival_us, finished);
                   else
                     assembler.refuse(std::get<Refusal>(decoded));
                 });
  const auto send = [&](Channel channel, const auto& message) {
    bus.publish(channel, test::bytes_of(message));
    ASSERT_TRUE(bus.handle());
  };
  send(Channel::kTestMark, test::mark_message(test::kEpochUs, 1, 1));
  for (int i = 0; i < 10; ++i) {
    const std::int64_t time_us = test::kEpochUs + 200'000 * i;
    send(Channel::kJoints, test::joint_message(time_us, i, {0.1, 0.2}));
    send(Channel::kBallbar, test::bar_message(time_us, i, std::vector<double>(50, 12.5)));
  }
  send(Channel::kBallbar, test::bar_message(test::kEpochUs + 2'000'000, 10, {std::nan("")}));
  send(Channel::kTestMark, test::mark_message(test::kEpochUs + 2'000'000, 2, 2));
  send(Channel::kTestMark, test::mark_message(test::kEpochUs + 9'000'000, 3, 1, "A", -1));
  ASSERT_EQ(finished.size(), 1u);
  EXPECT_EQ(finished[0].end, RunEnd::kMark);
  EXPECT_EQ(finished[0].bar_time.size(), 500u);
  EXPECT_EQ(finished[0].joint_time.size(), 10u);
  EXPECT_DOUBLE_EQ(finished[0].bar_deviation[7], 12.5e-6);
  EXPECT_EQ(assembler.counters().refused_total(), 1);
  EXPECT_EQ(assembler.counters().messages, 23);
}

TEST(Subscriber, SaysWhatToDoWhereABusCannotBeOpened) {
  try {
    Subscriber subscriber("nonsense://", [](Channel, std::span<const std::uint8_t>, std::int64_t) {});
    FAIL() << "opened";
  } catch (const Error& error) {
    EXPECT_EQ(error.cause(), Cause::kWorld);
    EXPECT_NE(std::string(error.what()).find("nonsense://"), std::string::npos);
  }
}

}  // namespace
}  // namespace ballbar
