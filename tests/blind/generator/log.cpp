#include "log.hpp"

#include <algorithm>
#include <ballbar/ballbar_samples_t.hpp>
#include <ballbar/joint_samples_t.hpp>
#include <ballbar/test_mark_t.hpp>
#include <cmath>
#include <cstdint>
#include <fstream>
#include <limits>
#include <stdexcept>

namespace blind {
namespace {

constexpr double kMarkUs = 20'000;      // between a mark and the samples
constexpr std::int64_t kSendUs = 1000;  // joints: from the sample to the log
constexpr std::size_t kBlock = 50;
const char* const kRobot = "lrmate-1";

struct Event {
  std::int64_t time_us;
  std::string channel;
  std::vector<std::uint8_t> data;
};

template <typename Message>
Event event(std::int64_t time_us, std::string channel, const Message& message) {
  Event e{time_us, std::move(channel),
          std::vector<std::uint8_t>(static_cast<std::size_t>(message.getEncodedSize()))};
  message.encode(e.data.data(), 0, static_cast<int>(e.data.size()));
  return e;
}

void big_endian(std::string& out, std::uint64_t value, int bytes) {
  for (int i = bytes - 1; i >= 0; --i) out.push_back(static_cast<char>(value >> (8 * i) & 0xFFU));
}

std::int64_t whole(double us) { return static_cast<std::int64_t>(std::llround(us)); }

struct Numbers {
  std::int64_t mark, joints, bar;
};

std::vector<Event> events(const Recorded& r, const Plan& plan, const std::string& series, double begin_us,
                          bool fanuc, Numbers& next) {
  const Test& test = plan.tests[static_cast<std::size_t>(r.of.test)];
  const double period_us = 1e6 * sampling(test).bar_period;
  const double first_us = begin_us + 60e6 * r.of.minute;
  std::vector<Event> all;
  const auto mark = [&](std::int8_t which, double time_us) {
    ballbar::test_mark_t m{};
    m.time_us = whole(time_us);
    m.seq = next.mark++;
    m.robot = kRobot;
    m.test = test.name;
    m.mark = which;
    m.direction = static_cast<std::int8_t>(r.of.direction);
    m.repetition = r.of.repetition;
    m.series = series + (r.of.held_out ? "-held-out" : "");
    m.feed_mm_s = test.feed_mm_s;
    m.payload_kg = test.payload_kg;
    m.temperature_c = std::numeric_limits<double>::quiet_NaN();
    all.push_back(event(m.time_us, "TEST_MARK", m));
  };
  mark(1, first_us - kMarkUs);
  for (std::size_t i = 0; i < r.joints.size(); i += 4) {
    ballbar::joint_samples_t m{};
    m.time_us = whole(first_us + period_us * static_cast<double>(i));
    m.seq = next.joints++;
    m.robot = kRobot;
    m.joints = 6;
    m.position_rad.assign(r.joints[i].begin(), r.joints[i].end());
    if (fanuc) m.position_rad[2] -= m.position_rad[1];
    all.push_back(event(m.time_us + kSendUs, "JOINTS", m));
  }
  for (std::size_t i = 0; i < r.deviation_um.size(); i += kBlock) {
    const std::size_t count = std::min(kBlock, r.deviation_um.size() - i);
    ballbar::ballbar_samples_t m{};
    m.time_us = whole(first_us + period_us * static_cast<double>(i));
    m.seq = next.bar++;
    m.robot = kRobot;
    m.period_us = period_us;
    m.count = static_cast<std::int32_t>(count);
    const auto from = r.deviation_um.begin() + static_cast<std::ptrdiff_t>(i);
    m.deviation_um.assign(from, from + static_cast<std::ptrdiff_t>(count));
    all.push_back(
        event(m.time_us + whole(period_us * static_cast<double>(count - 1)) + kSendUs, "BALLBAR", m));
  }
  mark(2, first_us + period_us * static_cast<double>(r.deviation_um.size() - 1) + kMarkUs);
  std::stable_sort(all.begin(), all.end(),
                   [](const Event& a, const Event& b) { return a.time_us < b.time_us; });
  return all;
}

}  // namespace

void write_log(const std::filesystem::path& file, const Plan& plan, const std::vector<Recorded>& recorded,
               const std::string& series, double begin_us, bool fanuc, int first_number) {
  Numbers next{first_number, 2 * first_number, 3 * first_number};
  std::string out;
  std::uint64_t number = 0;
  for (const Recorded& r : recorded)
    for (const Event& e : events(r, plan, series, begin_us, fanuc, next)) {
      big_endian(out, 0xEDA1DA01U, 4);
      big_endian(out, number++, 8);
      big_endian(out, static_cast<std::uint64_t>(e.time_us), 8);
      big_endian(out, e.channel.size(), 4);
      big_endian(out, e.data.size(), 4);
      out += e.channel;
      out.append(reinterpret_cast<const char*>(e.data.data()), e.data.size());
    }
  std::ofstream stream(file, std::ios::binary);
  stream << out;
  if (!stream.flush()) throw std::runtime_error("cannot write " + file.string());
}

}  // namespace blind
