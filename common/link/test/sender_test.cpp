#include "common/link/sender.hpp"

#include <gtest/gtest.h>

namespace roadbalance {
namespace {

using namespace std::chrono_literals;
constexpr std::int64_t kEpoch = 77;
constexpr WallTime kStart{std::chrono::hours(1)};

class SenderTest : public ::testing::Test {
 protected:
  void put(int blocks) {
    for (int k = 0; k < blocks; ++k) {
      ring.claim()->header.sequence = ring.next();
      ring.commit();
    }
  }
  Ack ack(std::int64_t number, std::int64_t durable, std::int64_t credit = 1000) {
    return {.node = 1,
            .epoch = kEpoch,
            .incarnation = 5,
            .number = number,
            .received = durable,
            .durable = durable,
            .credit = credit,
            .missing = {}};
  }
  std::size_t due(WallTime at) { return sender.due(at).size(); }

  Ring ring{100 * sizeof(SealedBlock)};
  Backlog backlog{ring};
  Sender sender{backlog, 1, kEpoch};
};

TEST_F(SenderTest, SendsNothingWithoutAnOwner) {
  put(10);
  EXPECT_EQ(due(kStart), 0u);
}

TEST_F(SenderTest, SendsEachBlockOnceAsFarAsTheCreditReaches) {
  put(10);
  ASSERT_TRUE(sender.claim(5, kStart));
  ASSERT_TRUE(sender.take(ack(1, 0, 4), kStart));
  EXPECT_EQ(due(kStart), 4u);
  EXPECT_EQ(due(kStart + 1s), 0u);
  ASSERT_TRUE(sender.take(ack(2, 0, 20), kStart));
  EXPECT_EQ(due(kStart + 2s), 6u);
}

TEST_F(SenderTest, FreesOnlyWhatItsOwnerCallsDurable) {
  put(10);
  ASSERT_TRUE(sender.claim(5, kStart));
  Ack stale = ack(1, 3);
  stale.incarnation = 4;
  EXPECT_FALSE(sender.take(stale, kStart));
  Ack foreign = ack(1, 3);
  foreign.epoch = kEpoch + 1;
  EXPECT_FALSE(sender.take(foreign, kStart));
  EXPECT_FALSE(sender.take(ack(1, 11), kStart)) << "more than was ever sealed";
  EXPECT_EQ(ring.base(), 1);
  EXPECT_TRUE(sender.take(ack(2, 3), kStart));
  EXPECT_EQ(ring.base(), 4);
  EXPECT_FALSE(sender.take(ack(2, 6), kStart)) << "the number did not rise";
  EXPECT_EQ(ring.base(), 4);
  EXPECT_EQ(sender.acks_refused(), 4);
}

TEST_F(SenderTest, RepairsOldestFirstAndNotTwiceWithinTenMilliseconds) {
  put(10);
  ASSERT_TRUE(sender.claim(5, kStart));
  ASSERT_TRUE(sender.take(ack(1, 0), kStart));
  ASSERT_EQ(due(kStart), 10u);
  Ack holes = ack(2, 0);
  holes.missing = {{2, 3}, {7, 7}};
  ASSERT_TRUE(sender.take(holes, kStart + 5ms));
  EXPECT_EQ(due(kStart + 5ms), 0u);
  holes.number = 3;
  ASSERT_TRUE(sender.take(holes, kStart + 20ms));
  const auto repairs = sender.due(kStart + 20ms);
  EXPECT_EQ(std::vector<std::int64_t>(repairs.begin(), repairs.end()), (std::vector<std::int64_t>{2, 3, 7}));
  EXPECT_EQ(sender.blocks_repaired(), 3);
}

TEST_F(SenderTest, TheTokenBucketBoundsABurst) {
  put(99);
  ASSERT_TRUE(sender.claim(5, kStart));
  ASSERT_TRUE(sender.take(ack(1, 0), kStart));
  EXPECT_EQ(due(kStart), 64u);
  EXPECT_EQ(due(kStart + 1ms), 20u);  // 20 000 a second
}

TEST_F(SenderTest, RefusesASecondRecorderWhileTheOwnersLeaseLives) {
  ASSERT_TRUE(sender.claim(5, kStart));
  EXPECT_FALSE(sender.claim(6, kStart + 500ms));
  ASSERT_TRUE(sender.take(ack(1, 0), kStart + 900ms));
  EXPECT_FALSE(sender.claim(6, kStart + 1500ms));
  EXPECT_TRUE(sender.claim(6, kStart + 2s));
  EXPECT_FALSE(sender.take(ack(2, 0), kStart + 2s)) << "the old owner speaks again";
  EXPECT_FALSE(sender.claim(5, kStart + 10s)) << "a stale incarnation never owns again";
}

TEST_F(SenderTest, BelongsToNobodyOnceReleased) {
  ASSERT_TRUE(sender.claim(5, kStart));
  EXPECT_FALSE(sender.release(4));
  EXPECT_TRUE(sender.release(5));
  EXPECT_EQ(sender.owner(), 0);
  EXPECT_TRUE(sender.claim(3, kStart));
}

}  // namespace
}  // namespace roadbalance
