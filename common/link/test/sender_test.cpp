#include "common/link/sender.hpp"

#include <gtest/gtest.h>

#include <random>

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

TEST_F(SenderTest, BelongsToNobodyOnceReleasedAndGoesToAnyoneNotOlder) {
  ASSERT_TRUE(sender.claim(5, kStart));
  EXPECT_FALSE(sender.release(4));
  EXPECT_TRUE(sender.release(5));
  EXPECT_EQ(sender.owner(), 0);
  EXPECT_FALSE(sender.take(ack(1, 0), kStart)) << "released";
  EXPECT_FALSE(sender.claim(3, kStart)) << "a recorder that slept through it all";
  EXPECT_TRUE(sender.claim(5, kStart)) << "the same again";
  EXPECT_TRUE(sender.release(5));
  EXPECT_TRUE(sender.claim(6, kStart)) << "handed over without waiting for a lease";
}

TEST_F(SenderTest, TheSameOwnersOldAcksAreOldAfterAReleaseToo) {
  put(10);
  ASSERT_TRUE(sender.claim(5, kStart));
  ASSERT_TRUE(sender.take(ack(7, 2), kStart));
  ASSERT_TRUE(sender.release(5));
  ASSERT_TRUE(sender.claim(5, kStart));
  EXPECT_FALSE(sender.take(ack(6, 3), kStart));
  EXPECT_TRUE(sender.take(ack(8, 3), kStart));
}

TEST_F(SenderTest, SendsANewOwnerWhatTheOldOneTookWithIt) {
  put(10);
  ASSERT_TRUE(sender.claim(5, kStart));
  ASSERT_TRUE(sender.take(ack(1, 3), kStart));
  ASSERT_EQ(due(kStart), 7u);
  ASSERT_TRUE(sender.claim(6, kStart + 2s));
  EXPECT_EQ(due(kStart + 2s), 0u) << "it has given no credit yet";
  Ack first = ack(1, 3);
  first.incarnation = 6;
  first.received = 4;
  ASSERT_TRUE(sender.take(first, kStart + 2s));
  const auto again = sender.due(kStart + 2s);
  EXPECT_EQ(std::vector<std::int64_t>(again.begin(), again.end()),
            (std::vector<std::int64_t>{5, 6, 7, 8, 9, 10}));
}

TEST_F(SenderTest, SendsANewOwnerNothingTwiceWithinTenMilliseconds) {
  put(10);
  ASSERT_TRUE(sender.claim(5, kStart));
  ASSERT_TRUE(sender.take(ack(1, 3), kStart));
  ASSERT_EQ(due(kStart), 7u);
  ASSERT_TRUE(sender.release(5));
  ASSERT_TRUE(sender.claim(6, kStart + 1ms));
  Ack first = ack(1, 3);
  first.incarnation = 6;
  ASSERT_TRUE(sender.take(first, kStart + 1ms));
  EXPECT_EQ(due(kStart + 9ms), 0u);
  EXPECT_EQ(due(kStart + 10ms), 7u);
}

// As often as the network may double, delay or forge an ack: freed is what a good one called durable.
TEST_F(SenderTest, NoAckFreesMoreThanAGoodOneEverCalledDurable) {
  std::mt19937 random(3);
  const auto up_to = [&random](std::int64_t most) {
    return static_cast<std::int64_t>(random()) % (most + 1);
  };
  std::int64_t durable = 0;
  for (int k = 0; k < 20'000; ++k) {
    const WallTime at = kStart + k * 10ms;
    if (backlog.used() < 90) put(static_cast<int>(up_to(5)));
    sender.claim(1 + up_to(9), at);
    // Drawn one after another: in which order arguments are evaluated differs from processor to processor.
    const std::int64_t credit = up_to(1000) + backlog.next();
    const std::int64_t claimed = up_to(backlog.next() + 3);
    Ack any = ack(up_to(k), claimed, credit);
    any.incarnation = 1 + up_to(9);
    any.epoch = up_to(9) == 0 ? kEpoch + 1 : kEpoch;
    const std::int64_t obeyed = sender.owner();
    if (sender.take(any, at)) {
      EXPECT_EQ(any.incarnation, obeyed);
      EXPECT_EQ(any.epoch, kEpoch);
      EXPECT_LT(any.durable, backlog.next());
      durable = std::max(durable, any.durable);
    }
    ASSERT_EQ(backlog.base(), durable + 1);
    for (const std::int64_t sequence : sender.due(at)) {
      ASSERT_GE(sequence, backlog.base());
      ASSERT_LT(sequence, backlog.next());
    }
  }
  EXPECT_GT(durable, 1000);
}

}  // namespace
}  // namespace roadbalance
