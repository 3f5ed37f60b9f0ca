#include "common/link/receiver.hpp"

#include <gtest/gtest.h>

#include <map>

#include "common/bus/codec.hpp"
#include "common/link/test/receiver_fixture.hpp"

namespace roadbalance {
namespace {

using namespace test;
using Epochs = ReceiverFixture;

TEST_F(Epochs, ANewEpochClosesTheOldOneWithACrashGapOnceThatIsSilentForLong) {
  take(beat(1, 1));
  take(scans(1));
  take(scans(3));
  take(beat(1, 1, kEpoch + 1), kStart + 1s);
  take(beat(1, 1, kEpoch + 1), kStart + 9s);
  EXPECT_EQ(sequences(), Sequences{1}) << "the old one may only sleep";
  take(beat(1, 1, kEpoch + 1), kStart + 10s);
  ASSERT_EQ(sequences(), (Sequences{1, 2, 3, 4}));
  EXPECT_EQ(std::get<GapBlock>(out[1]).cause, GapCause::kLostAtNode);
  EXPECT_EQ(std::get<GapBlock>(out[3]).cause, GapCause::kNodeCrash);
  EXPECT_TRUE(receiver.find(1, kEpoch + 1));
  EXPECT_EQ(receiver.rival_heartbeats(), 0) << "a node that was started again is no rival";
}

// Two nodes with one number; the second one's blocks are read first.
TEST_F(Epochs, WhoWasHeldHasHeardNobodyAndCallsNobodyDead) {
  take(beat(1, 1));
  take(beat(1, 1, kEpoch + 1));
  receiver.was_held(14s);
  take(beat(1, 2, kEpoch + 1), kStart + 14s);
  EXPECT_EQ(sequences(), Sequences{});
  take(beat(1, 2), kStart + 14s);
  take(scans(1), kStart + 14s);
  EXPECT_EQ(sequences(), Sequences{1});
  take(beat(1, 2, kEpoch + 1), kStart + 24s);
  EXPECT_EQ(sequences(), (Sequences{1, 2})) << "ten seconds that were listened to";
}

// Somebody comes for its rest when it is back.
TEST_F(Epochs, LeftOpenWhatIsOnlySilentHasNotDied) {
  receiver.recover(2, kEpoch, {.contiguous = 10, .next_scan = 200});
  take(beat(1, 1));
  take(scans(1));
  take(scans(3));
  receiver.finish(kStart + 60s, true, out);
  EXPECT_EQ(sequences(), Sequences{1});
  take(beat(1, 1, kEpoch + 1), kStart + 60s);
  receiver.finish(kStart + 62s, true, out);
  ASSERT_EQ(sequences(), (Sequences{1, 2, 3, 4})) << "its node was started anew";
  EXPECT_EQ(std::get<GapBlock>(out.back()).cause, GapCause::kNodeCrash);
}

TEST_F(Epochs, GivenUpItIsClosedAsCrashedOnceAndOnlyWithoutAnEnd) {
  receiver.recover(1, kEpoch, {.contiguous = 10, .next_scan = 200});
  receiver.recover(1, kEpoch + 1, {.contiguous = 5, .next_scan = 80, .ended = true});
  for (int k = 0; k < 2; ++k)
    for (const std::int64_t epoch : {kEpoch, kEpoch + 1, kEpoch + 2}) receiver.give_up(1, epoch, out);
  ASSERT_EQ(sequences(), Sequences{11});
  EXPECT_EQ(std::get<GapBlock>(out[0]).cause, GapCause::kNodeCrash);
  EXPECT_EQ(std::get<GapBlock>(out[0]).header.epoch, kEpoch);
}

TEST_F(Epochs, RecordsTwoNodesWithOneNumberApartAndSaysSo) {
  for (int turn = 0; turn < 10; ++turn) {
    take(beat(1, 1), kStart + turn * 100ms);
    take(beat(1, 1, kEpoch + 1), kStart + turn * 100ms + 50ms);
    take(scans(turn + 1), kStart + turn * 100ms);
    take(scans(turn + 1, kEpoch + 1), kStart + turn * 100ms);
  }
  std::map<std::int64_t, Sequences> of;
  for (const auto& delivery : out) {
    const auto& header = std::get<SealedBlock>(delivery).header;
    of[header.epoch].push_back(header.sequence);
  }
  const Sequences all{1, 2, 3, 4, 5, 6, 7, 8, 9, 10};
  EXPECT_EQ(of[kEpoch], all);
  EXPECT_EQ(of[kEpoch + 1], all);
  EXPECT_TRUE(receiver.find(1, kEpoch) && receiver.find(1, kEpoch + 1));
  EXPECT_EQ(receiver.rival_heartbeats(), 18) << "all but the first of each";
  const auto acks = receiver.due(kStart + 2s);
  ASSERT_EQ(acks.size(), 2u);
  EXPECT_NE(acks[0].epoch, acks[1].epoch);
  EXPECT_NE(acks[0].number, acks[1].number);
}

TEST_F(Epochs, ContinuesARecoveredEpochBehindWhatTheRecordHolds) {
  receiver.recover(1, kEpoch, {.contiguous = 10, .next_scan = 200});
  take(beat(8, 13));
  for (std::int64_t k = 8; k <= 12; ++k) take(scans(k));
  EXPECT_EQ(sequences(), (Sequences{11, 12}));
  EXPECT_EQ(ack_at(kStart).durable, 10);
}

TEST_F(Epochs, AcksOfACrashedEpochNeverCoverWhatWasDeclared) {
  take(beat(1, 1));
  for (const std::int64_t k : {1, 2, 5}) take(scans(k));
  (void)receiver.due(kStart);
  take(beat(1, 1, kEpoch + 1), kStart + 11s);
  ASSERT_EQ(sequences(), (Sequences{1, 2, 4, 5, 6}));
  receiver.durable(1, kEpoch, 6);
  int last_acks = 0;
  for (int k = 0; k < 100; ++k)
    for (const Ack& ack : receiver.due(kStart + 11s + k * 100ms)) {
      if (ack.epoch != kEpoch) continue;
      ++last_acks;
      EXPECT_EQ(ack.received, 2);
      EXPECT_EQ(ack.durable, 2);
      EXPECT_EQ(ack.credit, 2);
      EXPECT_TRUE(ack.missing.empty());
    }
  EXPECT_EQ(last_acks, 5) << "any may be lost, but they do not go on for ever";
  // It wakes: its blocks have no place any more, and that is an alarm.
  out.clear();
  take(beat(3, 7), kStart + 30s);
  take(scans(3), kStart + 30s);
  EXPECT_TRUE(out.empty());
  EXPECT_EQ(receiver.rival_heartbeats(), 1);
  EXPECT_EQ(receiver.refused()[static_cast<std::size_t>(Receiver::Refused::kClosedEpoch)], 1);
}

SealedBlock end_of_three() {
  SealedBlock end;
  seal(EndBlock{.header = {.node = 1, .epoch = kEpoch, .sequence = 3, .first_scan = 40}, .blocks = 3}, end);
  return end;
}

TEST_F(Epochs, ACrashTakesTheNumberOfAnEndThatCameBehindAHole) {
  take(beat(1, 1));
  take(scans(1));
  take(end_of_three());
  receiver.finish(kStart + 11s, out);
  ASSERT_EQ(sequences(), (Sequences{1, 2, 3}));
  EXPECT_EQ(std::get<GapBlock>(out[1]).cause, GapCause::kLostAtNode);
  EXPECT_EQ(std::get<GapBlock>(out[2]).cause, GapCause::kNodeCrash);
}

// No node seals one; whoever sent it, the recorder must not fall over it.
TEST_F(Epochs, ACrashTakesAnEndWithBlocksBehindItForLost) {
  take(beat(1, 1));
  take(scans(1));
  take(end_of_three());
  take(scans(5));
  receiver.finish(kStart + 11s, out);
  ASSERT_EQ(sequences(), (Sequences{1, 4, 5, 6}));
  EXPECT_EQ(std::get<GapBlock>(out[1]).cause, GapCause::kLostAtNode);
  EXPECT_EQ(std::get<GapBlock>(out[3]).cause, GapCause::kNodeCrash);
}

TEST_F(Epochs, ClosesWhatAnEarlierRunLeftOpenOnceAnotherEpochHasLivedForLong) {
  receiver.recover(1, kEpoch, {.contiguous = 10, .next_scan = 200});
  take(beat(1, 1, kEpoch + 1));
  take(beat(1, 1, kEpoch + 1), kStart + 9s);
  EXPECT_TRUE(out.empty());
  take(beat(1, 1, kEpoch + 1), kStart + 10s);
  ASSERT_EQ(sequences(), Sequences{11});
  EXPECT_EQ(std::get<GapBlock>(out[0]).header.first_scan, 200);
  EXPECT_TRUE(receiver.find(1, kEpoch + 1));
}

TEST_F(Epochs, GoesOnWithARecoveredEpochThatIsOnlyLate) {
  receiver.recover(1, kEpoch, {.contiguous = 10, .next_scan = 200});
  take(beat(1, 1, kEpoch + 1));
  take(beat(11, 12), kStart + 9s);
  take(scans(11), kStart + 9s);
  take(beat(1, 1, kEpoch + 1), kStart + 11s);
  EXPECT_EQ(sequences(), Sequences{11});
}

TEST_F(Epochs, TellsANodeOfAnEndedEpochThatAllIsDurable) {
  receiver.recover(1, kEpoch, {.contiguous = 10, .next_scan = 200, .ended = true});
  Heartbeat over = beat(8, 11);
  over.state = NodeState::kEnded;
  take(over);
  EXPECT_EQ(ack_at(kStart).durable, 10);
}

TEST_F(Epochs, TellsANodeNothingOfAnEpochThatTheRecordCallsCrashed) {
  receiver.recover(1, kEpoch, {.contiguous = 10, .next_scan = 200, .ended = true, .crashed = true});
  take(beat(8, 11));
  EXPECT_TRUE(receiver.due(kStart).empty());
  EXPECT_EQ(receiver.rival_heartbeats(), 1);
}

TEST_F(Epochs, WhenItEndsItClosesTheDeadAndLeavesTheSleeping) {
  take(beat(1, 1));
  take(beat(1, 1, kEpoch + 1), kStart + 5s);
  take(scans(1, kEpoch + 1), kStart + 5s);
  receiver.finish(kStart + 14s, out);
  ASSERT_EQ(out.size(), 2u);  // the scans, and the crash of the older one
  EXPECT_EQ(std::get<GapBlock>(out[1]).header.epoch, kEpoch);
  receiver.finish(kStart + 15s, out);
  ASSERT_EQ(out.size(), 3u);
  EXPECT_EQ(std::get<GapBlock>(out[2]).header.epoch, kEpoch + 1);
}

TEST_F(Epochs, FloodsOfEpochsAndNodesStayWithinItsBounds) {
  constexpr int kForged = 10'000;
  const auto node = [](int k) { return k % 300 + 1; };
  for (int k = 0; k < kForged; ++k) {
    Heartbeat forged = beat(1, 100, kEpoch + k);
    forged.node = node(k);
    take(forged, kStart + k * 1ms);
  }
  std::map<std::int32_t, std::size_t> live;
  std::size_t live_in_all = 0;
  for (int k = 0; k < kForged; ++k) {
    if (!receiver.find(node(k), kEpoch + k)) continue;
    EXPECT_LE(++live[node(k)], Receiver::kMostLive);
    ++live_in_all;
  }
  EXPECT_GT(live_in_all, 0u);
  EXPECT_LE(live_in_all, Receiver::kMostLiveInAll);
}

// While the disk waits, newer epochs push an ended one out; received again it is no more durable than before.
TEST_F(Epochs, AnEndedEpochIsNotDurableForHavingBeenPushedOut) {
  const auto end = [](std::int64_t sequence) {
    SealedBlock sealed;
    seal(EndBlock{.header = {.node = 1, .epoch = kEpoch, .sequence = sequence, .first_scan = 20},
                  .blocks = sequence},
         sealed);
    return sealed;
  };
  take(beat(1, 3));
  take(scans(1));
  take(end(2));
  for (std::int64_t k = 1; k <= 10; ++k) take(beat(1, 1, kEpoch + k), kStart + k * 1200ms);
  Heartbeat over = beat(1, 3);
  over.state = NodeState::kEnded;
  take(over, kStart + 13s);
  for (const Ack& ack : receiver.due(kStart + 14s)) EXPECT_EQ(ack.durable, 0) << ack.epoch;
  receiver.durable(1, kEpoch, 2);
  take(beat(1, 1, kEpoch + 11), kStart + 15s);
  EXPECT_TRUE(receiver.find(1, kEpoch + 11)) << "there is room as the disk goes on";
}

TEST_F(Epochs, RecordsANodeHoweverOftenItRestarts) {
  for (int k = 0; k < 1500; ++k) {
    const std::int64_t epoch = kEpoch + k;
    take(beat(1, 1, epoch), kStart + k * 2s);
    out.clear();
    take(scans(1, epoch), kStart + k * 2s);
    ASSERT_EQ(sequences(), Sequences{1}) << "restart " << k;
  }
}

TEST_F(Epochs, ACrashGapBearsTheTimeOfItsFirstScan) {
  take(beat(1, 1));
  take(scans(1));
  take(scans(2));
  receiver.finish(kStart + 10s, out);
  const auto& crash = std::get<GapBlock>(out.back());
  EXPECT_EQ(crash.header.first_scan, 40);
  EXPECT_EQ(crash.header.time_ns, 20'000'000);  // blocks of 20 scans every 10 ms
}

}  // namespace
}  // namespace roadbalance
