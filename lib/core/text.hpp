#pragma once
/// Numbers in sentences.

#include <cmath>
#include <string>

namespace ballbar {

/// With two digits after the point at most: "3", "2.5", "0.04".
inline std::string to_hundredths(double value) {
  std::string text = std::to_string(std::round(value * 100.0) / 100.0);
  text.erase(text.find_last_not_of('0') + 1);
  if (text.back() == '.') text.pop_back();
  return text;
}

}  // namespace ballbar
