/// The journal is not filled, whoever sends what.

#include "daemon/log.hpp"

#include <gtest/gtest.h>

namespace ballbar {
namespace {

TEST(LineBudget, GivesABurstThenSoManyASecondAndCountsWhatItLeavesOut) {
  constexpr std::uint64_t kSecond = 1'000'000;
  constexpr std::uint64_t kStart = 5'000 * kSecond;
  LineBudget budget;
  std::int64_t written = 0, left_out = 0;
  constexpr std::int64_t kLines = 100'000;
  for (std::int64_t i = 0; i < kLines; ++i)  // in a hundred seconds
    if (const auto before = budget.take(kStart + static_cast<std::uint64_t>(i) * kSecond / 1000)) {
      ++written;
      left_out += *before;
    }
  EXPECT_EQ(written, LineBudget::kBurst + 199);
  const auto later = budget.take(kStart + 1000 * kSecond);
  ASSERT_TRUE(later);
  EXPECT_EQ(written + left_out + *later, kLines) << "none is left out without being counted";
  for (std::int64_t i = 1; i < LineBudget::kBurst; ++i) EXPECT_EQ(budget.take(kStart + 1000 * kSecond), 0);
  EXPECT_FALSE(budget.take(kStart + 1000 * kSecond)) << "rest earns no more than one burst";
}

}  // namespace
}  // namespace ballbar
