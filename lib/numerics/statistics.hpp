#pragma once
/// Mean and scatter of a few numbers.

#include <optional>
#include <span>

namespace ballbar {

/// @throws std::invalid_argument for no values
double mean(std::span<const double> values);

/// Standard deviation of a sample, over n - 1; nothing for fewer than two values.
std::optional<double> sample_sd(std::span<const double> values);

}  // namespace ballbar
