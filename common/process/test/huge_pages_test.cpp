#include "common/process/huge_pages.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>

namespace roadbalance {
namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;

TEST(HugePages, BeginWhereOneMayBegin) {
  HugeVector<double> numbers(kHugePage / sizeof(double), 1.5);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(numbers.data()) % kHugePage, 0u);
  numbers.pop_back();
  numbers.shrink_to_fit();  // less than a page: elsewhere
  ASSERT_EQ(numbers.size(), kHugePage / sizeof(double) - 1);
  EXPECT_EQ(numbers.back(), 1.5);
}

TEST(HugePages, AreCopiedAndMovedAsOthers) {
  HugeVector<double> numbers(kHugePage, 2.5);
  const HugeVector<double> copy = numbers;
  const double* const at = numbers.data();
  const HugeVector<double> moved = std::move(numbers);
  EXPECT_EQ(moved.data(), at);
  EXPECT_NE(copy.data(), at);
  EXPECT_EQ(copy, moved);
}

}  // namespace
}  // namespace roadbalance
