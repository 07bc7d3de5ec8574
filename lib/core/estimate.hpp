#pragma once

#include <optional>

namespace ballbar {

/// A value with its standard deviation; sd is absent where the figure is an extreme, not an estimate.
struct Estimate {
  double value = 0.0;
  std::optional<double> sd;
  bool operator==(const Estimate&) const = default;
};

}  // namespace ballbar
