#pragma once
/// The same numbers on every machine: the standard fixes mt19937_64, but not what its distributions make of
/// it.

#include <Eigen/Core>
#include <cmath>
#include <cstdint>
#include <numbers>
#include <random>
#include <string_view>

namespace blind {

class Random {
 public:
  /// One stream per seed and purpose, so that more draws for one purpose leave the others as they were.
  Random(std::uint64_t seed, std::string_view purpose) {
    std::uint64_t hash = 1469598103934665603ULL;
    for (const char c : purpose) hash = (hash ^ static_cast<unsigned char>(c)) * 1099511628211ULL;
    engine_.seed(hash ^ (seed * 0x9E3779B97F4A7C15ULL));
  }

  double uniform(double low, double high) {
    return low + (high - low) * static_cast<double>(engine_() >> 11U) * 0x1.0p-53;
  }
  double log_uniform(double low, double high) { return std::exp(uniform(std::log(low), std::log(high))); }
  int below(int count) { return static_cast<int>(uniform(0.0, count)); }
  double sign() { return engine_() & 1U ? 1.0 : -1.0; }
  double normal(double sigma) {
    const double radius = std::sqrt(-2.0 * std::log(1.0 - uniform(0.0, 1.0)));
    return sigma * radius * std::cos(2.0 * std::numbers::pi * uniform(0.0, 1.0));
  }
  Eigen::Vector3d normal3(double sigma) {
    const double x = normal(sigma), y = normal(sigma), z = normal(sigma);
    return {x, y, z};
  }

 private:
  std::mt19937_64 engine_;
};

}  // namespace blind
