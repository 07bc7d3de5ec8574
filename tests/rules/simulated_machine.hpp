#pragma once
/// An LR Mate that drives circle A both ways, several times a day, and wears: simulated, assembled and
/// analysed as a real one would be.

#include <array>
#include <cmath>
#include <fstream>
#include <numbers>
#include <random>
#include <sstream>
#include <string>
#include <utility>
#include <vector>

#include "bus/assembler.hpp"
#include "gap/simulate.hpp"
#include "pipeline/catalogue.hpp"
#include "pipeline/circle_test.hpp"
#include "pipeline/process.hpp"
#include "rules/subjects.hpp"

namespace ballbar::test {

inline constexpr std::int64_t kFourHoursUs = 14'400'000'000;

/// What has become of the robot since it was commissioned.
struct Wear {
  std::array<double, 6> zero_deg{};  ///< of each joint
  double play_deg = 0.0;             ///< of joint 2, beyond what it had
  double payload_kg = 0.438;         ///< on the flange
  double said_payload_kg = 0.438;    ///< by the marks
};

class SimulatedMachine {
 public:
  /// @param scatter     0: no noise and no scatter from run to run
  /// @param directions  that it drives, each time
  explicit SimulatedMachine(unsigned seed, double scatter = 1.0, std::vector<int> directions = {1, -1})
      : seed_(seed),
        scatter_(scatter),
        directions_(std::move(directions)),
        spec_(robot()),
        model_(urdf(), "base", "tcp", JointConvention::kFanuc),
        known_(model_, spec_) {}

  /// What one repetition lets the rules judge.
  std::vector<Record> subjects(int run, const Wear& wear) {
    RobotSpec worn = spec_;
    worn.tests.front().payload = wear.payload_kg;
    std::mt19937_64 rng(std::uint64_t{seed_} * 1'000'003 + static_cast<std::uint64_t>(run));
    std::normal_distribution<double> draw;
    // From run to run each joint settles a little elsewhere, as gears and warmth have it.
    constexpr double kSettlesDeg = 0.0005;
    for (int joint = 1; joint <= 6; ++joint)
      worn.effects.push_back({"joint_zero_offset",
                              joint,
                              {{"offset_deg", wear.zero_deg[static_cast<std::size_t>(joint - 1)] +
                                                  scatter_ * kSettlesDeg * draw(rng)}},
                              {}});
    constexpr double kPlayScattersDeg = 0.0002;
    worn.effects[kPlay] = lost_motion(kPlayDeg + wear.play_deg + scatter_ * kPlayScattersDeg * draw(rng));
    SimulateOptions options;
    options.noise = scatter_ * 0.6e-6;
    options.seed = std::uint64_t{seed_} * 1'000'003 + static_cast<std::uint64_t>(run);
    options.series = "years";
    options.directions = directions_;
    options.start_us += run * kFourHoursUs;
    std::vector<Record> found;
    Partners other_way;
    simulate(AsBuilt(model_, worn), worn, options, [&](const SimulatedRun& simulated) {
      Run measured = assembled(simulated);
      measured.payload = wear.said_payload_kg;
      const RunResult result = process(measured, spec_.tests.front(), &known_, other_way);
      other_way.circle = measured_arc(result.angle, measured.bar_deviation, result.arc_begin, result.arc_end);
      other_way.circle->direction = result.direction;
      other_way.circle->feed = measured.feed;
      for (const Record& record : records(measured, result))
        for (Record& subject : subjects_of(with_harmonics(record, result)))
          found.push_back(std::move(subject));
    });
    return found;
  }

 private:
  static std::string urdf() {
    std::ifstream file(BALLBAR_SOURCE_DIR "/scripts/robots/lrmate200ic.urdf");
    std::ostringstream text;
    text << file.rdbuf();
    return text.str();
  }

  static constexpr std::size_t kPlay = 2;  // of the effects
  static constexpr double kPlayDeg = 0.004;

  static EffectSpec lost_motion(double width_deg) {
    return {"joint_lost_motion", 2, {{"width_deg", width_deg}}, {{"kind", "friction_windup"}}};
  }

  static RobotSpec robot() {
    RobotSpec spec;
    spec.name = "lrmate-1";
    spec.joint_convention = JointConvention::kFanuc;
    spec.payload_com = {0, 0, 0.050};
    spec.effects = {{"joint_compliance", 2, {{"compliance_rad_per_nm", 4e-5}}, {}},
                    {"joint_compliance", 3, {{"compliance_rad_per_nm", 6e-5}}, {}},
                    lost_motion(kPlayDeg)};
    TestSpec& test = spec.tests.emplace_back();
    test.name = "A";
    test.circle.centre = {0.380, -0.320, -0.251};
    test.circle.radius = 0.1;
    test.circle.arc_sweep = 2.0 * std::numbers::pi;
    test.circle.overshoot = std::numbers::pi / 3.0;
    test.feed = 0.3;  // quick, for thousands of them
    test.tool_rpy = Vec3{std::numbers::pi, 0.0, 0.0};
    test.payload = 0.438;
    return spec;
  }

  Run assembled(const SimulatedRun& simulated) const {
    Assembler assembler({spec_});
    std::vector<Run> finished;
    for (const Sample& sample : simulated.samples) assembler.take(sample, sent_us(sample), finished);
    assembler.close_all(RunEnd::kSilence, finished);
    return std::move(finished.at(0));
  }

  unsigned seed_;
  double scatter_;
  std::vector<int> directions_;
  RobotSpec spec_;
  RobotModel model_;
  AsBuilt known_;
};

}  // namespace ballbar::test
