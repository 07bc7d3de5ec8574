#include "numerics/statistics.hpp"

#include <gtest/gtest.h>

#include <stdexcept>
#include <vector>

namespace ballbar {
namespace {

TEST(Statistics, OfNumbersThatOneCanDoByHand) {
  const std::vector<double> values{2, 4, 4, 4, 5, 5, 7, 9};
  EXPECT_DOUBLE_EQ(mean(values), 5.0);
  EXPECT_NEAR(*sample_sd(values), 2.13808993529939, 1e-14);  // sqrt(32 / 7)
}

TEST(Statistics, SayWhenThereIsTooLittle) {
  EXPECT_THROW(mean({}), std::invalid_argument);
  EXPECT_FALSE(sample_sd(std::vector<double>{1.0}).has_value());
}

}  // namespace
}  // namespace ballbar
