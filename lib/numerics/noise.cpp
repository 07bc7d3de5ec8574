#include "numerics/noise.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace ballbar {

double sample_noise(const Eigen::VectorXd& values) {
  constexpr double kNormal =
      1.4826;  // standard deviation of a normal distribution over its median absolute deviation
  if (values.size() < 3) return 0.0;
  std::vector<double> size;
  for (Eigen::Index i = 0; i + 2 < values.size(); ++i)
    size.push_back(std::abs(values[i] - 2.0 * values[i + 1] + values[i + 2]));
  const auto middle = size.begin() + static_cast<std::ptrdiff_t>(size.size() / 2);
  std::nth_element(size.begin(), middle, size.end());
  return kNormal * *middle / std::sqrt(6.0);
}

}  // namespace ballbar
