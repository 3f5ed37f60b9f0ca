#include "common/types/bounded_time.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

TEST(BoundedTime, IsExactAsFarAsClocksGo) {
  EXPECT_EQ(time_after_ns(7, 0, 1'000'000'000'000), 7);
  EXPECT_EQ(time_after_ns(-5, 3, 333), -5) << "999 ps";
  EXPECT_EQ(time_after_ns(0, 1003, 333), 333) << "333,999 ps";
  EXPECT_EQ(time_after_ns(-kClockLimit_ns, 4'000'000'000, 1'000'000'000'000),
            -kClockLimit_ns + 4'000'000'000'000'000'000);
}

TEST(BoundedTime, EndsAtTheLimitOfClocks) {
  for (const std::int64_t begin_ns : {-kClockLimit_ns, std::int64_t{0}, kClockLimit_ns})
    EXPECT_EQ(time_after_ns(begin_ns, kIndexLimit, 1'000'000'000'000), kClockLimit_ns);
  const ClockFit fit{.host_ns = kClockLimit_ns, .node_ns = -kClockLimit_ns, .drift = -0.1};
  EXPECT_EQ(host_instant_ns(fit, kClockLimit_ns), kClockLimit_ns);
}

}  // namespace
}  // namespace roadbalance
