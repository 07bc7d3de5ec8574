// Bytes from anybody: what is believed, and what is refused for which reason.

#include "bus/decode.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "support/messages.hpp"

namespace ballbar {
namespace {

using test::bytes_of;

Refusal refusal_of(Channel channel, const std::vector<std::uint8_t>& bytes) {
  const Decoded decoded = decode(channel, bytes);
  const Refusal* refusal = std::get_if<Refusal>(&decoded);
  EXPECT_NE(refusal, nullptr) << "was believed";
  return refusal ? *refusal : Refusal::kTooLarge;
}

/// Writes a big-endian int32, as a forger would.
void put32(std::vector<std::uint8_t>& bytes, std::size_t at, std::uint32_t value) {
  for (int i = 0; i < 4; ++i)
    bytes[at + static_cast<std::size_t>(i)] = static_cast<std::uint8_t>(value >> (24 - 8 * i));
}

// Layout of ballbar_samples_t: fingerprint 8, time 8, seq 8, string length 4, "r1\0" 3, period 8, count 4,
// samples.
constexpr std::size_t kStringLengthAt = 24;
constexpr std::size_t kCountAt = 39;

TEST(Decode, GivesTheSamplesInSi) {
  const Decoded decoded =
      decode(Channel::kBallbar, bytes_of(test::bar_message(test::kEpochUs, 7, {12.5, -3.0}, 4000.0)));
  const auto& block = std::get<BallbarBlock>(std::get<Sample>(decoded));
  EXPECT_EQ(block.header.robot, "r1");
  EXPECT_EQ(block.header.seq, 7);
  EXPECT_EQ(block.header.time_us, test::kEpochUs);
  EXPECT_NEAR(block.period, 0.004, 1e-15);
  ASSERT_EQ(block.deviation.size(), 2u);
  EXPECT_NEAR(block.deviation[0], 12.5e-6, 1e-18);
  EXPECT_NEAR(block.deviation[1], -3.0e-6, 1e-18);
}

TEST(Decode, ReadsAMarkWithoutTemperature) {
  const Decoded decoded =
      decode(Channel::kTestMark, bytes_of(test::mark_message(test::kEpochUs, 1, 1, "A", -1, 3)));
  const auto& mark = std::get<TestMark>(std::get<Sample>(decoded));
  EXPECT_EQ(mark.mark, Mark::kBegin);
  EXPECT_EQ(mark.direction, -1);
  EXPECT_EQ(mark.repetition, 3);
  EXPECT_NEAR(mark.feed, 0.05, 1e-15);
  EXPECT_FALSE(mark.temperature.has_value());
}

TEST(Decode, RefusesEveryTruncationAndEveryTail) {
  const std::vector<std::uint8_t> whole =
      bytes_of(test::joint_message(test::kEpochUs, 1, {0.1, 0.2, 0.3, 0.4, 0.5, 0.6}));
  for (std::size_t size = 0; size < whole.size(); ++size) {
    const std::vector<std::uint8_t> cut(whole.begin(), whole.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_TRUE(std::holds_alternative<Refusal>(decode(Channel::kJoints, cut))) << size << " bytes";
  }
  std::vector<std::uint8_t> tail = whole;
  tail.insert(tail.end(), {0, 0});  // LCM's own decoder takes this
  EXPECT_EQ(refusal_of(Channel::kJoints, tail), Refusal::kTruncated);
}

TEST(Decode, RefusesForgedLengthsForTheirReason) {
  const std::vector<std::uint8_t> good =
      bytes_of(test::bar_message(test::kEpochUs, 1, std::vector<double>(20, 1.0)));
  const struct {
    std::size_t at;
    std::uint32_t value;
    Refusal reason;
  } table[] = {
      {kStringLengthAt, 0, Refusal::kString},
      {kStringLengthAt, 0xFFFFFFFF, Refusal::kString},
      {kStringLengthAt, 0x80000000, Refusal::kString},
      {kStringLengthAt, 2, Refusal::kString},
      {kCountAt, 0xFFFFFFFF, Refusal::kCount},
      {kCountAt, 100'000'000, Refusal::kCount},
      {kCountAt, 0x10000001, Refusal::kCount},
      {kCountAt, 0x20000000, Refusal::kCount},
      {kCountAt, 0x7FFFFFFF, Refusal::kCount},
      {kCountAt, 21, Refusal::kTruncated},
      {kCountAt, 19, Refusal::kTruncated},
      {0, 0x12345678, Refusal::kFingerprint},
  };
  for (const auto& row : table) {
    std::vector<std::uint8_t> forged = good;
    put32(forged, row.at, row.value);
    EXPECT_EQ(refusal_of(Channel::kBallbar, forged), row.reason)
        << "byte " << row.at << " value " << row.value;
  }
}

TEST(Decode, RefusesAnotherTypeOnTheChannel) {
  EXPECT_EQ(refusal_of(Channel::kJoints, bytes_of(test::mark_message(test::kEpochUs, 1, 1))),
            Refusal::kFingerprint);
}

TEST(Decode, RefusesSizesThatLcmCannotHaveReceived) {
  const std::vector<std::uint8_t> some(64, 0);
  Refusal reason{};
  EXPECT_FALSE(walk(Channel::kBallbar, {some.data(), 4'294'967'284u}, reason));
  EXPECT_EQ(reason, Refusal::kTooLarge);
}

TEST(Decode, RefusesNanAndInfinity) {
  for (const double bad : {std::nan(""), HUGE_VAL, -HUGE_VAL}) {
    EXPECT_EQ(refusal_of(Channel::kBallbar, bytes_of(test::bar_message(test::kEpochUs, 1, {1.0, bad}))),
              Refusal::kNotFinite);
    EXPECT_EQ(refusal_of(Channel::kBallbar, bytes_of(test::bar_message(test::kEpochUs, 1, {1.0, 2.0}, bad))),
              Refusal::kNotFinite);
    EXPECT_EQ(refusal_of(Channel::kJoints, bytes_of(test::joint_message(test::kEpochUs, 1, {bad}))),
              Refusal::kNotFinite);
    EXPECT_EQ(refusal_of(Channel::kInterferometer,
                         bytes_of(test::interferometer_message(test::kEpochUs, 1, bad, 0))),
              Refusal::kNotFinite);
    test_mark_t mark = test::mark_message(test::kEpochUs, 1, 1);
    mark.feed_mm_s = bad;
    EXPECT_EQ(refusal_of(Channel::kTestMark, bytes_of(mark)), Refusal::kNotFinite);
  }
}

TEST(Decode, RefusesValuesThatCannotBe) {
  EXPECT_EQ(refusal_of(Channel::kTestMark, bytes_of(test::mark_message(test::kEpochUs, 1, 5))),
            Refusal::kValue);
  EXPECT_EQ(refusal_of(Channel::kTestMark, bytes_of(test::mark_message(test::kEpochUs, 1, 1, "A", 2))),
            Refusal::kValue);
  EXPECT_EQ(refusal_of(Channel::kTestMark, bytes_of(test::mark_message(-1, 1, 1))), Refusal::kValue);
  EXPECT_EQ(refusal_of(Channel::kBallbar, bytes_of(test::bar_message(test::kEpochUs, 1, {}))),
            Refusal::kValue);
  EXPECT_EQ(refusal_of(Channel::kBallbar, bytes_of(test::bar_message(test::kEpochUs, 1, {1, 2}, 0.0))),
            Refusal::kValue);
  EXPECT_EQ(refusal_of(Channel::kBallbar, bytes_of(test::bar_message(test::kEpochUs, 1, {1, 2}, 31e6))),
            Refusal::kValue);
  EXPECT_EQ(refusal_of(Channel::kInterferometer,
                       bytes_of(test::interferometer_message(test::kEpochUs, 1, 0, 0, "Q"))),
            Refusal::kValue);
  joint_samples_t joints = test::joint_message(test::kEpochUs, 1, {0.1, 0.2});
  joints.torque_count = 1;
  joints.torque_nm = {1.0};
  EXPECT_EQ(refusal_of(Channel::kJoints, bytes_of(joints)), Refusal::kValue);
  // Finite, but J2 + J3 is not, and a FANUC's chain is made of that sum.
  for (const double angle : {1.7e308, -1.7e308, 1.1e6})
    EXPECT_EQ(
        refusal_of(Channel::kJoints, bytes_of(test::joint_message(test::kEpochUs, 1, {0.1, angle, angle}))),
        Refusal::kValue)
        << angle;
}

TEST(Decode, MakesAFreeLabelPrintable) {
  const std::pair<std::string, std::string> table[] = {{"before-calibration", "before-calibration"},
                                                       {"nach \xC3\x9C"
                                                        "bergabe",
                                                        "nach \xC3\x9C"
                                                        "bergabe"},
                                                       {"two\nlines\t", "two?lines?"},
                                                       {"\xFF\xFE", "??"},
                                                       {"cut \xC3", "cut ?"},
                                                       {"\xED\xA0\x80", "???"},
                                                       {"\xF0\x9F\x99\x82", "\xF0\x9F\x99\x82"}};
  for (const auto& [sent, shown] : table) {
    test_mark_t mark = test::mark_message(test::kEpochUs, 1, 1);
    mark.series = sent;
    const Decoded decoded = decode(Channel::kTestMark, bytes_of(mark));
    EXPECT_EQ(std::get<TestMark>(std::get<Sample>(decoded)).series, shown);
  }
}

// Whatever a stranger changes in a message: no exception, no fault (this suite also runs under the
// sanitizers).
TEST(Decode, SurvivesRandomMutations) {
  const unsigned seed = 20260301;
  std::mt19937_64 random(seed);
  SCOPED_TRACE("seed " + std::to_string(seed));
  const std::vector<std::pair<Channel, std::vector<std::uint8_t>>> originals{
      {Channel::kBallbar, bytes_of(test::bar_message(test::kEpochUs, 1, std::vector<double>(20, 1.0)))},
      {Channel::kInterferometer, bytes_of(test::interferometer_message(test::kEpochUs, 1, 5.0, 1.0))},
      {Channel::kJoints, bytes_of(test::joint_message(test::kEpochUs, 1, {1, 2, 3, 4, 5, 6}))},
      {Channel::kTestMark, bytes_of(test::mark_message(test::kEpochUs, 1, 1))}};
  int believed = 0;
  int refused = 0;
  for (int round = 0; round < 200'000; ++round) {
    const auto& [channel, original] = originals[random() % originals.size()];
    std::vector<std::uint8_t> bytes = original;
    const int changes = 1 + static_cast<int>(random() % 4);
    for (int i = 0; i < changes; ++i) bytes[random() % bytes.size()] = static_cast<std::uint8_t>(random());
    if (random() % 8 == 0) bytes.resize(random() % (bytes.size() + 1));
    std::holds_alternative<Sample>(decode(channel, bytes)) ? ++believed : ++refused;
  }
  EXPECT_GT(refused, 50'000);   // the mutations do reach the checks,
  EXPECT_GT(believed, 10'000);  // and a changed sample alone is no reason to refuse
}

}  // namespace
}  // namespace ballbar
