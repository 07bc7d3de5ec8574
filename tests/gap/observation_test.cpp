// The noise of laps that repeat each other, against the noise that was put in.

#include "gap/observation.hpp"

#include <gtest/gtest.h>

#include <random>

namespace ballbar {
namespace {

using Eigen::Index;
using Eigen::MatrixXd;
using Eigen::VectorXd;

constexpr Index kPlaces = 400;
constexpr double kNoise = 0.6e-6;  // [m] of one reading, white

/// Recordings of two laps each; in the one numbered `jumped`, the second lap reads 8 um more.
std::vector<Observation> recordings(int count, int jumped, unsigned seed) {
  std::mt19937_64 random(seed);
  std::normal_distribution<double> noise(0.0, kNoise);
  std::vector<Observation> all(static_cast<std::size_t>(count));
  for (int i = 0; i < count; ++i) {
    Observation& seen = all[static_cast<std::size_t>(i)];
    seen.place = VectorXd::LinSpaced(kPlaces, 0.0, 6.28);
    seen.transform = CosineTransform(kPlaces, 1.0, kHighestFrequency);
    seen.readings_per_turn = kPlacesPerTurn;
    MatrixXd laps = MatrixXd::NullaryExpr(kPlaces, 2, [&] { return noise(random); });
    if (i == jumped) laps.col(1).array() += 8e-6;
    seen.laps = seen.transform(laps);
    seen.measured = seen.laps.rowwise().mean();
  }
  return all;
}

TEST(Noise, IsThatOfTheLapsWhateverMovedBetweenTwoOfThem) {
  for (const int jumped : {-1, 0, 7}) {
    std::vector<Observation> all = recordings(12, jumped, 21);
    SCOPED_TRACE("seed 21, jump in recording " + std::to_string(jumped));
    const NoiseLevel level = assign_noise(all);
    EXPECT_TRUE(level.from_repeats);
    // Of 400 coefficients 361 are looked at.
    EXPECT_NEAR(level.lap, kNoise * std::sqrt(361.0 / 400.0), 0.05 * kNoise);
    EXPECT_NEAR(level.floor, level.lap / std::sqrt(2.0), 0.01 * kNoise);
  }
}

TEST(Noise, WhereHalfOfTheRecordingsDifferIsTheirs) {
  std::vector<Observation> all = recordings(8, -1, 22);
  for (std::size_t i = 0; i < 4; ++i) all[i].laps.row(0) *= 30.0;
  EXPECT_GT(assign_noise(all).lap, 1.1 * kNoise);
}

}  // namespace
}  // namespace ballbar
