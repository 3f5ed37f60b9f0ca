#include "common/process/aligned_memory.hpp"

#include <gtest/gtest.h>

#include <cstdint>
#include <utility>

namespace roadbalance {
namespace {

constexpr std::size_t kHugePage = std::size_t{2} << 20;

TEST(AlignedMemory, BeginsWithAHugePageOrALineOfTheCache) {
  AlignedVector<double> numbers(kHugePage / sizeof(double), 1.5);
  EXPECT_EQ(reinterpret_cast<std::uintptr_t>(numbers.data()) % kHugePage, 0u);
  numbers.pop_back();
  numbers.shrink_to_fit();  // less than a page: elsewhere
  ASSERT_EQ(numbers.size(), kHugePage / sizeof(double) - 1);
  EXPECT_EQ(numbers.back(), 1.5);
  for (std::size_t size = 1; size < 100; ++size)
    EXPECT_EQ(reinterpret_cast<std::uintptr_t>(AlignedVector<float>(size).data()) % 64, 0u);
}

TEST(AlignedMemory, IsCopiedAndMovedAsOthers) {
  AlignedVector<double> numbers(kHugePage, 2.5);
  const AlignedVector<double> copy = numbers;
  const double* const at = numbers.data();
  const AlignedVector<double> moved = std::move(numbers);
  EXPECT_EQ(moved.data(), at);
  EXPECT_NE(copy.data(), at);
  EXPECT_EQ(copy, moved);
}

}  // namespace
}  // namespace roadbalance
