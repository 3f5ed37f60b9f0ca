#include "common/angle/fault_balance.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

constexpr bool kJitter = true, kStill = false;

/// The teeth that follow add nothing, over as many as any fault could wait.
std::int64_t later(FaultBalance& balance, std::int64_t number, bool jitter = kJitter) {
  std::int64_t count = 0;
  for (std::int64_t n = number; n < number + 10; ++n) count += balance.add(10 * n, n, 0, jitter).count;
  return count;
}

TEST(FaultBalance, CallsEachAFaultAtOnceWhereStampsDoNotJitter) {
  FaultBalance balance;
  const auto missed = balance.add(70, 7, -2, kStill);
  EXPECT_EQ(missed.count, 2);
  EXPECT_EQ(missed.since_ns, 70);
  EXPECT_EQ(balance.add(75, 7, 1, kStill).count, 1) << "one too many is no pulse of those missed";
  EXPECT_EQ(later(balance, 8, kStill), 0);
}

TEST(FaultBalance, LetsATwoSidedFaultCancelWithinTwoTeethWhereStampsJitter) {
  for (const std::int64_t apart : {0, 1, 2})
    for (const std::int64_t first : {-1, 1}) {
      FaultBalance balance;
      EXPECT_EQ(balance.add(70, 7, first, kJitter).count, 0) << "the tooth beside it will say";
      EXPECT_EQ(balance.add(70 + 10 * apart, 7 + apart, -first, kJitter).count, 0);
      EXPECT_EQ(later(balance, 8 + apart), 0);
    }
}

TEST(FaultBalance, CallsBothAFaultThreeTeethApart) {
  for (const std::int64_t first : {-1, 1}) {
    FaultBalance balance;
    EXPECT_EQ(balance.add(70, 7, first, kJitter).count, 0);
    EXPECT_EQ(balance.add(80, 8, 0, kJitter).count, 0);
    const auto known = balance.add(100, 10, -first, kJitter);
    EXPECT_EQ(known.count, 1);
    EXPECT_EQ(known.since_ns, 70);
    EXPECT_EQ(later(balance, 11), 1) << "the other one waits for its own two teeth";
  }
}

TEST(FaultBalance, CallsOneAFaultThatNothingCancels) {
  FaultBalance balance;
  EXPECT_EQ(balance.add(70, 7, -1, kJitter).count, 0);
  EXPECT_EQ(balance.add(90, 9, 0, kJitter).count, 0);
  const auto known = balance.add(100, 10, 0, kJitter);
  EXPECT_EQ(known.count, 1);
  EXPECT_EQ(known.since_ns, 70);
  EXPECT_EQ(later(balance, 11), 0);
}

TEST(FaultBalance, LeavesNothingOpenWhereJitterEndsOrTheTeethAreForgotten) {
  FaultBalance balance;
  EXPECT_EQ(balance.add(70, 7, -1, kJitter).count, 0);
  const auto known = balance.add(80, 8, 1, kStill);
  EXPECT_EQ(known.count, 2) << "what was open, and what came";
  EXPECT_EQ(known.since_ns, 70);
  EXPECT_EQ(balance.add(90, 9, 1, kJitter).count, 0);
  balance.forget();
  EXPECT_EQ(later(balance, 10), 0);
}

}  // namespace
}  // namespace roadbalance
