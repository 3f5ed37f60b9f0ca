#include "hil_tests/memory_trend.hpp"

#include <gtest/gtest.h>
#include <unistd.h>

#include <cstdint>
#include <vector>

#include "hil_tests/program.hpp"

namespace roadbalance::test {
namespace {

constexpr std::int64_t kMiB = 1 << 20;

TEST(MemoryTrend, SeesMemoryThatAProgramTakes) {
  const auto before = own_memory_bytes(::getpid());
  ASSERT_TRUE(before);
  std::vector<std::uint8_t> taken(16 * kMiB, 1);
  const auto after = own_memory_bytes(::getpid());
  ASSERT_TRUE(after);
  EXPECT_GE(*after - *before, 16 * kMiB - 64 * 1024 + taken.back() - taken.back());
#ifdef __SANITIZE_THREAD__  // which keeps four bytes of its own beside each
  EXPECT_LT(*after - *before, 5 * 17 * kMiB);
#else
  EXPECT_LT(*after - *before, 17 * kMiB);
#endif
}

TEST(MemoryTrend, AProgramThatIsGoneHasNone) {
  Program gone("true", {});
  const pid_t pid = gone.pid();
  ASSERT_EQ(gone.exit_code(60), 0);
  EXPECT_FALSE(own_memory_bytes(pid));
}

TEST(MemoryTrend, CountsGrowthFromWhereItHasSettledToTheMostItEverHas) {
  MemoryTrend trend(10);
  trend.add(0, 5 * kMiB);
  trend.add(9.9, 90 * kMiB);
  EXPECT_FALSE(trend.has_settled());
  trend.add(10, 50 * kMiB);
  trend.add(20, 53 * kMiB);
  trend.add(30, 49 * kMiB);
  EXPECT_TRUE(trend.has_settled());
  EXPECT_EQ(trend.settled_bytes(), 50 * kMiB);
  EXPECT_EQ(trend.growth_bytes(), 3 * kMiB);
}

}  // namespace
}  // namespace roadbalance::test
