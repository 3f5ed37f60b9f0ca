#include "common/link/receiver.hpp"

#include <gtest/gtest.h>

#include "common/bus/codec.hpp"

namespace roadbalance {
namespace {

using namespace std::chrono_literals;
constexpr std::int64_t kEpoch = 9;
constexpr WallTime kStart{std::chrono::hours(1)};

SealedBlock scans(std::int64_t sequence, std::int64_t epoch = kEpoch) {
  ScanBlock block;
  block.header = {.node = 1,
                  .epoch = epoch,
                  .sequence = sequence,
                  .first_scan = 20 * (sequence - 1),
                  .scans = 20,
                  .time_ns = 10'000'000 * (sequence - 1)};
  block.period_ps = 500'000'000;
  SealedBlock sealed;
  seal(block, sealed);
  return sealed;
}

Heartbeat beat(std::int64_t base, std::int64_t next, std::int64_t epoch = kEpoch) {
  return {.node = 1, .epoch = epoch, .base = base, .next = next, .state = NodeState::kStarted};
}

class ReceiverTest : public ::testing::Test {
 protected:
  void take(const Heartbeat& heartbeat, WallTime at = kStart) { receiver.take(heartbeat, at, out); }
  void take(const SealedBlock& block, WallTime at = kStart) { receiver.take(block, at, out); }
  std::vector<std::int64_t> sequences() const {
    std::vector<std::int64_t> all;
    for (const auto& delivery : out)
      all.push_back(std::visit([](const auto& block) { return block.header.sequence; }, delivery));
    return all;
  }
  Ack ack_at(WallTime at) {
    const auto acks = receiver.due(at);
    EXPECT_EQ(acks.size(), 1u);
    return acks.empty() ? Ack{} : acks.front();
  }

  Receiver receiver{1};
  std::vector<Delivery> out;
};

using Sequences = std::vector<std::int64_t>;

TEST_F(ReceiverTest, DeliversInOrderAndOnce) {
  take(beat(1, 1));
  for (const std::int64_t k : {2, 1, 2, 4, 1, 3, 5, 4}) take(scans(k));
  EXPECT_EQ(sequences(), (Sequences{1, 2, 3, 4, 5}));
  EXPECT_EQ(receiver.refused()[static_cast<std::size_t>(Receiver::Refused::kDuplicate)], 3);
}

TEST_F(ReceiverTest, NeverTakesPreviewsOrUnknownEpochs) {
  take(scans(1));
  take(beat(1, 1));
  take(scans(0));
  take(scans(1, kEpoch + 1));
  EXPECT_TRUE(out.empty());
}

TEST_F(ReceiverTest, AsksForAHoleAndForATailThatOnlyTheHeartbeatShows) {
  take(beat(1, 1));
  take(scans(1));
  take(scans(3));
  take(beat(1, 6));
  (void)ack_at(kStart);
  const Ack ack = ack_at(kStart + 300ms);
  EXPECT_EQ(ack.received, 1);
  EXPECT_EQ(ack.missing, (std::vector<SequenceRange>{{2, 2}, {4, 5}}));
}

TEST_F(ReceiverTest, DoesNotAskForWhatMayBeOnItsWay) {
  take(beat(1, 1));
  take(scans(2));
  EXPECT_TRUE(ack_at(kStart + 4ms).missing.empty());
  EXPECT_EQ(ack_at(kStart + 60ms).missing.size(), 1u);
}

TEST_F(ReceiverTest, CallsDurableOnlyWhatTheDiskHas) {
  take(beat(1, 1));
  take(scans(1));
  take(scans(2));
  EXPECT_EQ(ack_at(kStart).durable, 0);
  receiver.durable(1, kEpoch, 2);
  EXPECT_EQ(ack_at(kStart + 1ms).durable, 2);
}

TEST_F(ReceiverTest, StopsTheCreditWhileTheDiskDoesNotFollow) {
  take(beat(1, 1));
  for (std::int64_t k = 1; k <= 4096; ++k) take(scans(k));
  EXPECT_EQ(receiver.current(1)->credit(), 4096);
  receiver.durable(1, kEpoch, 4000);
  EXPECT_EQ(receiver.current(1)->credit(), 4096 + 2048);
}

TEST_F(ReceiverTest, WhatTheNodeNoLongerHasBecomesAGapWithItsExactScans) {
  take(beat(1, 1));
  take(scans(1));
  take(scans(3));
  take(beat(6, 8));  // 2, 4 and 5 are gone
  take(scans(6));
  ASSERT_EQ(sequences(), (Sequences{1, 2, 3, 5, 6}));
  const auto& first = std::get<GapBlock>(out[1]);
  EXPECT_EQ(first.cause, GapCause::kLostAtNode);
  EXPECT_EQ(first.header.first_scan, 20);
  EXPECT_EQ(first.header.scans, 20);
  EXPECT_EQ(first.header.time_ns, 10'000'000);
  const auto& second = std::get<GapBlock>(out[3]);
  EXPECT_EQ(second.header.first_scan, 60);
  EXPECT_EQ(second.header.scans, 40);
}

TEST_F(ReceiverTest, ANewEpochClosesTheOldOneWithACrashGapOnceThatIsSilent) {
  take(beat(1, 1));
  take(scans(1));
  take(scans(3));
  take(beat(1, 1, kEpoch + 1), kStart + 500ms);
  EXPECT_EQ(sequences(), Sequences{1}) << "the old epoch may still live";
  EXPECT_EQ(receiver.rival_heartbeats(), 1);
  take(beat(1, 1, kEpoch + 1), kStart + 1500ms);
  ASSERT_EQ(sequences(), (Sequences{1, 2, 3, 4}));
  EXPECT_EQ(std::get<GapBlock>(out[1]).cause, GapCause::kLostAtNode);
  EXPECT_EQ(std::get<GapBlock>(out[3]).cause, GapCause::kNodeCrash);
  EXPECT_EQ(receiver.current(1)->epoch(), kEpoch + 1);
}

TEST_F(ReceiverTest, ContinuesARecoveredEpochBehindWhatTheRecordHolds) {
  receiver.recover(1, kEpoch, {.contiguous = 10, .next_scan = 200});
  take(beat(8, 13));
  for (std::int64_t k = 8; k <= 12; ++k) take(scans(k));
  EXPECT_EQ(sequences(), (Sequences{11, 12}));
  EXPECT_EQ(ack_at(kStart).durable, 10);
}

// A dead node's last blocks and its crash gap are durable too: whoever follows acknowledgements must hear it.
TEST_F(ReceiverTest, AcknowledgesAClosedEpochOnceItIsDurable) {
  take(beat(1, 1));
  take(scans(1));
  take(scans(2));
  receiver.durable(1, kEpoch, 1);
  take(beat(1, 1, kEpoch + 1), kStart + 2s);
  ASSERT_EQ(sequences(), (Sequences{1, 2, 3}));
  const auto of_old = [this](WallTime at) {
    std::vector<Ack> acks;
    for (const Ack& ack : receiver.due(at))
      if (ack.epoch == kEpoch) acks.push_back(ack);
    return acks;
  };
  EXPECT_TRUE(of_old(kStart + 2s).empty()) << "the crash gap is not on the disk yet";
  receiver.durable(1, kEpoch, 3);
  const auto acks = of_old(kStart + 3s);
  ASSERT_EQ(acks.size(), 1u);
  EXPECT_EQ(acks[0].durable, 3);
  EXPECT_EQ(of_old(kStart + 4s).size(), 1u) << "the first one may be lost";
  for (int k = 0; k < 10; ++k) (void)of_old(kStart + 5s + k * 1s);
  EXPECT_TRUE(of_old(kStart + 60s).empty()) << "but not for ever";
}

TEST_F(ReceiverTest, AcknowledgesTheCrashGapOfAnEpochThatAnEarlierRunLeftOpen) {
  receiver.recover(1, kEpoch, {.contiguous = 10, .next_scan = 200});
  take(beat(1, 1, kEpoch + 1));
  ASSERT_EQ(sequences(), Sequences{11});
  receiver.durable(1, kEpoch, 11);
  const auto acks = receiver.due(kStart);
  ASSERT_EQ(acks.size(), 2u);
  EXPECT_EQ(acks[0].epoch, kEpoch);
  EXPECT_EQ(acks[0].durable, 11);
}

TEST_F(ReceiverTest, RecordsANodeHoweverOftenItRestarts) {
  for (int k = 0; k < 1500; ++k) {
    const std::int64_t epoch = kEpoch + k;
    take(beat(1, 1, epoch), kStart + k * 2s);
    out.clear();
    take(scans(1, epoch), kStart + k * 2s);
    ASSERT_EQ(sequences(), Sequences{1}) << "restart " << k;
  }
}

TEST_F(ReceiverTest, ACrashGapBearsTheTimeOfItsFirstScan) {
  take(beat(1, 1));
  take(scans(1));
  take(scans(2));
  take(beat(1, 1, kEpoch + 1), kStart + 2s);
  const auto& crash = std::get<GapBlock>(out.back());
  EXPECT_EQ(crash.header.first_scan, 40);
  EXPECT_EQ(crash.header.time_ns, 20'000'000);  // blocks of 20 scans every 10 ms
}

TEST_F(ReceiverTest, TheHighestSequenceAllowedBreaksNothing) {
  receiver.recover(1, kEpoch, {.contiguous = kIndexLimit - 1, .next_scan = kIndexLimit - 20});
  take(beat(kIndexLimit, kIndexLimit));
  EXPECT_GE(receiver.current(1)->credit(), kIndexLimit - 1);
  EXPECT_EQ(receiver.current(1)->received(), kIndexLimit - 1);
  EXPECT_TRUE(out.empty());
}

}  // namespace
}  // namespace roadbalance
