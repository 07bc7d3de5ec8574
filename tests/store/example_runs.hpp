#pragma once
/// Runs with made-up figures, as the pipeline would hand them to the store.

#include <cmath>
#include <cstdint>
#include <random>
#include <string>
#include <vector>

#include "core/alarm.hpp"
#include "core/result.hpp"
#include "core/run.hpp"

namespace ballbar::test {

/// What save() takes.
struct Saved {
  Run run;
  RunResult result;
  std::vector<Record> records;
};

inline Record labels_of(const Saved& s, const std::string& axis = "") {
  Record r;
  r.robot = s.run.robot;
  r.test = s.run.test;
  r.kind = s.run.kind == TestKind::kCircle ? "circle" : "line";
  r.series = s.run.series;
  r.axis = axis;
  r.status = s.result.status;
  r.angle_source = s.result.angle_source;
  r.source = s.result.source;
  r.plane = s.result.plane;
  r.predicted_from = s.result.predicted_from;
  r.direction = s.run.direction;
  r.repetition = s.run.repetition;
  r.started_us = s.run.started_us;
  return r;
}

inline constexpr std::int64_t kDay = 1773219599980000;  // us: a morning in March 2026

/// A circle with twelve seconds of bar and joints, six orders and a few figures, all different for each seed.
inline Saved circle(std::int64_t started_us = kDay, unsigned seed = 1) {
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> um(-200e-6, 200e-6);
  Saved s;
  s.run.robot = "lrmate-1";
  s.run.test = "A";
  s.run.direction = 1;
  s.run.repetition = 1;
  s.run.series = "before";
  s.run.started_us = started_us;
  s.run.ended_us = started_us + 12'000'000;
  s.run.feed = 0.05533;
  s.run.payload = 0.438;
  s.run.temperature = 22.5;
  for (int i = 0; i < 300; ++i) {
    s.run.bar_time.push_back(i * 0.04);
    s.run.bar_deviation.push_back(um(rng));
  }
  s.run.joints = 6;
  for (int i = 0; i < 150; ++i) {
    s.run.joint_time.push_back(i * 0.08);
    for (int j = 0; j < 6; ++j) s.run.joint_position.push_back(std::sin(0.01 * i + j));
  }
  s.run.lost_messages = 3;
  s.run.receiver_restarts = 1;
  s.result.angle_source = "joints";
  s.result.source = "bar";
  s.result.plane = "XY";
  s.result.samples = 280;
  s.result.arc_begin = 10;
  s.result.arc_end = 290;
  for (int i = 0; i < 300; ++i) s.result.angle.push_back(i < 5 ? std::nan("") : 0.02 * i);
  s.result.circle.emplace();
  for (int k = 1; k <= 12; ++k)
    s.result.circle->harmonics.push_back({k, um(rng), um(rng), 1e-13 / k, 2e-13 / k, 0.3e-13 / k});
  s.result.predicted_from = "joints";
  for (int i = 0; i < 300; ++i) s.result.predicted.push_back(i < 10 ? std::nan("") : um(rng));
  s.result.circle_gap.emplace();
  for (int k = 1; k <= 10; ++k)
    s.result.circle_gap->harmonics.push_back({k, um(rng), um(rng), 3e-13 / k, 4e-13 / k, 0.2e-13 / k});
  s.result.circle_test.emplace();
  for (const bool radial : {false, true}) {
    SignatureFit fit;
    fit.frame_angle = radial ? 0.7 : 0.0;
    fit.signatures.push_back({"backlash_x", um(rng), 0.4e-6, 41e-6, 0.4, 70e-6, std::nullopt});
    fit.signatures.push_back({"squareness", 10.0 * um(rng), 3e-6, 20e-6, 0.2, 90e-6, std::nullopt});
    fit.signatures.push_back({"cyclic_y", um(rng), 1e-6, 9e-6, 0.09, 95e-6, 0.0125});
    fit.not_told_apart.push_back({{"straightness_x", "three_lobe"}, 5e-6, 0.05});
    (radial ? s.result.circle_test->radial_signatures : s.result.circle_test->signatures) = fit;
  }
  Record r = labels_of(s);
  r.values["gap_rms_um"] = {std::abs(um(rng)) * 1e6, std::nullopt};
  r.values["ovality_um"] = {um(rng) * 1e6, 0.25};
  r.values["circular_deviation_um"] = {um(rng) * 1e6, std::nullopt};
  r.values["feed_mm_s"] = {55.33, std::nullopt};
  s.records = {r};
  return s;
}

/// A line with two axes of 21 points.
inline Saved line(std::int64_t started_us = kDay, int direction = 1, unsigned seed = 1) {
  std::mt19937_64 rng(seed);
  std::uniform_real_distribution<double> um(-200e-6, 200e-6);
  Saved s;
  s.run.robot = "lrmate-1";
  s.run.test = "Y";
  s.run.kind = TestKind::kLine;
  s.run.direction = direction;
  s.run.repetition = 1;
  s.run.series = "before";
  s.run.started_us = started_us;
  s.run.ended_us = started_us + 60'000'000;
  s.run.feed = 0.05;
  s.result.source = "interferometer";
  for (const char axis : {'X', 'Z'}) {
    LineResult& l = s.result.lines.emplace_back();
    l.axis = axis;
    for (int i = 0; i < 21; ++i) {
      const double position = i * 0.0188;
      l.points.push_back({position, um(rng), std::nullopt});
      if (i % 2 == 0) l.points.back().reversal = um(rng);
      if (i % 3 == 0) l.points.back().predicted = um(rng);
      s.run.readings.push_back({axis, 2.0 * i, position, l.points.back().deviation});
    }
    Record r = labels_of(s, std::string(1, axis));
    r.values["straightness_mz_um"] = {std::abs(um(rng)) * 1e6, std::nullopt};
    r.values["reversal_max_um"] = {um(rng) * 1e6, std::nullopt};
    s.records.push_back(r);
  }
  s.result.samples = static_cast<std::int64_t>(s.run.readings.size());
  return s;
}

inline AlarmStatus alarm(const Saved& s, AlarmState state, int bad_runs = 2) {
  AlarmStatus a;
  a.key = {"ovality_high", s.run.robot, s.run.test, s.run.direction, ""};
  a.state = state;
  a.severity = "critical";
  a.since_us = s.run.ended_us;
  a.judged_us = s.run.ended_us;
  a.bad_runs = bad_runs;
  a.text = "ovality 31.2 um is above 25 um";
  return a;
}

}  // namespace ballbar::test
