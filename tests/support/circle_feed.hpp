#pragma once
/// A cell that drives one circle after the other, as fast as one likes: what its instruments send.

#include <cstdint>
#include <functional>
#include <lcm/lcm-cpp.hpp>
#include <string>
#include <vector>

#include "bus/encode.hpp"
#include "core/samples.hpp"
#include "support/messages.hpp"
#include "support/planar_cell.hpp"
#include "support/private_network.hpp"
#include "support/process.hpp"

namespace ballbar::test {

/// The [[robot]] part of a configuration. Its URDF is written into `folder`.
inline std::string planar_robot(const std::string& folder, const std::string& name = "planar") {
  write_file(folder + "/planar.urdf", kPlanarUrdf);
  return "[[robot]]\nname = \"" + name + "\"\nurdf = \"" + folder +
         "/planar.urdf\"\nbase = \"base\"\ntip = \"tcp\"\n"
         "[[robot.test]]\nname = \"A\"\nkind = \"circle\"\ncentre_mm = [450, 100, 0]\nradius_mm = 100\n"
         "overshoot_deg = 60\nfeed_mm_s = 50\n";
}

class CircleFeed {
 public:
  static constexpr std::int64_t kEveryUs = 30'000'000;  ///< of the producer's clock

  /// @param bar_hz,joint_hz  of the circle of 16.8 s
  explicit CircleFeed(double bar_hz = 25.0, double joint_hz = 12.5, std::string robot = "planar")
      : robot_(std::move(robot)) {
    PlanarCircle circle;
    circle.bar_period = 1.0 / bar_hz;
    circle.joint_period = 1.0 / joint_hz;
    circle.shape = [](double angle) { return 20e-6 * std::cos(2.0 * angle); };
    circle.noise = [](int i) { return 1e-6 * std::sin(12.9898 * i * i); };
    run_ = planar_run(circle);
    bar_period_ = circle.bar_period;
  }

  static std::int64_t started_us(std::int64_t number) { return kEpochUs + number * kEveryUs; }

  /// All of circle `number`, in the sequence of time; seq goes on from the circle before.
  std::vector<Sample> samples(std::int64_t number) {
    const std::int64_t start = started_us(number);
    std::vector<Sample> out{mark(Mark::kBegin, start, number)};
    std::size_t bar = 0;
    for (std::size_t j = 0; j < run_.joint_time.size(); ++j) {
      while (bar < run_.bar_time.size() && run_.bar_time[bar] <= run_.joint_time[j]) {
        const std::size_t end = std::min(bar + kBlock, run_.bar_time.size());
        out.emplace_back(BallbarBlock{
            {start + us(run_.bar_time[bar]), ++bar_seq_, robot_},
            bar_period_,
            {run_.bar_deviation.begin() + signed_of(bar), run_.bar_deviation.begin() + signed_of(end)}});
        bar = end;
      }
      out.emplace_back(JointSample{{start + us(run_.joint_time[j]), ++joint_seq_, robot_},
                                   {run_.joint_position.begin() + signed_of(2 * j),
                                    run_.joint_position.begin() + signed_of(2 * j + 2)},
                                   {}});
    }
    out.push_back(mark(Mark::kEnd, start + run_.ended_us - run_.started_us, number));
    return out;
  }

  /// Over real sockets, no faster than they are read.
  /// @param pause_us  after each message
  void send(lcm::LCM& lcm, std::int64_t number, unsigned pause_us = 0) {
    send(lcm, number, [pause_us] {
      if (pause_us > 0) usleep(pause_us);
    });
  }
  /// @param between  is done after each message
  void send(lcm::LCM& lcm, std::int64_t number, const std::function<void()>& between) {
    constexpr std::int64_t kRoom = 100'000;  // a quarter of what Debian gives a socket
    int sent = 0;
    for (const Sample& sample : samples(number)) {
      const Encoded e = encode(sample);
      lcm.publish(channel_name(e.channel), e.bytes.data(), static_cast<unsigned>(e.bytes.size()));
      between();
      if (++sent % 16 == 0) wait_for_readers(kRoom);
    }
  }

 private:
  static constexpr std::size_t kBlock = 50;
  static std::int64_t us(double seconds) { return std::llround(seconds * 1e6); }
  static std::ptrdiff_t signed_of(std::size_t n) { return static_cast<std::ptrdiff_t>(n); }
  Sample mark(Mark mark, std::int64_t time_us, std::int64_t number) {
    return TestMark{{time_us, ++mark_seq_, robot_},
                    "A",
                    mark,
                    1,
                    static_cast<int>(number % 1'000'000),
                    "s",
                    0.05,
                    0.5,
                    {}};
  }

  std::string robot_;
  Run run_;
  double bar_period_ = 0.0;
  std::int64_t bar_seq_ = 0, joint_seq_ = 0, mark_seq_ = 0;
};

}  // namespace ballbar::test
