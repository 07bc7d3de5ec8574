// Processor time of all figures of ISO 230-4 and ISO 12181 of circles of 20,000 samples. Usage: circles_bench

#include <algorithm>
#include <cmath>
#include <cstdio>
#include <ctime>
#include <numbers>
#include <random>

#include "metrology/circle_iso.hpp"

namespace {

/// [ms] of processor time per call, the best of many: what the machine can do when nothing else runs.
template <typename Call>
double milliseconds(Call call) {
  const auto now = [] { return 1e3 * static_cast<double>(std::clock()) / CLOCKS_PER_SEC; };
  double best = 1e300;
  for (int round = 0; round < 25; ++round) {
    const double begin = now();
    call();
    best = std::min(best, now() - begin);
  }
  return best;
}

ballbar::CircleTrace trace_of(int direction, int samples, double noise) {
  std::mt19937 random(static_cast<unsigned>(42 + direction));
  std::normal_distribution<double> normal(0.0, 1.0);
  ballbar::CircleTrace trace;
  trace.direction = direction;
  trace.angle.resize(samples);
  trace.deviation.resize(samples);
  for (int i = 0; i < samples; ++i) {
    const double angle = direction * 2.0 * std::numbers::pi * (i + 0.5) / samples;
    trace.angle[i] = angle;
    trace.deviation[i] = 40e-6 * std::cos(angle) + 185e-6 * std::cos(2 * angle + 0.4 + 0.1 * direction) +
                         20e-6 * std::sin(3 * angle) +
                         direction * 8e-6 * std::copysign(1.0, std::sin(angle)) +
                         3e-6 * std::sin(40 * angle) + noise * normal(random);
  }
  return trace;
}

}  // namespace

int main() {
  constexpr double kBudget = 20.0;
  ballbar::CircleSpec spec;
  spec.arc_sweep = 2.0 * std::numbers::pi;
  ballbar::CircleSettings filter;
  filter.filter_upr = 50.0;
  double sum = 0.0;  // printed, so that no call is optimised away
  double worst = 0.0;
  const auto report = [&](const char* what, double took) {
    std::printf("%-52s %6.1f ms (budget %.0f)\n", what, took, kBudget);
    worst = std::max(worst, took);
  };
  for (const double noise : {0.5e-6, 0.0}) {
    std::printf("noise %.1f um\n", noise * 1e6);
    const ballbar::CircleTrace one = trace_of(1, 20000, noise);
    const ballbar::CircleTrace ccw = trace_of(1, 10000, noise);
    const ballbar::CircleTrace cw = trace_of(-1, 10000, noise);
    report("one direction, 20,000 samples",
           milliseconds([&] { sum += circle_figures(one, spec)->radial_max_setup; }));
    report("one direction, 20,000 samples, filtered",
           milliseconds([&] { sum += circle_figures(one, spec, filter)->radial_max_setup; }));
    report("both directions, 10,000 samples each",
           milliseconds([&] { sum += *join(ccw, cw, spec)->circular_error_b; }));
    report("both directions, 10,000 samples each, filtered",
           milliseconds([&] { sum += *join(ccw, cw, spec, filter)->circular_error_b; }));
  }
  std::printf("(checksum %g)\n", sum);
  return worst < kBudget ? 0 : 1;
}
