#include "bus/decode.hpp"

#include <ballbar/ballbar_samples_t.hpp>
#include <ballbar/interferometer_samples_t.hpp>
#include <ballbar/joint_samples_t.hpp>
#include <ballbar/test_mark_t.hpp>
#include <cmath>

#include "core/units.hpp"

namespace ballbar {
namespace {

constexpr double kLongestBlockUs = 60e6;  // of one BALLBAR message
constexpr double kLargestAngle = 1e6;     // [rad] no joint turns so far; sums of these are finite

/// Big-endian reader that stops at the first thing that cannot be.
class Walker {
 public:
  explicit Walker(std::span<const std::uint8_t> bytes) : bytes_(bytes) {}

  void skip(std::size_t n) {
    if (failed_) return;
    if (n > bytes_.size() - at_) return fail(Refusal::kTruncated);
    at_ += n;
  }
  std::uint64_t number(std::size_t size) {
    const std::size_t from = at_;
    skip(size);
    std::uint64_t value = 0;
    if (!failed_)
      for (std::size_t i = from; i < at_; ++i) value = value << 8 | bytes_[i];
    return value;
  }
  void fingerprint(std::int64_t hash) {
    if (number(8) != static_cast<std::uint64_t>(hash)) fail(Refusal::kFingerprint);
  }
  void string() {
    const auto length = static_cast<std::int32_t>(number(4));
    if (failed_) return;
    if (length < 1 || length > kMaxNameBytes) return fail(Refusal::kString);
    skip(static_cast<std::size_t>(length));
    if (!failed_ && bytes_[at_ - 1] != 0) fail(Refusal::kString);
  }
  std::size_t count(int most) {
    const auto value = static_cast<std::int32_t>(number(4));
    if (failed_) return 0;
    if (value < 0 || value > most) {
      fail(Refusal::kCount);
      return 0;
    }
    return static_cast<std::size_t>(value);
  }
  void header() {
    skip(16);
    string();
  }
  /// True if all of the bytes were walked and nothing failed.
  bool end() {
    if (at_ != bytes_.size()) fail(Refusal::kTruncated);
    return !failed_;
  }
  Refusal reason() const { return reason_; }

 private:
  void fail(Refusal reason) {
    if (!failed_) reason_ = reason;
    failed_ = true;
  }

  std::span<const std::uint8_t> bytes_;
  std::size_t at_ = 0;
  bool failed_ = false;
  Refusal reason_ = Refusal::kTruncated;
};

void walk_fields(Channel channel, Walker& walker) {
  switch (channel) {
    case Channel::kBallbar:
      walker.fingerprint(ballbar_samples_t::getHash());
      walker.header();
      walker.skip(8);
      walker.skip(sizeof(double) * walker.count(kMaxBlock));
      break;
    case Channel::kInterferometer:
      walker.fingerprint(interferometer_samples_t::getHash());
      walker.header();
      walker.string();
      walker.skip(2 * sizeof(double) * walker.count(kMaxBlock));
      break;
    case Channel::kJoints:
      walker.fingerprint(joint_samples_t::getHash());
      walker.header();
      walker.skip(sizeof(double) * walker.count(kMaxJoints));
      walker.skip(sizeof(double) * walker.count(kMaxJoints));
      break;
    case Channel::kTestMark:
      walker.fingerprint(test_mark_t::getHash());
      walker.header();
      walker.string();
      walker.skip(1 + 1 + 4);
      walker.string();
      walker.skip(3 * sizeof(double));
      break;
  }
}

bool all_finite(const std::vector<double>& values) {
  for (const double v : values)
    if (!std::isfinite(v)) return false;
  return true;
}

std::vector<double> scaled(const std::vector<double>& values, double factor) {
  std::vector<double> out(values);
  for (double& v : out) v *= factor;
  return out;
}

Decoded convert(const ballbar_samples_t& m, SampleHeader header) {
  if (!std::isfinite(m.period_us) || !all_finite(m.deviation_um)) return Refusal::kNotFinite;
  const bool spaced = m.period_us > 0.0 || (m.period_us == 0.0 && m.count == 1);
  if (!spaced || m.count < 1 || m.period_us * m.count > kLongestBlockUs) return Refusal::kValue;
  return BallbarBlock{std::move(header), m.period_us * kSecondsPerUs, scaled(m.deviation_um, kMetresPerUm)};
}

Decoded convert(const interferometer_samples_t& m, SampleHeader header) {
  if (!all_finite(m.position_mm) || !all_finite(m.deviation_um)) return Refusal::kNotFinite;
  if (m.count < 1 || (m.axis != "X" && m.axis != "Y" && m.axis != "Z")) return Refusal::kValue;
  return InterferometerBlock{std::move(header), m.axis[0], scaled(m.position_mm, kMetresPerMm),
                             scaled(m.deviation_um, kMetresPerUm)};
}

Decoded convert(const joint_samples_t& m, SampleHeader header) {
  if (!all_finite(m.position_rad) || !all_finite(m.torque_nm)) return Refusal::kNotFinite;
  if (m.joints < 1 || (m.torque_count != 0 && m.torque_count != m.joints)) return Refusal::kValue;
  for (const double angle : m.position_rad)
    if (std::abs(angle) > kLargestAngle) return Refusal::kValue;
  return JointSample{std::move(header), m.position_rad, m.torque_nm};
}

Decoded convert(const test_mark_t& m, SampleHeader header) {
  if (!std::isfinite(m.feed_mm_s) || !std::isfinite(m.payload_kg) || std::isinf(m.temperature_c))
    return Refusal::kNotFinite;
  const bool known = m.mark >= 1 && m.mark <= 4 && m.direction >= -1 && m.direction <= 1;
  if (!known || m.feed_mm_s < 0.0 || m.payload_kg < 0.0) return Refusal::kValue;
  TestMark mark{std::move(header),
                m.test,
                static_cast<Mark>(m.mark),
                m.direction,
                m.repetition,
                printable(m.series),
                m.feed_mm_s * kMetresPerMm,
                m.payload_kg,
                {}};
  if (!std::isnan(m.temperature_c)) mark.temperature = m.temperature_c;
  return mark;
}

template <typename Message>
Decoded decode_as(std::span<const std::uint8_t> bytes) {
  Message message;  // fresh: a reused object would keep the arrays of the message before
  const int size = static_cast<int>(bytes.size());
  if (message.decode(bytes.data(), 0, size) != size) return Refusal::kTruncated;
  if (message.time_us <= 0 || message.time_us > kLatestTimeUs) return Refusal::kValue;
  return convert(message, SampleHeader{message.time_us, message.seq, message.robot});
}

}  // namespace

std::string printable(const std::string& text) {
  std::string out;
  for (std::size_t i = 0; i < text.size();) {
    const auto c = static_cast<unsigned char>(text[i]);
    const std::size_t length = c < 0x80                ? 1
                               : c >= 0xC2 && c < 0xE0 ? 2
                               : c >= 0xE0 && c < 0xF0 ? 3
                               : c >= 0xF0 && c < 0xF5 ? 4
                                                       : 0;
    bool good = length > 0 && i + length <= text.size() && c >= 0x20 && c != 0x7F;
    for (std::size_t k = 1; good && k < length; ++k)
      good = (static_cast<unsigned char>(text[i + k]) & 0xC0) == 0x80;
    if (good && length == 3) {  // neither overlong nor a surrogate
      const auto second = static_cast<unsigned char>(text[i + 1]);
      good = !(c == 0xE0 && second < 0xA0) && !(c == 0xED && second >= 0xA0);
    }
    if (good && length == 4) {
      const auto second = static_cast<unsigned char>(text[i + 1]);
      good = !(c == 0xF0 && second < 0x90) && !(c == 0xF4 && second >= 0x90);
    }
    out += good ? text.substr(i, length) : "?";
    i += good ? length : 1;
  }
  return out;
}

bool walk(Channel channel, std::span<const std::uint8_t> bytes, Refusal& reason) {
  if (bytes.size() > kMaxMessageBytes) {
    reason = Refusal::kTooLarge;
    return false;
  }
  Walker walker(bytes);
  walk_fields(channel, walker);
  const bool good = walker.end();
  if (!good) reason = walker.reason();
  return good;
}

Decoded decode(Channel channel, std::span<const std::uint8_t> bytes) {
  Refusal reason{};
  if (!walk(channel, bytes, reason)) return reason;
  try {
    switch (channel) {
      case Channel::kBallbar:
        return decode_as<ballbar_samples_t>(bytes);
      case Channel::kInterferometer:
        return decode_as<interferometer_samples_t>(bytes);
      case Channel::kJoints:
        return decode_as<joint_samples_t>(bytes);
      case Channel::kTestMark:
        return decode_as<test_mark_t>(bytes);
    }
  } catch (const std::exception&) {
    return Refusal::kTruncated;  // the walk should have seen it; no exception may leave a handler
  }
  return Refusal::kValue;
}

}  // namespace ballbar
