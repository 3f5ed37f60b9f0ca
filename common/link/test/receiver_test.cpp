#include "common/link/receiver.hpp"

#include <gtest/gtest.h>

#include "common/bus/codec.hpp"
#include "common/link/test/receiver_fixture.hpp"

namespace roadbalance {
namespace {

using namespace test;
using ReceiverTest = ReceiverFixture;

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
  (void)ack_at(kStart);  // gives the credit to send 4 and 5
  take(beat(1, 6));
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
  EXPECT_EQ(receiver.find(1, kEpoch)->credit(), 4096);
  receiver.durable(1, kEpoch, 4000);
  EXPECT_EQ(receiver.find(1, kEpoch)->credit(), 4096 + 2048);
}

TEST_F(ReceiverTest, TakesNoMoreThanItsMemoryHoldsOfASenderThatKnowsNoCredit) {
  take(beat(1, 1));
  for (std::int64_t k = 1; k <= 10'000; ++k) take(scans(k));
  EXPECT_EQ(receiver.find(1, kEpoch)->received(), ReceiverOptions{}.undurable);
  EXPECT_EQ(out.size(), static_cast<std::size_t>(ReceiverOptions{}.undurable));
  receiver.durable(1, kEpoch, 1);
  take(scans(4097));
  EXPECT_EQ(receiver.find(1, kEpoch)->received(), 4097) << "and goes on as the disk does";
}

TEST_F(ReceiverTest, GoesOnBehindALossThatIsNotOnTheDiskYet) {
  take(beat(10'001, 10'500));
  take(scans(10'001));
  take(scans(10'002));
  EXPECT_EQ(sequences(), (Sequences{10'000, 10'001, 10'002}));
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

// It may only have slept: blocks behind the last one received without a hole are its own. Behind a hole the
// end would mean that the epoch is complete. The recorder was killed after the sync and before the ack.
TEST_F(ReceiverTest, GivesNoNewCreditWhileTheDiskFails) {
  take(beat(1, 1));
  take(scans(1));
  const std::int64_t given = ack_at(kStart).credit;
  receiver.set_credit_open(false);
  for (std::int64_t k = 2; k <= 1000; ++k) take(scans(k), kStart + 1ms);
  receiver.durable(1, kEpoch, 1000);
  EXPECT_EQ(ack_at(kStart + 1s).credit, given);
  take(beat(1, 1, kEpoch + 1), kStart + 1s);
  for (const Ack& ack : receiver.due(kStart + 2s))
    if (ack.epoch != kEpoch) {
      EXPECT_EQ(ack.credit, 0) << "a node that comes meanwhile gets none";
    }
  receiver.set_credit_open(true);
  for (const Ack& ack : receiver.due(kStart + 3s))
    EXPECT_EQ(ack.credit, (ack.epoch == kEpoch ? 1000 : 0) + 2048);
}

TEST_F(ReceiverTest, AsksAgainAfterTwentyMillisecondsAndSaysEachQuestionTwice) {
  take(beat(1, 1));
  (void)ack_at(kStart);
  take(scans(2), kStart);
  std::vector<std::int64_t> asked_ms;
  for (int ms = 1; ms <= 60; ++ms)
    for (const Ack& ack : receiver.due(kStart + ms * 1ms))
      if (!ack.missing.empty()) asked_ms.push_back(ms);
  EXPECT_EQ(asked_ms, (std::vector<std::int64_t>{5, 10, 25, 30, 45, 50}));
}

TEST_F(ReceiverTest, WaitsTwiceTheRoundTripOnceItIsKnown) {
  take(beat(1, 1));
  (void)ack_at(kStart);
  // Every other block is lost and repaired 80 ms after it was asked for.
  WallTime at = kStart;
  for (std::int64_t k = 1; k < 100; k += 2, at += 1s) {
    take(beat(1, k + 2), at);
    take(scans(k + 1), at);
    int asks = 0;
    for (int ms = 5; ms < 85; ms += 5)
      for (const Ack& ack : receiver.due(at + ms * 1ms)) asks += !ack.missing.empty();
    for (int copy = 0; copy < asks / 2; ++copy) take(scans(k), at + 85ms);
  }
  take(beat(1, 103), at);
  take(scans(102), at);
  (void)ack_at(at);
  std::vector<std::int64_t> asked_ms;
  for (int ms = 1; ms <= 200; ++ms)
    for (const Ack& ack : receiver.due(at + ms * 1ms))
      if (!ack.missing.empty()) asked_ms.push_back(ms);
  EXPECT_EQ(asked_ms, (std::vector<std::int64_t>{5, 10, 165, 170}));
}

// A recorder that comes late: blocks that another one has are lost to it, and wait for the next block to be
// declared.
TEST_F(ReceiverTest, GivesCreditBehindALossThatIsNotDeclaredYet) {
  take(beat(10'001, 10'500));
  EXPECT_EQ(receiver.find(1, kEpoch)->received(), 10'000);
  EXPECT_GT(receiver.find(1, kEpoch)->credit(), 10'000) << "no block can come that would tell the loss";
}

TEST_F(ReceiverTest, TheHighestSequenceAllowedBreaksNothing) {
  receiver.recover(1, kEpoch, {.contiguous = kIndexLimit - 1, .next_scan = kIndexLimit - 20});
  take(beat(kIndexLimit, kIndexLimit));
  EXPECT_GE(receiver.find(1, kEpoch)->credit(), kIndexLimit - 1);
  EXPECT_LE(receiver.find(1, kEpoch)->credit(), kIndexLimit) << "else the node would refuse the ack";
  EXPECT_EQ(receiver.find(1, kEpoch)->received(), kIndexLimit - 1);
  EXPECT_TRUE(out.empty());
}

// Whatever blocks carry within their bounds, a gap that is declared between them is one that a reader
// accepts.
TEST_F(ReceiverTest, AGapThatItDeclaresIsWithinTheBoundsOfEveryReader) {
  const auto at = [](std::int64_t sequence, std::int64_t first_scan, std::int64_t time_ns) {
    ScanBlock block;
    block.header = {.node = 1,
                    .epoch = kEpoch,
                    .sequence = sequence,
                    .first_scan = first_scan,
                    .scans = 20,
                    .time_ns = time_ns};
    block.period_ps = 500'000'000;
    SealedBlock sealed;
    seal(block, sealed);
    return sealed;
  };
  const std::vector<std::pair<SealedBlock, SealedBlock>> pairs{
      {at(1, 0, 0), at(2, 20, kClockLimit_ns / 4 * 3)},
      {at(1, 0, -kClockLimit_ns), at(2, 1, kClockLimit_ns)},
      {at(1, 0, kClockLimit_ns), at(2, 1, -kClockLimit_ns)},
      {at(1, 0, -kClockLimit_ns), at(3, kIndexLimit - 20, kClockLimit_ns)},
      {at(1, 0, -kClockLimit_ns), at(3, 1, kClockLimit_ns)}};
  for (const auto& [first, second] : pairs) {
    EpochReceiver epoch(1, kEpoch, {}, {});
    std::vector<Delivery> delivered;
    epoch.block(first, kStart, delivered);
    epoch.block(second, kStart, delivered);
    epoch.crash(delivered);
    for (const Delivery& delivery : delivered) {
      const auto* gap = std::get_if<GapBlock>(&delivery);
      if (!gap) continue;
      SealedBlock sealed, read;
      seal(*gap, sealed);
      EXPECT_EQ(accept(sealed.bytes(), read), Refusal::kNone)
          << second.header.first_scan << " at " << second.header.time_ns;
    }
    EXPECT_TRUE(std::holds_alternative<GapBlock>(delivered.back()));
  }
}

TEST_F(ReceiverTest, ACrashAtTheHighestSequenceHasANumber) {
  receiver.recover(1, kEpoch, {.contiguous = kIndexLimit - 2, .next_scan = 0});
  take(beat(kIndexLimit - 1, kIndexLimit));
  for (const std::int64_t sequence : {kIndexLimit - 1, kIndexLimit}) {
    SealedBlock block = scans(1);
    block.header.sequence = sequence;
    take(block);
  }
  receiver.give_up(1, kEpoch, out);
  EXPECT_EQ(sequences(), (Sequences{kIndexLimit - 1, kIndexLimit}));
}

// The node cannot give 4 back and does not report it: the first it could give up is 3, which we hold.
TEST_F(ReceiverTest, DoesNotWaitForEverForTheBlockThatWouldTellHowMuchIsLost) {
  take(beat(1, 1));
  take(scans(1));
  SignalBlock signal;
  signal.header = {.node = 1, .epoch = kEpoch, .sequence = 3, .first_scan = 40, .time_ns = 20'000'000};
  SealedBlock sealed_signal;
  seal(signal, sealed_signal);
  take(sealed_signal);
  take(beat(3, 6), kStart);
  take(scans(5));
  take(beat(3, 6), kStart + 1900ms);
  EXPECT_EQ(sequences(), (Sequences{1}));
  take(beat(3, 6), kStart + 2s);
  ASSERT_EQ(sequences(), (Sequences{1, 2, 3}));
  EXPECT_EQ(std::get<GapBlock>(out[1]).header.scans, 0) << "nobody knows";
  take(beat(5, 6), kStart + 4s);
  ASSERT_EQ(sequences(), (Sequences{1, 2, 3, 4, 5}));
  EXPECT_EQ(std::get<GapBlock>(out[3]).header.first_scan, 20);
  EXPECT_EQ(std::get<GapBlock>(out[3]).header.scans, 60) << "of both";

  signal.header.sequence = 7;
  seal(signal, sealed_signal);
  take(sealed_signal, kStart + 4s);
  take(beat(7, 10), kStart + 4100ms);
  EXPECT_EQ(sequences().back(), 5);
  take(beat(7, 10), kStart + 4200ms);
  EXPECT_EQ(sequences(), (Sequences{1, 2, 3, 4, 5, 6, 7})) << "it has waited in vain a moment ago";
}

// Another recorder had it: the node has given everything back and reports how much there was.
TEST_F(ReceiverTest, AnEndThatSomebodyElseGotLeavesAnExactGap) {
  take(beat(1, 1));
  take(scans(1));
  Heartbeat last = beat(12, 12);
  last.state = NodeState::kEnded;
  last.scans_sampled = 190;
  take(last);
  ASSERT_EQ(sequences(), (Sequences{1, 11}));
  const auto& gap = std::get<GapBlock>(out[1]);
  EXPECT_EQ(gap.cause, GapCause::kLostAtNode);
  EXPECT_EQ(gap.header.first_scan, 20);
  EXPECT_EQ(gap.header.scans, 170);
  EXPECT_TRUE(receiver.find(1, kEpoch)->ended());
}

}  // namespace
}  // namespace roadbalance
