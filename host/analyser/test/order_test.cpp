#include <gtest/gtest.h>

#include <filesystem>
#include <fstream>
#include <vector>

#include "common/record/segment.hpp"
#include "common/record/segment_index.hpp"
#include "common/test/temporary_directory.hpp"
#include "host/analyser/durable_gate.hpp"
#include "host/recording/in_sequence.hpp"

namespace roadbalance {
namespace {

SealedBlock block(std::int32_t node, std::int64_t epoch, std::int64_t sequence) {
  SealedBlock sealed;
  sealed.header.node = node;
  sealed.header.epoch = epoch;
  sealed.header.sequence = sequence;
  return sealed;
}

std::vector<std::int64_t> seen_of(InSequence& in_sequence, const std::vector<SealedBlock>& blocks) {
  std::vector<std::int64_t> seen;
  for (const auto& b : blocks)
    in_sequence.add(b, [&](const SealedBlock& next) { seen.push_back(next.header.sequence); });
  return seen;
}

SealedBlock lost_through(std::int64_t sequence) {
  GapBlock gap;
  gap.header = {1, 7, sequence, 40, 60, 0};
  gap.cause = GapCause::kLostAtNode;
  SealedBlock sealed;
  seal(gap, sealed);
  return sealed;
}

TEST(InSequence, LetsEveryBlockThroughOnce) {
  // After a restart the recorder writes again what it had not synced.
  InSequence in_sequence;
  const auto seen = seen_of(in_sequence, {block(1, 7, 1), block(1, 7, 2), block(1, 7, 3), block(1, 8, 1),
                                          block(1, 7, 2), block(1, 7, 3), block(1, 7, 4), block(2, 7, 1)});
  EXPECT_EQ(seen, (std::vector<std::int64_t>{1, 2, 3, 1, 4, 1}));
  EXPECT_EQ(in_sequence.missing(), 0);
}

TEST(InSequence, DamageCostsWhatItHitAndIsCounted) {
  InSequence in_sequence;
  const auto seen = seen_of(in_sequence, {block(1, 7, 1), block(1, 7, 4), block(1, 7, 5)});
  EXPECT_EQ(seen, (std::vector<std::int64_t>{1, 4, 5}));
  EXPECT_EQ(in_sequence.missing(), 2);
}

TEST(InSequence, AGapOfLostBlocksStandsForThemAll) {
  InSequence in_sequence;  // blocks 3, 4 and 5 are lost
  const auto seen = seen_of(in_sequence, {block(1, 7, 1), block(1, 7, 2), lost_through(5), block(1, 7, 6)});
  EXPECT_EQ(seen, (std::vector<std::int64_t>{1, 2, 5, 6}));
  EXPECT_EQ(in_sequence.missing(), 0);
}

TEST(InSequence, WhatWasBeforeTheFirstHeardIsNotMissing) {
  InSequence in_sequence(InSequence::From::kFirstHeard);
  const auto seen = seen_of(in_sequence, {block(1, 7, 500), block(1, 7, 499), block(1, 7, 503),
                                          block(1, 8, 20), block(2, 7, 9), block(2, 7, 10)});
  EXPECT_EQ(seen, (std::vector<std::int64_t>{500, 503, 20, 9, 10}));
  EXPECT_EQ(in_sequence.missing(), 2);
}

TEST(InSequence, WhatIsDeletedOrInAnotherFolderIsNotMissing) {
  const test::TemporaryDirectory work;
  const auto missing = [&] {
    InSequence in_sequence = InSequence::of_record(work.path());
    seen_of(in_sequence, {block(1, 7, 501), block(1, 7, 503), block(2, 7, 1)});
    return in_sequence.missing();
  };
  std::ofstream(segment_path(work.path(), 1));
  EXPECT_EQ(missing(), 501);
  std::ofstream(work.path() / kContinuesFile) << "/first\n";
  EXPECT_EQ(missing(), 1);
  std::filesystem::remove(work.path() / kContinuesFile);
  std::filesystem::rename(segment_path(work.path(), 1), segment_path(work.path(), 2));
  write_index(work.path(),
              {.segment = 1, .bytes = 0, .epoch = {{{1, 7}, {.position = {.contiguous = 500}}}}});
  EXPECT_EQ(missing(), 1);
  std::filesystem::remove(index_path(work.path(), 1));
  EXPECT_EQ(missing(), 501) << "nobody knows";
}

TEST(DurableGate, LetsThroughWhatIsAcknowledgedAsDurableAndNoMore) {
  const WallTime begin{};
  DurableGate gate;
  Ack ack;
  ack.node = 1;
  ack.epoch = 5;
  ack.durable = 10;
  ack.received = 20;
  gate.acknowledge(ack, begin);
  EXPECT_TRUE(gate.passes(block(1, 5, 10).header, begin));
  EXPECT_FALSE(gate.passes(block(1, 5, 11).header, begin));
  EXPECT_FALSE(gate.passes(block(1, 6, 1).header, begin));
  EXPECT_FALSE(gate.passes(block(2, 5, 1).header, begin));
  EXPECT_TRUE(gate.passes(block(0, 0, 0).header, begin));  // what the recorder begins a segment with
  ack.durable = 4;                                         // a stale datagram
  gate.acknowledge(ack, begin);
  EXPECT_TRUE(gate.passes(block(1, 5, 10).header, begin));
}

TEST(DurableGate, OpensForAnEpochThatIsNotAcknowledgedAnyMore) {
  // A node that was killed and started again: the recorder speaks of the new epoch only.
  using std::chrono::seconds;
  const WallTime begin{};
  DurableGate gate;
  Ack ack;
  ack.node = 1;
  ack.epoch = 5;
  ack.durable = 10;
  gate.acknowledge(ack, begin);
  ack.epoch = 6;
  for (int k = 0; k < 4; ++k) gate.acknowledge(ack, begin + seconds(k));
  EXPECT_FALSE(gate.passes(block(1, 5, 11).header, begin + seconds(2)));
  EXPECT_TRUE(gate.passes(block(1, 5, 11).header, begin + seconds(4)));
  EXPECT_FALSE(gate.passes(block(1, 6, 11).header, begin + seconds(4)));
}

TEST(DurableGate, OpensForAnEpochFromBeforeItsTime) {
  using std::chrono::seconds;
  const WallTime begin{};
  DurableGate gate;
  EXPECT_FALSE(gate.passes(block(1, 5, 1).header, begin));
  EXPECT_TRUE(gate.passes(block(1, 5, 1).header, begin + seconds(4)));
}

}  // namespace
}  // namespace roadbalance
