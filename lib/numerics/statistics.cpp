#include "numerics/statistics.hpp"

#include <cmath>
#include <stdexcept>

namespace ballbar {

double mean(std::span<const double> values) {
  if (values.empty()) throw std::invalid_argument("mean: no values");
  double sum = 0.0;
  for (const double v : values) sum += v;
  return sum / static_cast<double>(values.size());
}

std::optional<double> sample_sd(std::span<const double> values) {
  if (values.size() < 2) return {};
  const double centre = mean(values);
  double sum = 0.0;
  for (const double v : values) sum += (v - centre) * (v - centre);
  return std::sqrt(sum / static_cast<double>(values.size() - 1));
}

}  // namespace ballbar
