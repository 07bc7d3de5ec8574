#pragma once
/// The wire's channels and the stated limits of what is believed from it.

#include <array>
#include <cstddef>
#include <cstdint>
#include <functional>
#include <span>
#include <string_view>
#include <variant>

#include "core/samples.hpp"

namespace ballbar {

enum class Channel : std::uint8_t { kBallbar, kInterferometer, kJoints, kTestMark };

struct ChannelInfo {
  Channel channel;
  const char* name;
  int queue_capacity;  ///< messages that wait inside LCM while the receiver is busy; the oldest falls out
                       ///< after that
};

/// Capacity = longest stall (2 s) times the rate at 50 times real speed, rounded up.
inline constexpr std::array<ChannelInfo, 4> kInputChannels{{
    {Channel::kBallbar, "BALLBAR", 2000},
    {Channel::kInterferometer, "INTERFEROMETER", 2000},
    {Channel::kJoints, "JOINTS", 16000},
    {Channel::kTestMark, "TEST_MARK", 500},
}};

/// @param arrival_us  LCM's receive time; of a log the time at which its writer received it
using RawHandler = std::function<void(Channel, std::span<const std::uint8_t> bytes, std::int64_t arrival_us)>;

/// What the service itself says once a second: as long as it comes back, the bus is heard.
inline constexpr const char* kPulseChannel = "BALLBARD_STATUS";

inline constexpr const char* channel_name(Channel channel) {
  return kInputChannels[static_cast<std::size_t>(channel)].name;
}

/// The channel that carries it.
inline Channel channel_of(const Sample& sample) {
  struct Visitor {
    Channel operator()(const BallbarBlock&) const { return Channel::kBallbar; }
    Channel operator()(const InterferometerBlock&) const { return Channel::kInterferometer; }
    Channel operator()(const JointSample&) const { return Channel::kJoints; }
    Channel operator()(const TestMark&) const { return Channel::kTestMark; }
  };
  return std::visit(Visitor{}, sample);
}

inline constexpr std::int64_t kLatestTimeUs =
    4'102'444'800'000'000;  ///< the year 2100: later is no clock of a robot
inline constexpr std::size_t kMaxMessageBytes = 65'000;
inline constexpr int kMaxNameBytes = 128;  ///< robot, test, series, with the closing NUL
inline constexpr int kMaxBlock = 8'000;    ///< samples in one message
inline constexpr int kMaxJoints = 16;

/// Why a message was not believed. Counted by reason.
enum class Refusal : std::uint8_t {
  kTooLarge,      ///< more than kMaxMessageBytes
  kFingerprint,   ///< another type, or another version of it
  kTruncated,     ///< shorter or longer than its own counts say
  kString,        ///< empty, too long, or not closed by NUL
  kCount,         ///< a count below 0 or above its maximum
  kNotFinite,     ///< NaN or infinity
  kValue,         ///< a value that cannot be: mark, axis, period, time
  kUnknownRobot,  ///< not configured
  kUnknownTest,   ///< not configured
  kOutOfOrder,    ///< a duplicate, or overtaken by later ones
};
inline constexpr std::size_t kRefusals = 10;

inline constexpr std::array<std::string_view, kRefusals> kRefusalNames{
    "too_large",  "fingerprint", "truncated",     "string",       "count",
    "not_finite", "value",       "unknown_robot", "unknown_test", "out_of_order"};

}  // namespace ballbar
