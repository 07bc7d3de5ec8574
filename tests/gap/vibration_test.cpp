// A line at one frequency in time, in made laps of two speeds.

#include "gap/vibration.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <numeric>
#include <random>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::VectorXd;

/// Laps of 400 places with white and slow noise of 0.7 um each and, on request, a vibration of another phase
/// in each.
std::vector<Observation> made(std::uint64_t seed, double hertz, double amplitude) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> normal(0.0, 0.7e-6);
  std::uniform_real_distribution<double> turn(0.0, 2.0 * std::numbers::pi);
  std::vector<Observation> all;
  for (const double duration : {11.4, 11.4, 3.5, 3.5, 11.4, 3.5}) {
    Observation seen;
    seen.transform = CosineTransform(400, 1.0, 180.0);
    seen.place = VectorXd::LinSpaced(400, 0.0, 6.0);
    seen.sample.resize(400);
    std::iota(seen.sample.begin(), seen.sample.end(), 0);
    seen.time = VectorXd::LinSpaced(400, 1.0, 1.0 + duration * 399.0 / 400.0);
    // What is faster than a lap's places can carry is taken out before, by the fit of its thousands of
    // readings.
    const double size = hertz < 180.0 / duration ? amplitude : 0.0;
    seen.laps.resize(seen.transform.frequency().size(), 2);
    for (Index lap = 0; lap < 2; ++lap) {
      const double phase = turn(random);
      VectorXd values(400);
      double slow = normal(random);
      for (Index i = 0; i < 400; ++i) {
        slow = 0.97 * slow + std::sqrt(1.0 - 0.97 * 0.97) * normal(random);
        values[i] =
            normal(random) + slow + size * std::sin(2.0 * std::numbers::pi * hertz * seen.time[i] + phase);
      }
      seen.laps.col(lap) = seen.transform(values);
    }
    seen.measured = seen.laps.rowwise().mean();
    all.push_back(std::move(seen));
  }
  return all;
}

std::vector<VectorXd> nothing(const std::vector<Observation>& observations) {
  std::vector<VectorXd> all;
  for (const Observation& seen : observations) all.push_back(VectorXd::Zero(seen.measured.size()));
  return all;
}

TEST(Vibration, IsFoundWithItsFrequencyAndSize) {
  for (const auto& [hertz, amplitude] : {std::pair{9.3, 4e-6}, {14.65, 2e-6}, {21.7, 5e-6}, {40.2, 8e-6}}) {
    SCOPED_TRACE(std::to_string(hertz) + " Hz, seed 5");
    const std::vector<Observation> laps = made(5, hertz, amplitude);
    const auto found = find_vibration(laps, nothing(laps));
    ASSERT_TRUE(found);
    EXPECT_NEAR(found->frequency.value, hertz, 2.0 * *found->frequency.sd);
    EXPECT_NEAR(found->amplitude.value, amplitude, 0.25 * amplitude);
  }
}

TEST(Vibration, IsNotFoundInNoise) {
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    const std::vector<Observation> laps = made(seed, 10.0, 0.0);
    EXPECT_FALSE(find_vibration(laps, nothing(laps))) << "seed " << seed;
  }
}

}  // namespace
}  // namespace ballbar
