#include "common/link/ask_interval.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using namespace std::chrono_literals;

TEST(AskInterval, IsTwiceTheRoundTripAndNoLessThanAsked) {
  AskInterval interval(20ms);
  EXPECT_EQ(interval.get(), 20ms);
  interval.answered_once(40ms);
  EXPECT_EQ(interval.get(), 80ms);
  interval.answered_once(3ms);
  EXPECT_EQ(interval.get(), 20ms);
}

// A cable is plugged in again: a thousand blocks are asked for at once and answered one behind the other.
TEST(AskInterval, IsNotMovedByAnswersThatWaitedBehindOthers) {
  AskInterval interval(20ms);
  interval.answered_once(8ms);
  for (int k = 0; k < 1'000; ++k) interval.answered_once(8ms + k * 60us);
  EXPECT_EQ(interval.get(), 20ms);
}

TEST(AskInterval, FollowsANetworkThatHasBecomeSlow) {
  AskInterval interval(20ms);
  interval.answered_once(5ms);
  for (int k = 0; k < 2'048; ++k) interval.answered_once(120ms);
  EXPECT_EQ(interval.get(), 240ms);
}

TEST(AskInterval, GrowsWhenAnswersComeTwiceButNotFar) {
  AskInterval interval(20ms);
  for (int k = 0; k < 100; ++k) interval.answered_twice();
  EXPECT_EQ(interval.get(), 100ms);
}

}  // namespace
}  // namespace roadbalance
