#include "store/trace.hpp"

#include <gtest/gtest.h>
#include <zlib.h>

#include <cmath>
#include <limits>
#include <random>
#include <stdexcept>

namespace ballbar {
namespace {

using Bytes = std::vector<std::uint8_t>;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// Any shape that a run can have, drawn from a seed.
Trace random_trace(std::mt19937_64& rng) {
  const auto upto = [&rng](int n) { return std::uniform_int_distribution<int>(0, n)(rng); };
  std::uniform_real_distribution<double> unit(-1.0, 1.0);
  Trace t;
  const int bar = upto(60);
  for (int i = 0; i < bar; ++i) {
    t.bar_time.push_back(0.004 * i);
    t.bar_deviation.push_back(500e-6 * unit(rng));
  }
  if (upto(1) == 1)
    for (int i = 0; i < bar; ++i) t.angle.push_back(upto(4) == 0 ? kNan : -0.001 * i + 1e-7 * unit(rng));
  if (upto(1) == 1)
    for (int i = 0; i < bar; ++i) t.predicted.push_back(upto(4) == 0 ? kNan : 500e-6 * unit(rng));
  t.arc_begin = static_cast<std::size_t>(upto(bar));
  t.arc_end = t.arc_begin + static_cast<std::size_t>(upto(bar - static_cast<int>(t.arc_begin)));
  t.joints = upto(7);
  const bool torque = upto(1) == 1;
  const int rows = t.joints == 0 ? 0 : upto(40);
  for (int i = 0; i < rows; ++i) {
    t.joint_time.push_back(0.008 * i);
    for (int j = 0; j < t.joints; ++j) {
      t.joint_position.push_back(3.0 * unit(rng));
      if (torque) t.joint_torque.push_back(80.0 * unit(rng));
    }
  }
  const int readings = upto(30);
  for (int i = 0; i < readings; ++i)
    t.readings.push_back({"XYZ"[upto(2)], 0.1 * i, 0.0188 * i, 300e-6 * unit(rng)});
  return t;
}

void expect_near(const std::vector<double>& a, const std::vector<double>& b, double step) {
  ASSERT_EQ(a.size(), b.size());
  for (std::size_t i = 0; i < a.size(); ++i) {
    if (std::isnan(b[i])) {
      EXPECT_TRUE(std::isnan(a[i]));
    } else {
      EXPECT_NEAR(a[i], b[i], 0.5001 * step)
          << "at " << i;  // half a step, and the rounding of the test's own numbers
    }
  }
}

void expect_near(const Trace& a, const Trace& b) {
  expect_near(a.bar_time, b.bar_time, 1e-6);
  expect_near(a.bar_deviation, b.bar_deviation, 1e-9);
  expect_near(a.angle, b.angle, 1e-9);
  expect_near(a.predicted, b.predicted, 1e-9);
  EXPECT_EQ(a.arc_begin, b.arc_begin);
  EXPECT_EQ(a.arc_end, b.arc_end);
  EXPECT_EQ(a.joints, b.joints);
  expect_near(a.joint_time, b.joint_time, 1e-6);
  expect_near(a.joint_position, b.joint_position, 1e-9);
  expect_near(a.joint_torque, b.joint_torque, 1e-3);
  ASSERT_EQ(a.readings.size(), b.readings.size());
  for (std::size_t i = 0; i < a.readings.size(); ++i) {
    EXPECT_EQ(a.readings[i].axis, b.readings[i].axis);
    EXPECT_NEAR(a.readings[i].time, b.readings[i].time, 0.5001e-6);
    EXPECT_NEAR(a.readings[i].position, b.readings[i].position, 0.5001e-9);
    EXPECT_NEAR(a.readings[i].deviation, b.readings[i].deviation, 0.5001e-9);
  }
}

TEST(Trace, ComesBackToHalfAStepWhateverItsShape) {
  for (unsigned seed = 0; seed < 300; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 rng(seed);
    const Trace t = random_trace(rng);
    const Bytes bytes = encode(t);
    const Trace back = decode(kTraceCoding, bytes);
    expect_near(back, t);
    EXPECT_EQ(encode(back), bytes);  // rounding happens once
  }
}

TEST(Trace, KeepsEveryAngleThatIsNotKnown) {
  Trace t;
  t.bar_time = t.bar_deviation = {0.0, 0.001, 0.002, 0.003};
  t.angle = {kNan, kNan, 1.25, kNan};
  const Trace back = decode(kTraceCoding, encode(t));
  EXPECT_TRUE(std::isnan(back.angle[0]) && std::isnan(back.angle[1]) && std::isnan(back.angle[3]));
  EXPECT_EQ(back.angle[2], 1.25);
}

TEST(Trace, KeepsNumbersThatAreTooLargeForStepsExactly) {
  Trace t;
  t.bar_time = {0.0, 1.0, 2.0, 3.0, 4.0};
  t.bar_deviation = {1e300, -HUGE_VAL, 0.1, kNan, -1e-300};
  const Trace back = decode(kTraceCoding, encode(t));
  for (const std::size_t i : {0, 1, 2, 4}) EXPECT_EQ(back.bar_deviation[i], t.bar_deviation[i]);
  EXPECT_TRUE(std::isnan(back.bar_deviation[3]));
}

TEST(Trace, ComesBackAtTheVeryEndOfTheSteps) {
  Trace t;
  const double largest = 9007199254740991.0 / 1e9;  // 2^53 - 1 steps: second differences reach 2^55
  for (int i = 0; i < 9; ++i) {
    t.bar_time.push_back(i);
    t.bar_deviation.push_back(i % 2 == 0 ? largest : -largest);
  }
  EXPECT_EQ(decode(kTraceCoding, encode(t)).bar_deviation, t.bar_deviation);
}

TEST(Trace, RefusesColumnsThatDoNotBelongTogether) {
  const auto refused = [](auto change) {
    Trace t;
    t.bar_time = t.bar_deviation = {0.0, 1.0};
    t.joints = 2;
    t.joint_time = {0.0};
    t.joint_position = {0.1, 0.2};
    EXPECT_NO_THROW(encode(t));
    change(t);
    EXPECT_THROW(encode(t), std::invalid_argument);
  };
  refused([](Trace& t) { t.bar_deviation.pop_back(); });
  refused([](Trace& t) { t.angle = {0.0}; });
  refused([](Trace& t) { t.predicted = {0.0}; });
  refused([](Trace& t) { t.arc_end = 3; });
  refused([](Trace& t) { t.arc_begin = 1; });
  refused([](Trace& t) { t.joint_position.pop_back(); });
  refused([](Trace& t) { t.joint_torque = {0.0}; });
  refused([](Trace& t) { t.joints = -2; });
  refused([](Trace& t) { t.joints = 0; });
  refused([](Trace& t) { t.readings.resize(kMaxTraceValues / 4 + 1); });
}

TEST(Trace, RefusesAnUnknownCoding) {
  EXPECT_THROW(decode(kTraceCoding + 1, encode(Trace{})), std::runtime_error);
}

/// Decodes; damage must be told, or have changed nothing.
void expect_told_or_same(const Bytes& damaged, const Bytes& good) {
  try {
    EXPECT_EQ(encode(decode(kTraceCoding, damaged)), good);
  } catch (const std::runtime_error&) {
  }
}

/// The packed form, and back: damage that has a right checksum.
Bytes inflate(const Bytes& bytes) {
  Bytes packed(bytes[0] + 256u * bytes[1] + 65536u * bytes[2]);
  uLongf size = packed.size();
  EXPECT_EQ(uncompress(packed.data(), &size, bytes.data() + 4, bytes.size() - 4), Z_OK);
  return packed;
}
Bytes deflate(const Bytes& packed) {
  Bytes bytes(4 + compressBound(packed.size()));
  for (unsigned i = 0; i < 4; ++i) bytes[i] = static_cast<std::uint8_t>(packed.size() >> (8 * i));
  uLongf size = bytes.size() - 4;
  EXPECT_EQ(compress(bytes.data() + 4, &size, packed.data(), packed.size()), Z_OK);
  bytes.resize(4 + size);
  return bytes;
}

/// As version 0.1 wrote it, by the words of docs/database.md: two bar samples, their angles, no joints.
TEST(Trace, ReadsWhatWasStoredBeforeThereWerePredictions) {
  const auto zigzag = [](int v) { return static_cast<std::uint8_t>(1 + (v < 0 ? -2 * v - 1 : 2 * v)); };
  const Bytes packed{2, 2,          0,          2, 0, 0, 0, 0,  // counts
                     0, zigzag(0),  zigzag(40),                 // time: 0 and 40 us
                     0, zigzag(5),  zigzag(-7),                 // deviation: 5 and -7 nm
                     1, zigzag(10), zigzag(-3)};                // angle: 10e-9 and 7e-9 rad, as differences
  const Trace t = decode(1, deflate(packed));
  EXPECT_EQ(t.bar_time, (std::vector<double>{0.0, 40e-6}));
  EXPECT_EQ(t.bar_deviation, (std::vector<double>{5e-9, -7e-9}));
  EXPECT_EQ(t.angle, (std::vector<double>{10e-9, 7e-9}));
  EXPECT_EQ(t.arc_end, 2u);
  EXPECT_TRUE(t.predicted.empty());
}

TEST(Trace, TellsThatItIsCutWhereverItIsCut) {
  std::mt19937_64 rng(5);
  const Bytes good = encode(random_trace(rng));
  for (std::size_t size = 0; size < good.size(); ++size) {
    const Bytes cut(good.begin(), good.begin() + static_cast<std::ptrdiff_t>(size));
    EXPECT_THROW(decode(kTraceCoding, cut), std::runtime_error) << size;
  }
  Bytes longer = good;
  longer.push_back(0);
  EXPECT_THROW(decode(kTraceCoding, longer), std::runtime_error);
}

TEST(Trace, TellsDamageOfTheBytes) {
  for (unsigned seed = 0; seed < 20'000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 rng(seed);
    std::mt19937_64 shape(seed % 10);
    const Bytes good = encode(random_trace(shape));
    Bytes bad = good;
    for (unsigned n = 0; n <= seed % 3; ++n) bad[rng() % bad.size()] = static_cast<std::uint8_t>(rng());
    expect_told_or_same(bad, good);
  }
}

TEST(Trace, StaysWithinItsBytesWhateverThePackedFormSays) {
  int told = 0;
  for (unsigned seed = 0; seed < 20'000; ++seed) {
    SCOPED_TRACE("seed " + std::to_string(seed));
    std::mt19937_64 rng(seed);
    std::mt19937_64 shape(seed % 10);
    Bytes packed = inflate(encode(random_trace(shape)));
    for (unsigned n = 0; n <= seed % 4; ++n) {
      const std::size_t among = seed % 2 == 0 ? std::min<std::size_t>(12, packed.size()) : packed.size();
      packed[rng() % among] = static_cast<std::uint8_t>(rng());
    }
    if (seed % 5 == 0) packed.resize(rng() % (packed.size() + 1));
    try {
      const Trace t = decode(kTraceCoding, deflate(packed));
      EXPECT_NO_THROW(encode(t));  // what is let through is whole
    } catch (const std::runtime_error&) {
      ++told;
    }
  }
  EXPECT_GT(told, 1000);  // the damage did reach the checks
}

TEST(Trace, DoesNotAllocateForCountsThatTheBytesCannotHold) {
  // 16 million bar samples, said in 8 bytes of counts: an error, not 128 MB.
  const Bytes packed = {0x80, 0x80, 0x80, 0x07, 0, 0, 0, 0, 0, 0, 0};
  EXPECT_THROW(decode(kTraceCoding, deflate(packed)), std::runtime_error);
  Bytes large_claim = deflate(packed);
  large_claim[3] = 0x7f;  // 2 GB unpacked
  EXPECT_THROW(decode(kTraceCoding, large_claim), std::runtime_error);
}

}  // namespace
}  // namespace ballbar
