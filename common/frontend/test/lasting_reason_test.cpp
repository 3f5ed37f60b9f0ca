#include "common/frontend/lasting_reason.hpp"

#include <gtest/gtest.h>

#include <initializer_list>
#include <vector>

namespace roadbalance {
namespace {

constexpr WallTime at_ms(int ms) {
  return WallTime(std::chrono::milliseconds(ms));
}

/// When it is reported, for reasons given at these milliseconds.
std::vector<int> reported_at(LastingReason& reason, const char* why, std::initializer_list<int> told_at) {
  std::vector<int> said;
  for (const int ms : told_at)
    if (reason.is_due(why, at_ms(ms))) said.push_back(ms);
  return said;
}

TEST(LastingReason, IsSaidOnceWhenItHasBeenTheSameForTwoSeconds) {
  LastingReason reason;
  EXPECT_EQ(reported_at(reason, "down", {10'000, 11'999, 12'000, 12'050, 60'000}), std::vector{12'000});
}

TEST(LastingReason, BeginsAnewWithAnotherReason) {
  LastingReason reason;
  EXPECT_EQ(reported_at(reason, "none", {0}), std::vector<int>{});
  EXPECT_EQ(reported_at(reason, "down", {1'500, 3'400, 3'500}), std::vector{3'500});
  EXPECT_EQ(reported_at(reason, "wrong role", {3'600, 5'600}), std::vector{5'600});
}

TEST(LastingReason, IsForgottenWhenTheDeviceWasThere) {
  LastingReason reason;
  EXPECT_EQ(reported_at(reason, "down", {0, 2'000}), std::vector{2'000});
  reason.over();
  EXPECT_EQ(reported_at(reason, "down", {9'000, 10'900, 11'000}), std::vector{11'000});
}

}  // namespace
}  // namespace roadbalance
