#include "common/frontend/lasting_reason.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

constexpr WallTime at_ms(int ms) {
  return WallTime(std::chrono::milliseconds(ms));
}

TEST(LastingReason, IsSaidOnceWhenItHasBeenTheSameForTwoSeconds) {
  LastingReason reason;
  EXPECT_FALSE(reason.is_to_be_said("down", at_ms(10'000)));
  EXPECT_FALSE(reason.is_to_be_said("down", at_ms(11'999)));
  EXPECT_TRUE(reason.is_to_be_said("down", at_ms(12'000)));
  EXPECT_FALSE(reason.is_to_be_said("down", at_ms(12'050)));
  EXPECT_FALSE(reason.is_to_be_said("down", at_ms(60'000)));
}

TEST(LastingReason, BeginsAnewWithAnotherReason) {
  LastingReason reason;
  EXPECT_FALSE(reason.is_to_be_said("none", at_ms(0)));
  EXPECT_FALSE(reason.is_to_be_said("down", at_ms(1'500)));
  EXPECT_FALSE(reason.is_to_be_said("down", at_ms(3'400)));
  EXPECT_TRUE(reason.is_to_be_said("down", at_ms(3'500)));
  EXPECT_FALSE(reason.is_to_be_said("wrong role", at_ms(3'600)));
  EXPECT_TRUE(reason.is_to_be_said("wrong role", at_ms(5'600)));
}

TEST(LastingReason, IsForgottenWhenTheDeviceWasThere) {
  LastingReason reason;
  EXPECT_FALSE(reason.is_to_be_said("down", at_ms(0)));
  EXPECT_TRUE(reason.is_to_be_said("down", at_ms(2'000)));
  reason.over();
  EXPECT_FALSE(reason.is_to_be_said("down", at_ms(9'000)));
  EXPECT_FALSE(reason.is_to_be_said("down", at_ms(10'900)));
  EXPECT_TRUE(reason.is_to_be_said("down", at_ms(11'000)));
}

}  // namespace
}  // namespace roadbalance
